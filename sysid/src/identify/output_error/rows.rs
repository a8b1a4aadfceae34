//! The linearised free run of one section, row by row:
//!
//! ```text
//! y[k] − ŷ[k; Θ, x0] = γ[k]ᵀ δx0 + o + s[k]ᵀ δΘ + e[k]          γ[k] = (C Φᵏ)ᵀ,  s[k] = ∂ŷ[k]/∂Θ
//! ```
//!
//! Each row (γ, 1, s, y − ŷ) passes through the noise model's whitening filter 1 − Σ a_j z⁻ʲ. A section's first p rows
//! only fill the filter.

use crate::model::sampled::{Coefficients, Parameter, SampledPlant};
use core::ops::Range;
use nalgebra::{Matrix4, Vector4};

/// Rows at a time, so that they stay in the cache.
const CHUNK: usize = 512;
/// A response to the initial state below this has died away; it starts at 1 or less.
const DECAYED: f64 = 1e-60;

/// Rows of one run without a hole; inputs before the rows are known back to the start of the run.
#[derive(Clone, Debug)]
pub(super) struct Section<'a> {
    /// Input of the whole run.
    pub u: &'a [f64],
    /// Output of the whole run.
    pub y: &'a [f64],
    /// The rows.
    pub rows: Range<usize>,
}

/// The sampled model and its derivatives.
pub(super) struct Sensitivities {
    own: Coefficients,
    slopes: Vec<Coefficients>,
    delay: usize,
    /// Number of states n.
    pub order: usize,
    measured: usize,
}

impl Sensitivities {
    pub fn new(sampled: &SampledPlant, angle: bool, parameters: &[Parameter]) -> Self {
        Self {
            own: sampled.coefficients(),
            slopes: parameters.iter().map(|p| sampled.slope(*p)).collect(),
            delay: sampled.delay_samples,
            order: sampled.order(angle),
            measured: sampled.measured(angle),
        }
    }

    /// Entries of a row: n + 1 + parameters + 1.
    pub fn width(&self) -> usize {
        self.order + self.slopes.len() + 2
    }

    /// Hands the whitened rows of `section` to `consume`, some at a time, one after the other.
    pub fn rows(&self, section: &Section, x0: &Vector4<f64>, ar: &[f64], consume: &mut dyn FnMut(&[f64])) {
        match self.order {
            1 => self.rows_of_order::<1>(section, x0, ar, consume),
            2 => self.rows_of_order::<2>(section, x0, ar, consume),
            3 => self.rows_of_order::<3>(section, x0, ar, consume),
            _ => self.rows_of_order::<4>(section, x0, ar, consume),
        }
    }

    fn rows_of_order<const N: usize>(
        &self,
        section: &Section,
        x0: &Vector4<f64>,
        ar: &[f64],
        consume: &mut dyn FnMut(&[f64]),
    ) {
        let (width, history) = (self.width(), ar.len());
        let mut buffer = vec![0.0; width * (history + CHUNK)];
        let mut run = Run::<N>::new(self, x0);
        let mut filled = 0;
        for k in section.rows.clone() {
            run.row(section, k, &mut buffer[filled * width..(filled + 1) * width]);
            run.advance(section, k);
            filled += 1;
            if filled == history + CHUNK {
                hand_over(&mut buffer, width, ar, filled, consume);
                filled = history;
                run.settle();
            }
        }
        hand_over(&mut buffer, width, ar, filled, consume);
    }
}

/// Whitens all but the first p of `filled` rows, hands them over, and keeps the last p as they were at the front.
fn hand_over(buffer: &mut [f64], width: usize, ar: &[f64], filled: usize, consume: &mut dyn FnMut(&[f64])) {
    let history = ar.len();
    if filled <= history {
        return;
    }
    let last = buffer[(filled - history) * width..filled * width].to_vec();
    for r in (history..filled).rev() {
        let (before, own) = buffer.split_at_mut(r * width);
        for (j, a) in ar.iter().enumerate() {
            let earlier = &before[(r - 1 - j) * width..(r - j) * width];
            for (own, earlier) in own.iter_mut().zip(earlier) {
                *own -= a * earlier;
            }
        }
    }
    consume(&buffer[history * width..filled * width]);
    buffer[..history * width].copy_from_slice(&last);
}

/// A matrix by columns.
type Columns<const N: usize> = [[f64; N]; N];

/// What one derivative adds at each step.
struct Slope<const N: usize> {
    transition: Option<Columns<N>>,
    input: [[f64; N]; 3],
    state: [f64; N],
}

/// The states of a section's free run.
struct Run<const N: usize> {
    transition: Columns<N>,
    /// Φᵀ by columns.
    transposed: Columns<N>,
    input: [[f64; N]; 3],
    x: [f64; N],
    gamma: [f64; N],
    slopes: Vec<Slope<N>>,
    delay: usize,
    measured: usize,
}

fn columns<const N: usize>(m: &Matrix4<f64>) -> Columns<N> {
    std::array::from_fn(|c| std::array::from_fn(|r| m[(r, c)]))
}

fn cut<const N: usize>(v: &Vector4<f64>) -> [f64; N] {
    std::array::from_fn(|r| v[r])
}

/// next += M x
fn add_product<const N: usize>(next: &mut [f64; N], m: &Columns<N>, x: &[f64; N]) {
    for (column, x) in m.iter().zip(x) {
        for (next, m) in next.iter_mut().zip(column) {
            *next += m * x;
        }
    }
}

fn driven<const N: usize>(input: &[[f64; N]; 3], u: &[f64; 3]) -> [f64; N] {
    std::array::from_fn(|r| input[0][r] * u[0] + input[1][r] * u[1] + input[2][r] * u[2])
}

impl<const N: usize> Run<N> {
    fn new(of: &Sensitivities, x0: &Vector4<f64>) -> Self {
        let slope = |slope: &Coefficients| Slope {
            transition: (slope.transition.amax() > 0.0).then(|| columns(&slope.transition)),
            input: slope.input.map(|g| cut(&g)),
            state: [0.0; N],
        };
        Self {
            transition: columns(&of.own.transition),
            transposed: columns(&of.own.transition.transpose()),
            input: of.own.input.map(|g| cut(&g)),
            x: cut(x0),
            gamma: std::array::from_fn(|r| if r == of.measured { 1.0 } else { 0.0 }),
            slopes: of.slopes.iter().map(slope).collect(),
            delay: of.delay,
            measured: of.measured,
        }
    }

    fn row(&self, section: &Section, k: usize, row: &mut [f64]) {
        row[..N].copy_from_slice(&self.gamma);
        row[N] = 1.0;
        for (entry, slope) in row[N + 1..].iter_mut().zip(&self.slopes) {
            *entry = slope.state[self.measured];
        }
        if let Some(last) = row.last_mut() {
            *last = section.y[k] - self.x[self.measured];
        }
    }

    fn advance(&mut self, section: &Section, k: usize) {
        // before the run its first value
        let at = |lead: usize| section.u[(k + lead).saturating_sub(self.delay + 1).min(section.u.len() - 1)];
        let u = [at(2), at(1), at(0)];
        for slope in &mut self.slopes {
            let mut next = driven(&slope.input, &u);
            add_product(&mut next, &self.transition, &slope.state);
            if let Some(transition) = &slope.transition {
                add_product(&mut next, transition, &self.x);
            }
            slope.state = next;
        }
        let mut next = driven(&self.input, &u);
        add_product(&mut next, &self.transition, &self.x);
        self.x = next;
        let mut next = [0.0; N];
        add_product(&mut next, &self.transposed, &self.gamma);
        self.gamma = next;
    }

    /// On long records a decayed response would end in denormal numbers, which are slow.
    fn settle(&mut self) {
        if self.gamma.iter().all(|g| g.abs() < DECAYED) {
            self.gamma = [0.0; N];
        }
    }
}
