//! What else a vehicle does while its pitch is looked at, drawn by a seed: it rolls and yaws, climbs and sinks, and its
//! battery empties.
//!
//! | signal | what |
//! | --- | --- |
//! | p, φ | six sines of 4 to 9 rad/s, effective value of p 0.45 rad/s; p = φ̇ (level flight) |
//! | r | six sines of 2 to 8 rad/s, effective value 0.45 rad/s |
//! | u_roll | the command that makes a nominal, rigid plant roll so, held over each tick: (Ixx ṗ − Lp p)/Lu, a delay later |
//! | T | 0.5 and six sines of 0.3 to 1.5 rad/s, effective value a fifth of that, held over each tick |
//! | V | 12.8 V + 3.8 V exp(−t / 60 s) |
//!
//! Everything is a function of the time, so effects and the log see the same motion, whatever they ask for.

use rand::RngExt;
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

use crate::aircraft::SAMPLE_PERIOD_S;
use crate::plant::Plant;
use crate::reading::{Beside, Others, RollYaw};
use crate::seeds::{Stream, generator};

/// Effective value of p and of r, rad/s: a machine that is flown about.
const RATE_RAD_S: f64 = 0.45;
/// Collective command at hover, and the effective value of its changes as a share of it.
const HOVER: f64 = 0.5;
const CLIMBS: f64 = 0.2;
/// Battery: empty, V, what a full one has beside, V, and how fast it empties, s.
const EMPTY_V: f64 = 12.8;
const CHARGE_V: f64 = 3.8;
const EMPTIES_S: f64 = 60.0;
const TONES: usize = 6;

/// One tone.
#[derive(Clone, Copy, Debug)]
struct Tone {
    omega: f64,
    phase: f64,
}

/// The surroundings of one seed.
#[derive(Clone, Debug)]
pub struct Surroundings {
    others: Others,
    rolling: [Tone; TONES],
    yawing: [Tone; TONES],
    climbing: [Tone; TONES],
    tick_s: f64,
}

impl Surroundings {
    /// Those of `others` that there are; the others are still, at hover and without a load on the battery.
    #[must_use]
    pub fn drawn(seed: u64, others: Others) -> Self {
        let mut turning = generator(seed, Stream::Effect);
        let rolling = tones(&mut turning, [4.0, 9.0]);
        let yawing = tones(&mut turning, [2.0, 8.0]);
        let climbing = tones(&mut generator(seed, Stream::Surroundings), [0.3, 1.5]);
        Self { others, rolling, yawing, climbing, tick_s: SAMPLE_PERIOD_S }
    }

    /// The same, commands held over ticks of `tick_s`.
    #[must_use]
    pub const fn held_for(self, tick_s: f64) -> Self {
        Self { tick_s, ..self }
    }

    /// Which there are.
    #[must_use]
    pub const fn others(&self) -> Others {
        self.others
    }

    /// What they are at `t`.
    #[must_use]
    pub fn at(&self, t: f64) -> Beside {
        let mut now = Beside::default();
        if self.others.roll {
            let [phi, p, _] = motion(&self.rolling, t, RATE_RAD_S);
            now.roll_yaw = RollYaw { p, phi, ..now.roll_yaw };
        }
        if self.others.yaw {
            now.roll_yaw.r = motion(&self.yawing, t, RATE_RAD_S)[1];
        }
        // the small share keeps the beginning of a tick in it
        let tick = (t / self.tick_s + 1e-6).floor() * self.tick_s;
        if self.others.roll_command {
            let plant = Plant::nominal();
            let [_, p, p_dot] = motion(&self.rolling, tick + plant.delay_s, RATE_RAD_S);
            now.u_roll = (plant.inertia_kg_m2 * p_dot - plant.dm_dq * p) / plant.dm_du;
        }
        if self.others.thrust {
            now.thrust = HOVER * (1.0 + motion(&self.climbing, tick, CLIMBS)[1]);
        }
        if self.others.battery {
            now.battery_v = EMPTY_V + CHARGE_V * (-t / EMPTIES_S).exp();
        }
        now
    }
}

fn tones(generator: &mut Pcg64, [low, high]: [f64; 2]) -> [Tone; TONES] {
    std::array::from_fn(|_| Tone {
        omega: generator.random_range(low..high),
        phase: generator.random_range(0.0..TAU),
    })
}

/// A sum of tones of that effective value between its integral without its mean and its slope, at `t`.
fn motion(tones: &[Tone; TONES], t: f64, effective: f64) -> [f64; 3] {
    let height = effective * (2.0 / TONES as f64).sqrt();
    tones.iter().fold([0.0; 3], |[integral, value, slope], tone| {
        let (sine, cosine) = (tone.omega * t + tone.phase).sin_cos();
        [integral + height * sine / tone.omega, value + height * cosine, slope - height * tone.omega * sine]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aircraft::Aircraft;
    use crate::plant::State;

    fn all() -> Surroundings {
        let others = Others { roll: true, yaw: true, roll_command: true, thrust: true, battery: true };
        Surroundings::drawn(3, others)
    }

    #[test]
    fn roll_is_the_integral_of_its_rate_and_rates_have_their_size() {
        let around = all();
        let slope = (around.at(2.0 + 1e-5).roll_yaw.phi - around.at(2.0 - 1e-5).roll_yaw.phi) / 2e-5;
        assert!((slope - around.at(2.0).roll_yaw.p).abs() < 1e-6);
        let power: f64 = (0..20_000).map(|k| around.at(f64::from(k) * 0.05).roll_yaw.r.powi(2)).sum();
        assert!(((power / 20_000.0).sqrt() / RATE_RAD_S - 1.0).abs() < 0.05);
    }

    #[test]
    fn the_roll_command_makes_the_vehicle_roll_as_it_does() {
        let around = all();
        let mut roll = Aircraft::new(Plant::nominal().rigid(), &[], None, 0);
        let (mut missed, mut power) = (0.0, 0.0);
        for k in 0..500 {
            let now = around.at(f64::from(k) * SAMPLE_PERIOD_S);
            if k == 3 {
                roll.set_state(State { q_p: now.roll_yaw.p, ..State::default() });
            }
            if k > 3 {
                missed += (roll.state().q - now.roll_yaw.p).powi(2);
                power += now.roll_yaw.p.powi(2);
            }
            roll.advance(now.u_roll);
        }
        // a command held over a tick is half a tick late: ω Ts / 2 of 0.07 at 7 rad/s
        assert!(missed < 0.01 * power, "{}", missed / power);
    }

    #[test]
    fn thrust_has_the_mean_of_hover_and_the_battery_empties() {
        let around = all();
        let thrust: Vec<f64> = (0..20_000).map(|k| around.at(f64::from(k) * 0.1).thrust).collect();
        let mean = thrust.iter().sum::<f64>() / thrust.len() as f64;
        assert!((mean / HOVER - 1.0).abs() < 0.01 && thrust.iter().all(|t| (0.1..0.9).contains(t)), "{mean}");
        let volts = [0.0, 60.0, 1e4].map(|t| around.at(t).battery_v);
        assert!(volts[0] == 16.6 && volts[1] < 14.3 && volts[2] >= 12.8);
        assert_eq!(Surroundings::drawn(3, Others::default()).at(5.0), Beside::default());
    }
}
