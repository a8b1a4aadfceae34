//! What every method answers: a linear model from the input to the measured output, in one of three forms.

use super::fir::{Fir, Piece};
use super::output_error::{self, Options};
use crate::model::plant::Plant;
use crate::model::sampled::SampledPlant;
use crate::model::state_space::StateSpace;
use nalgebra::{Complex, Matrix4};

/// A model that was found.
#[derive(Clone, Debug)]
pub enum LinearModel {
    /// Taps.
    Impulse(Fir),
    /// Sampled state space.
    Sampled(StateSpace),
    /// Grey box, with what it was fitted to.
    GreyBox(Plant, Options),
}

impl LinearModel {
    /// Free run over the rows of `piece`: from the initial state that fits them best, or, for taps, from the inputs
    /// before them. `None` for an unstable model, and one whose run overflows.
    #[must_use]
    pub fn simulate(&self, piece: &Piece) -> Option<Vec<f64>> {
        let rows = piece.rows.clone();
        match self {
            Self::Impulse(fir) => Some(fir.simulate(&piece.u[..rows.end]).split_off(rows.start)),
            Self::Sampled(model) => {
                if !model.is_stable() {
                    return None;
                }
                // the inputs before the rows are known: shift them in
                let u: Vec<f64> =
                    rows.clone().map(|k| piece.u[k.saturating_sub(model.delay_samples())]).collect();
                let prompt = StateSpace::new(
                    model.a().clone(),
                    model.b().clone(),
                    model.c().clone(),
                    model.d(),
                    model.step(),
                    0,
                );
                let prompt = prompt.ok()?;
                let x0 = prompt.initial_state(&u, &piece.y[rows]).ok()?;
                Some(prompt.simulate(&u, Some(&x0)))
            }
            Self::GreyBox(plant, options) => output_error::simulate(piece, plant, options),
        }
    }

    /// Response from the input's samples to the output's at `omega` rad/s; `None` beyond half the sampling rate `step`
    /// (s), and at a pole.
    #[must_use]
    pub fn frequency_response(&self, omega: f64, step: f64) -> Option<Complex<f64>> {
        match self {
            Self::Impulse(fir) => {
                let tap =
                    |(i, w): (usize, &f64)| Complex::cis(-omega * step * (fir.first_lag + i) as f64) * *w;
                Some(fir.taps.iter().enumerate().map(tap).sum())
            }
            Self::Sampled(model) => model.frequency_response(omega),
            Self::GreyBox(plant, options) => sampled_response(plant, options, omega, step),
        }
    }
}

/// C (zI − Φ)⁻¹ Σ_j g_j z^(1−m−j) at z = e^jωT.
fn sampled_response(plant: &Plant, options: &Options, omega: f64, step: f64) -> Option<Complex<f64>> {
    let angle = options.output == output_error::Output::Angle;
    let sampled = SampledPlant::new(plant, step, options.held_input);
    let own = sampled.coefficients();
    let z = |power: f64| Complex::cis(omega * step * power);
    let order = sampled.order(angle);
    // states behind the order are not used: they must not make the matrix singular
    let shifted = Matrix4::from_fn(|r, c| {
        let diagonal = if r == c { z(1.0) } else { Complex::from(0.0) };
        if r < order && c < order { diagonal - own.transition[(r, c)] } else { diagonal }
    });
    let mut drive = nalgebra::Vector4::from_element(Complex::from(0.0));
    for (j, g) in own.input.iter().enumerate() {
        drive += g.map(Complex::from) * z(1.0 - sampled.delay_samples as f64 - j as f64);
    }
    let response = shifted.lu().solve(&drive)?[sampled.measured(angle)];
    (response.re.is_finite() && response.im.is_finite()).then_some(response)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::hinf_match::grey_box_response;
    use crate::model::plant::Mount;

    #[test]
    fn the_grey_box_responds_as_its_transfer_function_sampled() {
        let mount = Some(Mount::from_mode(12.0, 0.3, 5e-4));
        let plant = Plant { inertia: 0.17, dm_dq: -0.4, dm_du: 25.0, delay: 0.06, mount };
        let other = grey_box_response(&plant).unwrap().sampled(0.02).unwrap();
        let own = LinearModel::GreyBox(plant, Options::default());
        for omega in [0.1, 3.0, 40.0, 150.0] {
            let expected = other.frequency_response(omega).unwrap() * Complex::cis(-omega * 0.06);
            let found = own.frequency_response(omega, 0.02).unwrap();
            assert!((found - expected).norm() < 1e-9 * expected.norm(), "{omega}");
        }
    }

    #[test]
    fn inputs_before_the_rows_are_used() {
        let fir = Fir { taps: vec![1.0, 0.5], first_lag: 2, step: 0.02 };
        let (u, y) = ([1.0, 0.0, 2.0, 0.0, 0.0, 0.0], [0.0; 6]);
        let piece = Piece { u: &u, y: &y, supervised: &[false; 6], rows: 3..6, run: 0, step: 0.02 };
        assert_eq!(LinearModel::Impulse(fir).simulate(&piece).unwrap(), vec![0.5, 2.0, 1.0]);
    }
}
