//! What a fit leaves, in the form that the tests take.

use crate::likelihood::fit::{Fit, weights};
use crate::likelihood::problem::Problem;
use crate::model::innovation_filter::InnovationFilter;
use crate::model::pitch::Output;
use crate::optim::chord::Chord;

/// Scores of blocks of this length count as independent, s: several times the memory of a vehicle in the loop.
pub const BLOCK_S: f64 = 3.0;
/// A switch of the input counts as recent for this time, s: a few time constants of servos and rotors.
const RECENT_S: f64 = 0.3;

/// What is known after a row: it decides what happens until the next.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Delayed command, corrected rate and angle, each divided by its standard deviation.
    pub signals: [f64; 3],
    /// Time since the start of the recording, s.
    pub time: f64,
    /// By how much the delayed command has changed within [`RECENT_S`], in standard deviations.
    pub moved: f64,
    /// The disturbance's moment, N m.
    pub disturbance: f64,
}

/// One run.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Of its innovations.
    pub filter: InnovationFilter,
    /// Row by row.
    pub known: Vec<Known>,
    /// Which rows count.
    pub counted: Vec<bool>,
    /// Rows in which nothing was measured; empty where there are none.
    pub unmeasured: Vec<bool>,
}

impl Stretch {
    /// Whether something was measured in row `k`.
    pub fn is_measured(&self, k: usize) -> bool {
        self.unmeasured.get(k) != Some(&true)
    }
}

/// What a fit leaves.
#[derive(Clone, Debug)]
pub struct Left {
    /// Number of measured channels.
    pub channels: usize,
    /// Innovations of the counted rows, made white: each of unit variance, the second less what the first tells of it.
    pub errors: Vec<Output>,
    /// Their derivatives with respect to every unknown of the fit, made white the same way.
    pub slopes: Vec<Vec<Output>>,
    /// What makes them white: `[a, b, c]` for (a e₁, b e₁ + c e₂).
    pub whitening: [f64; 3],
    /// The runs, in order.
    pub stretches: Vec<Stretch>,
    /// Sample period, s.
    pub step: f64,
    /// End of the last sample, s.
    pub duration: f64,
}

impl Left {
    /// Rows from one counted row to the next, in the mean, where a sensor is slower than the log.
    pub fn rows_per_reading(&self) -> f64 {
        let rows: usize = self.stretches.iter().map(|stretch| stretch.counted.len()).sum();
        let of = |stretch: &Stretch| stretch.unmeasured.iter().filter(|unmeasured| **unmeasured).count();
        let unmeasured: usize = self.stretches.iter().map(of).sum();
        rows as f64 / (rows - unmeasured).max(1) as f64
    }

    /// Of `fit`. `None` where it has no finite innovations or derivatives.
    pub fn new(problem: &Problem<'_>, fit: &Fit) -> Option<Self> {
        let residuals = problem.prediction_errors(&fit.effects);
        let coordinates = problem.coordinates(&fit.effects);
        let slopes =
            Chord::new(&residuals, problem.channels(), &coordinates, &fit.minimum.values)?.into_jacobian();
        let whitening = whitening(&fit.minimum.residuals);
        let whiten = |all: &[Output]| -> Vec<Output> { all.iter().map(|e| white(&whitening, e)).collect() };
        Some(Self {
            channels: if whitening[2] > 0.0 { 2 } else { 1 },
            errors: whiten(&fit.minimum.residuals),
            slopes: slopes.iter().map(|column| whiten(column)).collect(),
            whitening,
            stretches: stretches(problem, fit)?,
            step: problem.sizes.step,
            duration: problem.sizes.duration,
        })
    }

    /// Run and row of every counted row, with what was known before it was measured.
    pub fn rows(&self) -> impl Iterator<Item = (usize, usize, &Known)> {
        self.stretches.iter().enumerate().flat_map(|(run, stretch)| {
            let counted = (0..stretch.counted.len()).filter(|&k| stretch.counted[k]);
            counted.map(move |k| (run, k, &stretch.known[k.saturating_sub(1)]))
        })
    }

    /// For every counted row, the block that it belongs to.
    pub fn blocks(&self) -> Vec<usize> {
        let mut blocks = Vec::with_capacity(self.errors.len());
        let (mut last, mut index) = (None, 0);
        for (run, k, _) in self.rows() {
            let this = Some((run, (k as f64 * self.step / BLOCK_S) as usize));
            if last.is_some() && this != last {
                index += 1;
            }
            last = this;
            blocks.push(index);
        }
        blocks
    }

    /// One white channel.
    pub fn channel(&self, channel: usize) -> Vec<f64> {
        self.errors.iter().map(|e| e[channel]).collect()
    }
}

/// Inverse of the Cholesky factor of the innovations' covariance; zeros for a dead second channel.
pub fn whitening(residuals: &[Output]) -> [f64; 3] {
    let (inverse, _) = weights(residuals);
    match inverse.try_inverse().and_then(|s| Some((s, s.cholesky()?))) {
        Some((_, factor)) => {
            let l = factor.l();
            let (a, c) = (1.0 / l[(0, 0)], 1.0 / l[(1, 1)]);
            [a, -l[(1, 0)] * a * c, c]
        }
        None => [inverse[(0, 0)].sqrt(), 0.0, 0.0],
    }
}

/// (a e₁, b e₁ + c e₂).
pub fn white([a, b, c]: &[f64; 3], e: &Output) -> Output {
    [a * e[0], b * e[0] + c * e[1]]
}

fn stretches(problem: &Problem<'_>, fit: &Fit) -> Option<Vec<Stretch>> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let sizes = &problem.sizes;
    let mut stretches: Vec<Stretch> = Vec::with_capacity(problem.data.runs.len());
    for (run, counted) in problem.data.runs.iter().zip(&problem.counted) {
        let model = problem.model(&unpacked, run.step)?;
        let filter = model.innovation_filter(&model.gain(&unpacked.disturbance, run)?, run);
        let known = Vec::with_capacity(run.len());
        stretches.push(Stretch {
            filter,
            known,
            counted: counted.clone(),
            unmeasured: run.unmeasured.clone(),
        });
    }
    let recent = (RECENT_S / sizes.step).ceil() as usize;
    problem.track(
        &unpacked,
        |index, k, point| {
            let run = &problem.data.runs[index];
            let Stretch { filter, known, .. } = &mut stretches[index];
            let command = |k: usize| filter.command(run, k) / sizes.u;
            let (q, theta) = (point.x[0] / sizes.q, point.x[2] / sizes.theta.max(f64::MIN_POSITIVE));
            known.push(Known {
                signals: [command(k), q, theta],
                time: run.elapsed(k),
                moved: (command(k) - command(k.saturating_sub(recent))).abs(),
                disturbance: unpacked.disturbance.moment(&point.x),
            });
        },
        &mut |_, _| {},
    )?;
    Some(stretches)
}
