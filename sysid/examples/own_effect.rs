//! A catalogue with an effect of one's own: a moment that grows with the angle on one side only, as a slack cable gives.
//!
//! Makes a recording of a rig that has such a cable, and asks with the catalogue alone and with the effect added.
//! `cargo run --release -p sysid --example own_effect`

use sysid::catalogue::CATALOGUE;
use sysid::dataset::Amplitudes;
use sysid::diagnosis::diagnose_with;
use sysid::error::Error;
use sysid::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};
use sysid::recording::parse;

/// M −= k max(θ, 0).
struct SlackCable;

impl Effect for SlackCable {
    fn about(&self) -> About {
        About {
            id: "slack_cable",
            locus: Locus::PitchMoment,
            sentence: "a cable pulls on one side",
            equation: "M -= k max(theta, 0)",
            variable: "theta",
            condition: "at positive angles",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = data.moment / data.theta;
        let (lower, upper) = (1e-3 * unit, 1e3 * unit);
        vec![Parameter { name: "k", unit: "N m/rad", lower, upper, scale: Scale::Log }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1 * data.moment / data.theta], vec![data.moment / data.theta]]
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _own: &[f64], _q: f64, theta: f64, _at: &Conditions) -> f64 {
        -p[0] * theta.max(0.0)
    }
}

/// 60 s of q̇ = 100 u − 2 q − 8 max(θ, 0), per unit inertia, with a little noise.
fn recording() -> String {
    let mut text = String::from("t_s,u_N_m,q_rad_s,theta_rad\n");
    let (mut q, mut theta, mut state) = (0.0_f64, 0.0_f64, 1_u32);
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1_u32 << 24) - 0.5
    };
    let (mut u, mut next) = (0.01, 0);
    for k in 0..3000 {
        if k == next {
            u = -u;
            next += 10 + (20.0 * (random() + 0.5)) as i32;
        }
        let (rate, angle) = (q + 2e-3 * random(), theta + 2e-4 * random());
        text.push_str(&format!("{:.2},{u},{rate},{angle}\n", 0.02 * f64::from(k)));
        for _ in 0..20 {
            q += 1e-3 * (100.0 * u - 2.0 * q - 8.0 * theta.max(0.0));
            theta += 1e-3 * q;
        }
    }
    text
}

fn main() -> Result<(), Error> {
    let flown = [parse("rig.csv", recording().as_bytes(), &Default::default())?];
    let extended = [CATALOGUE, &[&SlackCable]].concat();
    for (name, catalogue) in [("the catalogue", CATALOGUE), ("with slack_cable", &extended)] {
        let found = diagnose_with(&flown, None, catalogue, &|_| ())?;
        let ids: Vec<&str> = found.answer.effects.iter().map(|effect| effect.id.as_str()).collect();
        println!("{name}: {:?} {ids:?}\n  {}\n", found.answer.verdict, found.answer.summary);
    }
    Ok(())
}
