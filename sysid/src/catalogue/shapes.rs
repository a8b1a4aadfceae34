//! Terms without a name: flexible enough to stand for physics that no catalogue lists, in one variable each.
//!
//! Each adds Σ c_i φ_i to the moment (or to the measured rate), with fixed shapes φ_i of the scaled signals
//! x = q/σ_q, y = θ/σ_θ, v = u_c/σ_u, of the time, or of their first-order lags. A named effect that is the right one
//! leaves nothing for them to explain.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};
use crate::model::pitch::Output;

/// Most shapes of one term.
const MOST: usize = 8;
const NAMES: [&str; MOST] = ["c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8"];
/// A sign change is smoothed over this share of a standard deviation.
const SHARP: f64 = 0.05;

/// Times of the lags of `memory_of_u`, s.
pub(crate) const LAGS_S: [f64; 3] = [0.06, 0.2, 0.6];
/// Deflections at which the springs of `slipping_springs` slip, in standard deviations of the angle.
pub(crate) const SLIPS: [f64; 2] = [0.2, 0.7];

/// The signals that shapes are made of, scaled by their sizes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Signals {
    /// q/σ_q.
    pub x: f64,
    /// θ/σ_θ.
    pub y: f64,
    /// u_c/σ_u.
    pub v: f64,
    /// Time as a share of the data's length.
    pub t: f64,
    /// The term's own memory.
    pub memory: [f64; 3],
}

/// A term without a name.
pub struct Shape {
    id: &'static str,
    picture: Option<Picture>,
    locus: Locus,
    variable: &'static str,
    /// As the end of "what is missing is ...".
    words: &'static str,
    count: usize,
    shapes: fn(&Signals) -> [f64; MOST],
    /// How the term's memory moves over a step of so many s.
    memory: Option<fn(&mut [f64; 3], &Signals, f64)>,
    /// Adds to the measured rate instead of the moment.
    measured: bool,
    /// Acts at given times only: says nothing of data of another time.
    pub local_in_time: bool,
}

const PLAIN: Shape = Shape {
    id: "",
    picture: None,
    locus: Locus::PitchMoment,
    variable: "",
    words: "",
    count: 0,
    shapes: |_| [0.0; MOST],
    memory: None,
    measured: false,
    local_in_time: false,
};

fn shapes<const N: usize>(some: [f64; N]) -> [f64; MOST] {
    let mut all = [0.0; MOST];
    all[..N].copy_from_slice(&some);
    all
}

fn sign(x: f64) -> f64 {
    (x / SHARP).tanh()
}

fn beyond(x: f64, edge: f64) -> f64 {
    (x.abs() - edge).max(0.0) * x.signum()
}

/// Roof functions on eight equal parts of the time.
fn roofs(t: f64) -> [f64; MOST] {
    let place = t * (MOST - 1) as f64;
    core::array::from_fn(|i| (1.0 - (place - i as f64).abs()).max(0.0))
}

/// A first-order lag of `input` over a step of `dt` s.
fn lag(state: &mut f64, input: f64, time: f64, dt: f64) {
    *state += (input - *state) * -(-dt / time).exp_m1();
}

/// A moment of one product of signals.
const fn product(
    id: &'static str,
    picture: Picture,
    variable: &'static str,
    words: &'static str,
    shapes: fn(&Signals) -> [f64; MOST],
) -> Shape {
    Shape { id, picture: Some(picture), variable, words, count: 1, shapes, ..PLAIN }
}

/// All terms without a name.
pub const SHAPES: &[&Shape] = &[
    &Shape {
        id: "of_q",
        picture: Some(Picture::Moment(Signal::Rate)),
        variable: "q",
        words: "a moment that depends on the pitch rate",
        count: 4,
        shapes: |s| shapes([sign(s.x), beyond(s.x, 0.7), s.x.abs(), s.x * s.x.abs()]),
        ..PLAIN
    },
    &Shape {
        id: "of_slow_q",
        picture: Some(Picture::Moment(Signal::Rate)),
        variable: "q",
        words: "a friction that differs between small rates and large ones",
        count: 2,
        shapes: |s| shapes([sign(s.x), sign(s.x) * (-s.x.abs() / 0.3).exp()]),
        ..PLAIN
    },
    &Shape {
        id: "of_theta",
        picture: Some(Picture::Moment(Signal::Angle)),
        variable: "theta",
        words: "a moment that depends on the pitch angle",
        count: 4,
        shapes: |s| shapes([s.y, s.y.abs(), s.y * s.y * s.y, beyond(s.y, 1.2)]),
        ..PLAIN
    },
    &Shape {
        id: "of_theta_by_side",
        picture: Some(Picture::Moment(Signal::Angle)),
        variable: "theta",
        words: "a stiffness that differs nose-up from nose-down",
        count: 2,
        shapes: |s| shapes([s.y.max(0.0), s.y.min(0.0)]),
        ..PLAIN
    },
    &Shape {
        id: "of_u",
        picture: Some(Picture::Moment(Signal::Command)),
        locus: Locus::Actuator,
        variable: "u",
        words: "a moment that is not proportional to the command",
        count: 2,
        shapes: |s| shapes([1.0, s.v.abs()]),
        ..PLAIN
    },
    &product(
        "abs_q_times_u",
        Picture::Gain(Signal::Rate),
        "|q| u",
        "an effectiveness that depends on the speed of rotation",
        |s| shapes([s.x.abs() * s.v]),
    ),
    &product(
        "q_times_abs_u",
        Picture::Damping(Signal::Command),
        "q |u|",
        "a damping that depends on the command",
        |s| shapes([s.x * s.v.abs()]),
    ),
    &product(
        "abs_theta_times_u",
        Picture::Gain(Signal::Angle),
        "|theta| u",
        "an effectiveness that depends on the angle",
        |s| shapes([s.y.abs() * s.v]),
    ),
    &product(
        "q_times_abs_theta",
        Picture::Damping(Signal::Angle),
        "q |theta|",
        "a damping that depends on the angle",
        |s| shapes([s.x * s.y.abs()]),
    ),
    &product("q_times_u", Picture::Gain(Signal::Rate), "q u", "a moment of rate and command together", |s| {
        shapes([s.x * s.v])
    }),
    &product(
        "theta_times_u",
        Picture::Gain(Signal::Angle),
        "theta u",
        "an effectiveness that differs nose-up from nose-down",
        |s| shapes([s.y * s.v]),
    ),
    &product(
        "q_times_theta",
        Picture::Damping(Signal::Angle),
        "q theta",
        "a damping that differs nose-up from nose-down",
        |s| shapes([s.x * s.y]),
    ),
    &Shape {
        id: "of_q_and_theta",
        picture: Some(Picture::Loop),
        variable: "theta",
        words: "a friction that depends on the angle",
        count: 4,
        shapes: |s| {
            let near = |angle: f64| (1.0 - (s.y - angle).abs()).max(0.0) * sign(s.x);
            shapes([near(-1.5), near(-0.5), near(0.5), near(1.5)])
        },
        ..PLAIN
    },
    &Shape {
        id: "slipping_springs",
        picture: Some(Picture::Loop),
        variable: "theta",
        words: "a spring that slips: the moment depends on where the angle turned last",
        count: 2,
        shapes: |s| shapes([s.memory[0], s.memory[1]]),
        // Stop operators (Prandtl, 1928): elastic up to a deflection, then sliding; the last entry is the angle before.
        memory: Some(|memory, s, _| {
            let moved = s.y - memory[2];
            for (stretched, slips) in memory.iter_mut().zip(SLIPS) {
                *stretched = (*stretched + moved).clamp(-slips, slips);
            }
            memory[2] = s.y;
        }),
        ..PLAIN
    },
    &Shape {
        id: "gain_over_time",
        picture: Some(Picture::Gain(Signal::Time)),
        locus: Locus::Actuator,
        variable: "t",
        words: "an effectiveness of the blades that changes over time",
        count: 7,
        shapes: |s| {
            let [_, rest @ ..] = roofs(s.t);
            shapes(rest.map(|r| r * s.v))
        },
        local_in_time: true,
        ..PLAIN
    },
    &Shape {
        id: "moment_over_time",
        picture: Some(Picture::Moment(Signal::Time)),
        locus: Locus::Environment,
        variable: "t",
        words: "a moment that depends on the time alone",
        count: 8,
        shapes: |s| roofs(s.t),
        local_in_time: true,
        ..PLAIN
    },
    &Shape {
        id: "damping_over_time",
        picture: Some(Picture::Damping(Signal::Time)),
        variable: "t",
        words: "a damping that changes over time",
        count: 7,
        shapes: |s| {
            let [_, rest @ ..] = roofs(s.t);
            shapes(rest.map(|r| r * s.x))
        },
        local_in_time: true,
        ..PLAIN
    },
    &Shape {
        id: "memory_of_u",
        picture: Some(Picture::StepResponse),
        locus: Locus::Actuator,
        variable: "u_rate",
        words: "a moment that follows the command with further lags",
        count: 3,
        shapes: |s| shapes(s.memory),
        memory: Some(|memory, s, dt| {
            for (state, time) in memory.iter_mut().zip(LAGS_S) {
                lag(state, s.v, time, dt);
            }
        }),
        ..PLAIN
    },
    &Shape {
        id: "memory_of_motion",
        variable: "theta",
        words: "a moment that depends on the motion before",
        count: 3,
        shapes: |s| shapes(s.memory),
        memory: Some(|memory, s, dt| {
            for (state, (input, time)) in memory.iter_mut().zip([(s.x, 0.2), (s.y, 0.2), (s.y, 1.0)]) {
                lag(state, input, time, dt);
            }
        }),
        ..PLAIN
    },
    &Shape {
        id: "seen_by_the_gyro",
        locus: Locus::Sensor,
        variable: "u",
        words: "a measured rate that the command shakes directly",
        count: 3,
        shapes: |s| shapes([s.memory[1], s.memory[1].abs(), s.memory[0]]),
        // A measurement is made at the end of the step: what it shows of the command is kept till then.
        memory: Some(|memory, s, dt| {
            lag(&mut memory[0], s.v, 0.03, dt);
            memory[1] = s.v;
        }),
        measured: true,
        ..PLAIN
    },
];

impl Shape {
    fn signals(&self, s: &[f64], q: f64, theta: f64, at: &Conditions) -> Signals {
        let sizes = &at.sizes;
        let memory = if self.memory.is_some() { [s[0], s[1], s[2]] } else { [0.0; 3] };
        let (x, y) = (q / sizes.q, theta / sizes.theta.max(f64::MIN_POSITIVE));
        Signals { x, y, v: at.command / sizes.u, t: at.t / sizes.duration, memory }
    }

    fn sum(&self, p: &[f64], signals: &Signals) -> f64 {
        (self.shapes)(signals).iter().zip(p).map(|(shape, c)| shape * c).sum()
    }

    /// Its curves φ_i at `signals`.
    pub fn curves(&self, signals: &Signals) -> Vec<f64> {
        (self.shapes)(signals)[..self.count].to_vec()
    }
}

impl Effect for Shape {
    fn about(&self) -> About {
        About {
            id: self.id,
            locus: self.locus,
            sentence: self.words,
            equation: self.words,
            variable: self.variable,
            condition: "as the fitted curve says",
        }
    }
    fn picture(&self) -> Option<Picture> {
        self.picture
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let (unit, size) = if self.measured { ("rad/s", data.q) } else { ("N m", data.moment) };
        let one = |&name: &&'static str| Parameter {
            name,
            unit,
            lower: -20.0 * size,
            upper: 20.0 * size,
            scale: Scale::Linear(0.02 * size),
        };
        NAMES[..self.count].iter().map(one).collect()
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.count]]
    }
    fn states(&self) -> usize {
        if self.memory.is_some() { 3 } else { 0 }
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], s: &[f64], q: f64, theta: f64, at: &Conditions) -> f64 {
        if self.measured { 0.0 } else { self.sum(p, &self.signals(s, q, theta, at)) }
    }
    fn sense(&self, _p: &[f64], s: &mut [f64], q: f64, theta: f64, _control: f64, at: &Conditions) {
        if let Some(update) = self.memory {
            let signals = self.signals(s, q, theta, at);
            let mut memory = signals.memory;
            update(&mut memory, &signals, at.dt);
            s.copy_from_slice(&memory);
        }
    }
    fn measure(&self, p: &[f64], s: &[f64], y: Output, _roll_rate: f64) -> Output {
        if !self.measured {
            return y;
        }
        let signals = Signals { memory: [s[0], s[1], s[2]], ..Signals::default() };
        [y[0] + self.sum(p, &signals), y[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::find;

    #[test]
    fn ids_are_unique_and_no_effect_of_the_catalogue_has_one() {
        for (i, term) in SHAPES.iter().enumerate() {
            assert!(SHAPES[..i].iter().all(|other| other.id != term.id));
            assert!(find(term.id).is_none() && term.count <= MOST);
            let used = (term.shapes)(&Signals { x: 0.7, y: -0.4, v: 1.0, t: 0.3, memory: [0.2, 0.3, 0.4] });
            assert!(used[term.count..].iter().all(|shape| *shape == 0.0), "{}", term.id);
        }
    }

    #[test]
    fn roofs_add_up_to_one_at_any_time() {
        for t in [0.0, 0.13, 0.5, 0.99, 1.0] {
            assert!((roofs(t).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_slipping_spring_turns_round_with_its_stiffness_and_slides_at_its_limit() {
        let term = SHAPES.iter().find(|term| term.id == "slipping_springs").unwrap();
        let update = term.memory.unwrap();
        let mut memory = [0.0; 3];
        let mut to = |y: f64| {
            update(&mut memory, &Signals { y, ..Signals::default() }, 0.02);
            memory[0]
        };
        assert_eq!(to(1.0), 0.2);
        assert!((to(0.9) - 0.1).abs() < 1e-12);
        assert_eq!(to(-1.0), -0.2);
    }
}
