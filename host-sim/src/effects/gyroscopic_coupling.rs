//! Roll and yaw couple in, in free flight: M += ΔI p r, θ̇ = q cos φ − r sin φ.
//!
//! The roll angle and the yaw rate are sums of six sines each, drawn by the seed; p = φ̇ (level flight).

use rand::RngExt;
use rand_pcg::Pcg64;
use std::cell::Cell;
use std::f64::consts::TAU;

use super::{Effect, Entry, Parameter};
use crate::plant::State;
use crate::reading::RollYaw;
use crate::seeds::{Stream, generator};

pub(super) const ENTRY: Entry = Entry {
    id: "gyroscopic_coupling",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "dI", unit: "kg m²", range: [0.05, 0.3], signed: false }],
    moderate_and_strong: [0.124, 0.192],
    near: &[],
    make: |values, seed| {
        let mut generator = generator(seed, Stream::Effect);
        let rolling = tones(&mut generator, [4.0, 9.0]);
        let yawing = tones(&mut generator, [2.0, 8.0]);
        Box::new(GyroscopicCoupling { difference: values[0], rolling, yawing, last: Cell::default() })
    },
};

/// Effective value of p and of r, rad/s: a machine that is flown about.
const RATE_RAD_S: f64 = 0.45;
const TONES: usize = 6;

/// One tone of a rate.
#[derive(Clone, Copy, Debug)]
struct Tone {
    omega: f64,
    phase: f64,
}

#[derive(Debug)]
struct GyroscopicCoupling {
    difference: f64,
    rolling: [Tone; TONES],
    yawing: [Tone; TONES],
    /// The last time that was asked for; an integration step asks several times.
    last: Cell<(f64, Option<RollYaw>)>,
}

impl GyroscopicCoupling {
    fn at(&self, t: f64) -> RollYaw {
        if let (asked, Some(known)) = self.last.get()
            && asked == t
        {
            return known;
        }
        let (p, phi) = motion(&self.rolling, t);
        let (r, _) = motion(&self.yawing, t);
        self.last.set((t, Some(RollYaw { p, r, phi })));
        RollYaw { p, r, phi }
    }
}

fn tones(generator: &mut Pcg64, [low, high]: [f64; 2]) -> [Tone; TONES] {
    std::array::from_fn(|_| Tone {
        omega: generator.random_range(low..high),
        phase: generator.random_range(0.0..TAU),
    })
}

/// Rate and its integral without its mean, at `t`.
fn motion(tones: &[Tone; TONES], t: f64) -> (f64, f64) {
    let height = RATE_RAD_S * (2.0 / TONES as f64).sqrt();
    tones.iter().fold((0.0, 0.0), |(rate, angle), tone| {
        let (sine, cosine) = (tone.omega * t + tone.phase).sin_cos();
        (rate + height * cosine, angle + height * sine / tone.omega)
    })
}

impl Effect for GyroscopicCoupling {
    fn roll_yaw(&self, t: f64) -> Option<RollYaw> {
        Some(self.at(t))
    }

    fn moment(&self, t: f64, _x: &State, _blade: f64) -> f64 {
        let RollYaw { p, r, .. } = self.at(t);
        self.difference * p * r
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{FREE, fly_freely};

    #[test]
    fn roll_is_the_integral_of_its_rate_and_rates_have_their_size() {
        let effect = (ENTRY.make)(&[0.15], 3);
        let at = |t| effect.roll_yaw(t).unwrap();
        let slope = (at(2.0 + 1e-5).phi - at(2.0 - 1e-5).phi) / 2e-5;
        assert!((slope - at(2.0).p).abs() < 1e-6);
        let power: f64 = (0..20_000).map(|k| at(f64::from(k) * 0.05).r.powi(2)).sum::<f64>() / 20_000.0;
        assert!((power.sqrt() / RATE_RAD_S - 1.0).abs() < 0.05);
    }

    #[test]
    fn rate_and_angle_are_the_integrals_of_the_coupled_equations() {
        let aircraft = fly_freely("gyroscopic_coupling", &[("dI", 0.2)], State::default(), 100);
        // the same by Simpson's rule on a grid of its own
        let effect = (ENTRY.make)(&[0.2], 0);
        let (mut q, mut theta, h) = (0.0, 0.0, 1e-3);
        let torque = |t| effect.moment(t, &State::default(), 0.0) / FREE.inertia_kg_m2;
        for k in 0..2000 {
            let t = f64::from(k) * h;
            let half = q + h / 12.0 * (torque(t) + 4.0 * torque(t + h / 4.0) + torque(t + h / 2.0));
            let next = q + h / 6.0 * (torque(t) + 4.0 * torque(t + h / 2.0) + torque(t + h));
            let angle = |t: f64, q: f64| {
                let RollYaw { r, phi, .. } = effect.roll_yaw(t).unwrap();
                q * phi.cos() - r * phi.sin()
            };
            theta += h / 6.0 * (angle(t, q) + 4.0 * angle(t + h / 2.0, half) + angle(t + h, next));
            q = next;
        }
        // the aircraft holds φ and r over its steps of 1 ms: second order
        assert!((aircraft.state().q - q).abs() < 1e-5, "{:?} {q}", aircraft.state());
        assert!((aircraft.state().theta - theta).abs() < 1e-5, "{:?} {theta}", aircraft.state());
    }
}
