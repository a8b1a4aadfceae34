//! Terms without a name, as the model file of a diagnosis carries them: Σ c_i φ_i of the scaled signals.
//!
//! ```text
//! x = q/σ_q,  y = θ/σ_θ,  v = u_c/σ_u,  s = t/duration,  sgn z = tanh(z / 0.05),  Λ_i(s) = max(0, 1 − |7 s − i|)
//! ```
//!
//! u_c: the command after the delay. States of a term's own follow the IMU. They are no physics of this simulator, and
//! nothing is concealed with them: they are here so that an extended model can be flown.

use super::{Effect, Entry, Motion, Parameter};
use crate::plant::State;
use crate::reading::Reading;

/// The terms by shape.
pub(super) const SHAPES: &[Entry] = &[
    entry("of_q", 4, |p, _| law(p, |z| [sgn(z.x), beyond(z.x, 0.7), z.x.abs(), z.x * z.x.abs()])),
    entry("of_slow_q", 2, |p, _| law(p, |z| [sgn(z.x), sgn(z.x) * (-z.x.abs() / 0.3).exp()])),
    entry("of_theta", 4, |p, _| law(p, |z| [z.y, z.y.abs(), z.y.powi(3), beyond(z.y, 1.2)])),
    entry("of_theta_by_side", 2, |p, _| law(p, |z| [z.y.max(0.0), z.y.min(0.0)])),
    Entry { locus: "actuator", ..entry("of_u", 2, |p, _| law(p, |z| [1.0, z.v.abs()])) },
    entry("abs_q_times_u", 1, |p, _| law(p, |z| [z.x.abs() * z.v])),
    entry("q_times_abs_u", 1, |p, _| law(p, |z| [z.x * z.v.abs()])),
    entry("abs_theta_times_u", 1, |p, _| law(p, |z| [z.y.abs() * z.v])),
    entry("q_times_abs_theta", 1, |p, _| law(p, |z| [z.x * z.y.abs()])),
    entry("q_times_u", 1, |p, _| law(p, |z| [z.x * z.v])),
    entry("theta_times_u", 1, |p, _| law(p, |z| [z.y * z.v])),
    entry("q_times_theta", 1, |p, _| law(p, |z| [z.x * z.y])),
    entry("of_q_and_theta", 4, |p, _| {
        law(p, |z| [-1.5, -0.5, 0.5, 1.5].map(|angle| (1.0 - (z.y - angle).abs()).max(0.0) * sgn(z.x)))
    }),
    entry("hysteresis", 2, |p, _| {
        let slip: Memory = |m, z, _| {
            let turned = z.y - m[2];
            *m = [(m[0] + turned).clamp(-0.2, 0.2), (m[1] + turned).clamp(-0.7, 0.7), z.y];
        };
        Box::new(Unlisted::new(p, |z| [z.memory[0], z.memory[1]]).with(slip))
    }),
    Entry {
        locus: "actuator",
        ..entry("gain_over_time", 7, |p, _| law(p, |z| later_roofs(z.s).map(|r| r * z.v)))
    },
    Entry { locus: "environment", ..entry("moment_over_time", 8, |p, _| law(p, |z| roofs(z.s))) },
    entry("damping_over_time", 7, |p, _| law(p, |z| later_roofs(z.s).map(|r| r * z.x))),
    Entry {
        locus: "actuator",
        ..entry("memory_of_u", 3, |p, _| {
            let follow: Memory = |m, z, dt| {
                *m = [lag(m[0], z.v, 0.06, dt), lag(m[1], z.v, 0.2, dt), lag(m[2], z.v, 0.6, dt)];
            };
            Box::new(Unlisted::new(p, |z| z.memory).with(follow))
        })
    },
    entry("memory_of_motion", 3, |p, _| {
        let follow: Memory = |m, z, dt| {
            *m = [lag(m[0], z.x, 0.2, dt), lag(m[1], z.y, 0.2, dt), lag(m[2], z.y, 1.0, dt)];
        };
        Box::new(Unlisted::new(p, |z| z.memory).with(follow))
    }),
    Entry {
        locus: "sensor",
        parameters: first(4 + 3, &OF_A_RATE),
        ..entry("seen_by_the_gyro", 3, |p, _| {
            let follow: Memory = |m, z, dt| *m = [lag(m[0], z.v, 0.03, dt), z.v, 0.0];
            let seen = Unlisted::new(p, |z| [z.memory[1], z.memory[1].abs(), z.memory[0]]).with(follow);
            Box::new(Unlisted { measured: true, ..seen })
        })
    },
];

/// Scales and coefficients of a moment; every term has the first of them.
const OF_A_MOMENT: [Parameter; 12] = [
    scale("scale_q_rad_s", "rad/s"),
    scale("scale_theta_rad", "rad"),
    scale("scale_u", "-"),
    scale("duration_s", "s"),
    coefficient("c1_N_m", "N m"),
    coefficient("c2_N_m", "N m"),
    coefficient("c3_N_m", "N m"),
    coefficient("c4_N_m", "N m"),
    coefficient("c5_N_m", "N m"),
    coefficient("c6_N_m", "N m"),
    coefficient("c7_N_m", "N m"),
    coefficient("c8_N_m", "N m"),
];

/// The same of what is added to the measured rate.
const OF_A_RATE: [Parameter; 7] = [
    scale("scale_q_rad_s", "rad/s"),
    scale("scale_theta_rad", "rad"),
    scale("scale_u", "-"),
    scale("duration_s", "s"),
    coefficient("c1_rad_s", "rad/s"),
    coefficient("c2_rad_s", "rad/s"),
    coefficient("c3_rad_s", "rad/s"),
];

const fn scale(name: &'static str, unit: &'static str) -> Parameter {
    Parameter { name, unit, range: [0.0, f64::INFINITY], signed: false }
}

const fn coefficient(name: &'static str, unit: &'static str) -> Parameter {
    Parameter { signed: true, ..scale(name, unit) }
}

const fn first(count: usize, all: &'static [Parameter]) -> &'static [Parameter] {
    all.split_at(count).0
}

const fn entry(id: &'static str, count: usize, make: fn(&[f64], u64) -> Box<dyn Effect>) -> Entry {
    let parameters = first(4 + count, &OF_A_MOMENT);
    Entry { id, locus: "pitch_moment", parameters, moderate_and_strong: [0.0; 2], near: &[], make }
}

/// How a term's memory moves over a step of so many s.
type Memory = fn(&mut [f64; 3], &Signals, f64);

/// The scaled signals, and the term's memory.
#[derive(Clone, Copy, Debug)]
struct Signals {
    x: f64,
    y: f64,
    v: f64,
    s: f64,
    memory: [f64; 3],
}

fn sgn(z: f64) -> f64 {
    (z / 0.05).tanh()
}

fn beyond(z: f64, edge: f64) -> f64 {
    z.signum() * (z.abs() - edge).max(0.0)
}

fn roofs(s: f64) -> [f64; 8] {
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|i| (1.0 - (7.0 * s - i).abs()).max(0.0))
}

fn later_roofs(s: f64) -> [f64; 7] {
    let [_, later @ ..] = roofs(s);
    later
}

/// A first-order lag of `input` over `dt`.
fn lag(state: f64, input: f64, time: f64, dt: f64) -> f64 {
    input + (state - input) * (-dt / time).exp()
}

fn law<const N: usize>(values: &[f64], shapes: fn(&Signals) -> [f64; N]) -> Box<dyn Effect> {
    Box::new(Unlisted::new(values, shapes))
}

#[derive(Debug)]
struct Unlisted<const N: usize> {
    /// σ_q, σ_θ, σ_u, duration.
    scales: [f64; 4],
    coefficients: [f64; N],
    shapes: fn(&Signals) -> [f64; N],
    follow: Option<Memory>,
    /// Adds to the measured rate instead of the moment.
    measured: bool,
    command: f64,
    memory: [f64; 3],
}

impl<const N: usize> Unlisted<N> {
    /// From scales and coefficients in the order of the parameters.
    fn new(values: &[f64], shapes: fn(&Signals) -> [f64; N]) -> Self {
        Self {
            scales: core::array::from_fn(|i| values[i].max(f64::MIN_POSITIVE)),
            coefficients: core::array::from_fn(|i| values[4 + i]),
            shapes,
            follow: None,
            measured: false,
            command: 0.0,
            memory: [0.0; 3],
        }
    }

    fn with(self, follow: Memory) -> Self {
        Self { follow: Some(follow), ..self }
    }

    fn signals(&self, t: f64, q: f64, theta: f64) -> Signals {
        let [of_q, of_theta, of_u, duration] = self.scales;
        let (x, y) = (q / of_q, theta / of_theta);
        Signals { x, y, v: self.command / of_u, s: t / duration, memory: self.memory }
    }

    fn sum(&self, signals: &Signals) -> f64 {
        (self.shapes)(signals).iter().zip(&self.coefficients).map(|(shape, c)| shape * c).sum()
    }
}

impl<const N: usize> Effect for Unlisted<N> {
    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        self.command = u;
        u
    }

    fn moment(&self, t: f64, x: &State, _blade: f64) -> f64 {
        if self.measured { 0.0 } else { self.sum(&self.signals(t, x.q, x.theta)) }
    }

    fn follow(&mut self, motion: &Motion) {
        if let Some(follow) = self.follow {
            let signals = self.signals(motion.t, motion.after.q_p, motion.after.theta_p);
            follow(&mut self.memory, &signals, motion.dt);
        }
    }

    fn measure(&mut self, t: f64, reading: &mut Reading) {
        if self.measured {
            reading.q += self.sum(&self.signals(t, reading.q, reading.theta));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;
    use crate::plant::State;

    const SCALES: [(&str, f64); 4] =
        [("scale_q_rad_s", 0.5), ("scale_theta_rad", 0.1), ("scale_u", 0.01), ("duration_s", 7.0)];

    /// The free plant with the term, from `start`, under a steady command of `u`.
    fn flown(shape: &str, coefficients: &[(&str, f64)], start: State, u: f64, ticks: usize) -> Aircraft {
        let setting = Setting::unlisted(shape, &[&SCALES[..], coefficients].concat()).unwrap();
        let mut aircraft = Aircraft::new(FREE, &[setting], None, 0);
        aircraft.set_state(start);
        (0..ticks).for_each(|_| aircraft.advance(u));
        aircraft
    }

    fn turning(q: f64) -> State {
        State { q, q_p: q, ..State::default() }
    }

    #[test]
    fn a_product_is_scaled_by_both_of_its_signals() {
        // I dq/dθ = c x |y| / q: q(θ) = q0 + c θ² / (2 I σ_q σ_θ)
        let x = flown("q_times_abs_theta", &[("c1_N_m", -0.02)], turning(0.4), 0.0, 25).state();
        let expected = 0.4 - 0.02 * x.theta.powi(2) / (2.0 * 0.1705 * 0.5 * 0.1);
        assert!(x.theta > 0.1 && (x.q - expected).abs() < 1e-9, "{x:?}");
    }

    #[test]
    fn a_curve_over_time_runs_through_its_corners() {
        // roofs of 1 s each: the third is 0 at 1 s, 1 at 2 s, and its area up to there is 1/2
        let x = flown(
            "moment_over_time",
            &[1, 2, 3, 4, 5, 6, 7, 8].map(|i| {
                let name = crate::effects::unlisted::OF_A_MOMENT[3 + i].name;
                (name, if i == 3 { 0.1 } else { 0.0 })
            }),
            State::default(),
            0.0,
            100,
        )
        .state();
        assert!((x.q - 0.05 / 0.1705).abs() < 1e-9, "{x:?}");
    }

    #[test]
    fn a_memory_lags_behind_the_command() {
        // after 0.06 s of delay: M(t) = c (1 − exp(−t/T)) u/σ_u with T = 0.2 s
        let coefficients = [("c1_N_m", 0.0), ("c2_N_m", 0.1), ("c3_N_m", 0.0)];
        let start = State::default();
        let with = flown("memory_of_u", &coefficients, start, 0.01, 50).state().q;
        let without = flown("memory_of_u", &coefficients.map(|(name, _)| (name, 0.0)), start, 0.01, 50);
        let expected = 0.1 / 0.1705 * (0.94 - 0.2 * (1.0 - (-0.94_f64 / 0.2).exp()));
        assert!((with - without.state().q - expected).abs() < 1e-3, "{with} {expected}");
    }

    #[test]
    fn the_gyro_alone_shows_what_is_only_seen_by_it() {
        let coefficients = [("c1_rad_s", 0.2), ("c2_rad_s", 0.0), ("c3_rad_s", 0.0)];
        let mut aircraft = flown("seen_by_the_gyro", &coefficients, State::default(), 0.005, 10);
        let (read, q) = (aircraft.read().q, aircraft.state().q);
        assert!((read - q - 0.2 * 0.5).abs() < 1e-12 && q > 0.0);
    }

    #[test]
    fn a_slipping_spring_holds_no_more_than_its_limits() {
        let coefficients = [("c1_N_m", -0.1), ("c2_N_m", 0.0)];
        let x = flown("hysteresis", &coefficients, turning(0.5), 0.0, 10).state();
        // slid through 0.02 rad of loading: the rest of the way against 0.2 c
        let work = 0.1 * (0.5 * 0.02 * 0.2 + (x.theta - 0.02) * 0.2);
        assert!((0.5 * 0.1705 * (0.25 - x.q * x.q) - work).abs() < 1e-5, "{x:?}");
    }

    #[test]
    fn what_is_missing_or_unknown_is_said() {
        let refused =
            |shape, values: &[(&str, f64)]| Setting::unlisted(shape, values).unwrap_err().to_string();
        assert!(refused("of_x", &SCALES).contains("of_q, of_slow_q"));
        assert!(refused("q_times_u", &SCALES).contains("`c1_N_m` (N m) is missing"));
    }
}
