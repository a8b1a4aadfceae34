//! What the parameters of effects may be in a model file: what physics allows, wider than what is searched.

use super::model_file::ANY;
use crate::legal::Legal;
use crate::model::effect::{Effect, Parameter, Scale};

/// A time constant that a step of a simulation of any use resolves, s.
const SHORTEST_S: f64 = 1e-5;
/// Eleven days, s.
const LONGEST_S: f64 = 1e6;
/// Times are those of the recording's own clock, which may count from 1970, s.
const LATEST_S: f64 = 1e10;

/// Where physics allows less than the sign and the unit say: effect, parameter, range.
const NARROWER: &[(&str, &str, [f64; 2])] = &[
    // from here on it does not swing, and the closed form has no meaning
    ("servo_second_order", "zeta", [0.0, 0.999]),
    ("structural_mode", "zeta", [0.0, 0.999]),
    ("slung_load", "zeta", [0.0, 0.999]),
    ("inflow_lag", "g", [0.0, 1.0]),
    // something must be left either way
    ("asymmetric_thrust", "a", [-0.99, 0.99]),
    // something must be left to turn, and to be seen
    ("inertia_step", "delta", [-0.99, 1e3]),
    ("gyro_scale", "s", [-0.99, 1e3]),
    ("axis_misalignment", "angle_deg", [-90.0, 90.0]),
    ("clock_skew", "epsilon", [-0.5, 0.5]),
    ("extra_delay", "Delta", [-10.0, 10.0]),
    ("voltage_droop", "n", [0.0, 100.0]),
];

/// Parameters of `effect` with what they may be.
pub(super) fn legal(effect: &dyn Effect) -> Vec<(&'static str, Legal)> {
    let parameters = effect.parameters(&ANY).into_iter().enumerate();
    parameters.map(|(i, parameter)| (parameter.name, of(effect, i, &parameter))).collect()
}

fn of(effect: &dyn Effect, i: usize, parameter: &Parameter) -> Legal {
    let Parameter { name, unit, lower, scale, .. } = *parameter;
    let own = NARROWER.iter().find(|(id, own, _)| (*id, *own) == (effect.about().id, name));
    if let Some((_, _, [low, high])) = own {
        return Legal::new(*low, *high, unit);
    }
    if effect.moments().any(|moment| moment == i) {
        return Legal::new(-LATEST_S, LATEST_S, unit);
    }
    match scale {
        _ if effect.turns() == Some(i) => Legal::any(unit),
        Scale::Log if unit == "s" && name.starts_with('T') => Legal::new(SHORTEST_S, LONGEST_S, unit),
        Scale::Log if lower > 0.0 => Legal::positive(unit),
        _ if lower >= 0.0 => Legal::not_negative(unit),
        _ => Legal::any(unit),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::{CATALOGUE, find, scaled_shape};
    use crate::dataset::Amplitudes;

    /// Signals of a small racing craft at 1 kHz, of a bench, and of a ship.
    const SIZES: [Amplitudes; 3] = [
        Amplitudes {
            inertia: 1.0,
            u: 0.1,
            q: 5.0,
            theta: 1.0,
            turned: 40.0,
            angles: [0.0; 3],
            moment: 500.0,
            moves: 0.0,
            step: 1e-3,
            duration: 60.0,
            rate_limit: None,
        },
        Amplitudes {
            inertia: 1.0,
            u: 0.015,
            q: 0.3,
            theta: 0.1,
            turned: 0.8,
            angles: [0.0; 3],
            moment: 0.345,
            moves: 0.0,
            step: 0.02,
            duration: 90.0,
            rate_limit: None,
        },
        Amplitudes {
            inertia: 1.0,
            u: 10.0,
            q: 1e-3,
            theta: 0.02,
            turned: 0.1,
            angles: [0.0; 3],
            moment: 1e4,
            moves: 0.0,
            step: 0.1,
            duration: 36e3,
            rate_limit: None,
        },
    ];

    #[test]
    fn what_a_diagnosis_may_find_can_be_read_back() {
        for &effect in CATALOGUE {
            for sizes in &SIZES {
                for (p, (name, legal)) in effect.parameters(sizes).iter().zip(legal(effect)) {
                    let id = effect.about().id;
                    for end in [p.lower, p.upper] {
                        assert!(legal.holds(end), "{id}.{name}: {end} is searched, legal is {legal}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_narrower_range_is_of_a_parameter_that_there_is() {
        for (id, name, _) in NARROWER {
            let effect = find(id).unwrap_or_else(|| panic!("{id}"));
            assert!(legal(effect).iter().any(|(own, _)| own == name), "{id}.{name}");
        }
    }

    #[test]
    fn what_no_physics_allows_is_not_legal() {
        let of = |id: &str, name: &str| {
            let all = legal(find(id).unwrap());
            all.into_iter().find(|(own, _)| *own == name).unwrap().1
        };
        for (id, name, value) in [
            ("coulomb_friction", "Mc", -0.1),
            ("servo_lag", "T", 0.0),
            ("gyro_lag", "T", 1e-6),
            ("trim_offset", "M0", 1e300),
            ("servo_second_order", "zeta", 1.0),
            ("inertia_step", "delta", -1.0),
            ("hysteresis", "k", 0.0),
            ("moment_step", "t0", f64::NAN),
        ] {
            assert!(!of(id, name).holds(value), "{id}.{name} = {value}");
        }
        assert!(of("periodic_moment", "phase").holds(-0.3) && of("moment_step", "t0").holds(1.7e9));
        let scales = legal(scaled_shape::find("of_q").unwrap());
        assert!(scales.iter().all(|(name, legal)| legal.holds(0.0) == name.starts_with('c')));
    }
}
