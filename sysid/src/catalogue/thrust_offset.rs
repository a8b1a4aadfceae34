//! The collective thrust acts beside the centre of gravity.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M += c (T − T̄)/T̄, T the collective thrust and T̄ its mean; what T̄ itself makes is a trim moment of the same c, if nothing
/// else does.
pub struct ThrustOffset;

impl Effect for ThrustOffset {
    fn about(&self) -> About {
        About {
            id: "thrust_offset",
            locus: Locus::Actuator,
            sentence: "the collective thrust acts beside the centre of gravity",
            equation: "M += c (T - T_mean)/T_mean",
            variable: "thrust",
            condition: "in proportion to the collective thrust",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Thrust))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let reach = 20.0 * data.moment;
        vec![Parameter {
            name: "c",
            unit: "N m",
            lower: -reach,
            upper: reach,
            scale: Scale::Linear(0.1 * data.moment),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.varies(|beside| beside.thrust.as_deref())
    }
    fn moves_the_mean(&self) -> bool {
        true
    }
    fn forcing(&self, p: &[f64], at: &Conditions) -> f64 {
        p[0] * at.thrust
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_less_thrust_is_a_tenth_of_c_less() {
        let at = Conditions { thrust: -0.1, ..Conditions::default() };
        assert!((ThrustOffset.forcing(&[0.3], &at) + 0.03).abs() < 1e-15);
    }
}
