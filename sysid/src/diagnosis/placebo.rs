//! A placebo: a term as large as what was found, which nothing calls for.
//!
//! ```text
//! M += Σ c_i sin(ω_i t + φ_i),   ω_i = 0.5·20^frac(i/ϕ) rad/s,   φ_i = 2π frac(i√2),   ϕ = (1 + √5)/2
//! ```
//!
//! Fitted and judged like the effects, with as many coefficients c_i as they have parameters. What it gains is what any
//! term of that size gains.

use crate::dataset::Amplitudes;
use crate::likelihood::fit::{Fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};
use core::f64::consts::TAU;

const NAMES: [&str; 12] = ["c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8", "c9", "c10", "c11", "c12"];

/// With 1, 2, ... coefficients.
static PLACEBOS: [Placebo; NAMES.len()] = {
    let mut all = [const { Placebo { count: 0 } }; NAMES.len()];
    let mut i = 0;
    while i < all.len() {
        all[i].count = i + 1;
        i += 1;
    }
    all
};

/// Sines of arbitrary frequencies.
struct Placebo {
    count: usize,
}

/// `baseline` with a placebo of as many parameters as the effects of `extended` have (twelve at most). `None` where there
/// are none.
pub fn placebo(problem: &Problem<'_>, baseline: &Fit, extended: &Fit) -> Option<Fit> {
    let parameters: usize = extended.effects.iter().map(|e| e.parameters(&problem.sizes).len()).sum();
    let term: &'static dyn Effect = &PLACEBOS[parameters.min(PLACEBOS.len()).checked_sub(1)?];
    let mut start = baseline.minimum.values.clone();
    start.resize(start.len() + term.parameters(&problem.sizes).len(), 0.0);
    refit(problem, &[term], &start)
}

impl Effect for Placebo {
    fn about(&self) -> About {
        About {
            id: "placebo",
            locus: Locus::Environment,
            sentence: "sines of arbitrary frequencies",
            equation: "M += sum c_i sin(omega_i t + phi_i)",
            variable: "t",
            condition: "never",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let one = |&name: &&'static str| Parameter {
            name,
            unit: "N m",
            lower: -20.0 * data.moment,
            upper: 20.0 * data.moment,
            scale: Scale::Linear(0.02 * data.moment),
        };
        NAMES[..self.count].iter().map(one).collect()
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.count]]
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, _theta: f64, at: &Conditions) -> f64 {
        let golden = (1.0 + 5f64.sqrt()) / 2.0;
        let sine = |i: usize| {
            let omega = 0.5 * 20f64.powf((i as f64 / golden).fract());
            (omega * at.t + TAU * (i as f64 * core::f64::consts::SQRT_2).fract()).sin()
        };
        p.iter().enumerate().map(|(i, c)| c * sine(i + 1)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placebo_has_as_many_coefficients_as_asked_and_moves_with_the_time_alone() {
        let sizes = Amplitudes { moment: 1.0, ..Amplitudes::default() };
        for (i, placebo) in PLACEBOS.iter().enumerate() {
            assert_eq!(placebo.parameters(&sizes).len(), i + 1);
            let moment = |t: f64, q: f64| {
                placebo.moment(&vec![1.0; i + 1], &[], q, q, &Conditions { t, ..Conditions::default() })
            };
            assert_eq!(moment(3.0, 0.0), moment(3.0, 1.0));
            assert!((moment(3.0, 0.0) - moment(3.5, 0.0)).abs() > 1e-3);
        }
    }
}
