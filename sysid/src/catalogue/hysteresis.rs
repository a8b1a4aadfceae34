//! Friction that yields elastically before it slides.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale};

/// M −= Mh z, ż = (k/Mh) (q − |q| z): the model of Bouc and Wen (Wen, Journal of the Engineering Mechanics Division 102,
/// 1976) with exponent 1, which is that of Dahl (Aerospace Corporation TOR-0158, 1968). A spring of stiffness k after each
/// turn of the motion, friction Mh once it slides; the stiffer the spring, the nearer to `coulomb_friction`.
pub struct Hysteresis;

/// z after a step of `dt` s at the rate `q`, exactly.
fn slipped(p: &[f64], z: f64, q: f64, dt: f64) -> f64 {
    let end = if q < 0.0 { -1.0 } else { 1.0 };
    end + (z - end) * (-p[1] / p[0] * q.abs() * dt).exp()
}

impl Effect for Hysteresis {
    fn about(&self) -> About {
        About {
            id: "hysteresis",
            locus: Locus::PitchMoment,
            sentence: "the pivot (or a cable) yields elastically before it slips, with a hysteresis",
            equation: "M -= Mh z, dz/dt = (k/Mh) (q - |q| z)",
            variable: "theta",
            condition: "after each turn of the motion, for as long as the pivot yields",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Dahl, 1968; Bouc, 1967; Wen, 1976")
    }
    fn generalises(&self, other: &dyn Effect) -> bool {
        other.about().id == "coulomb_friction"
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Loop)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = data.moment / data.theta;
        vec![
            Parameter {
                name: "Mh",
                unit: "N m",
                lower: 1e-3 * data.moment,
                upper: 3.0 * data.moment,
                scale: Scale::Log,
            },
            Parameter {
                name: "k",
                unit: "N m/rad",
                lower: 0.03 * unit,
                upper: 1000.0 * unit,
                scale: Scale::Log,
            },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let unit = data.moment / data.theta;
        [0.3, 2.0, 20.0].map(|share| vec![0.15 * data.moment, share * unit]).to_vec()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.moves_both_ways()
    }
    fn states(&self) -> usize {
        1
    }
    fn within_sample(&self) -> bool {
        true
    }
    /// In the middle of the step.
    fn moment(&self, p: &[f64], s: &[f64], q: f64, _theta: f64, at: &Conditions) -> f64 {
        -p[0] * slipped(p, s[0], q, 0.5 * at.dt)
    }
    fn follow(&self, p: &[f64], s: &mut [f64], q: f64, _theta: f64, at: &Conditions) {
        s[0] = slipped(p, s[0], q, at.dt);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_spring_after_a_turn_and_friction_beyond() {
        let p = [0.05, 2.0];
        let at = Conditions { dt: 0.01, ..Conditions::default() };
        let mut s = [0.0];
        let mut turned = |q: f64, steps: usize| {
            for _ in 0..steps {
                Hysteresis.follow(&p, &mut s, q, 0.0, &at);
            }
            Hysteresis.moment(&p, &s, 0.0, 0.0, &at)
        };
        // from rest by the angle x: Mh (1 − exp(−k x / Mh))
        let x = 0.1 * 0.01 * 10.0;
        assert!((turned(0.1, 10) + 0.05 * (1.0 - (-2.0 * x / 0.05_f64).exp())).abs() < 1e-12);
        assert!((turned(0.3, 1000) + 0.05).abs() < 1e-9);
        // back by a little, at twice the stiffness
        assert!((turned(-1e-3, 1) + 0.05 - 2.0 * 2.0 * 1e-5).abs() < 1e-7);
        assert!((turned(-0.3, 1000) - 0.05).abs() < 1e-9);
    }
}
