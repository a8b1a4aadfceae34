//! Effects of the catalogue concealed in recordings by a small simulator of its own, and found again by the diagnosis.
//!
//! The simulator knows nothing of the crate's model: Heun's rule over 1 ms, every effect as its equation says.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;
use sysid::catalogue::find;
use sysid::dataset::Dataset;
use sysid::diagnosis::answer::{Answer, Verdict};
use sysid::diagnosis::diagnose;
use sysid::model::baseline::Baseline;
use sysid::model::file::ModelFile;
use sysid::recording::{ReadOptions, Recording, parse};

const INERTIA: f64 = 0.17;
const DAMPING: f64 = 0.3;
const GAIN: f64 = 23.0;
/// Steps of 1 ms.
const DELAY: usize = 60;
const SAMPLE: usize = 20;
const DT: f64 = 1e-3;
const DURATION_S: usize = 60;
/// Standard deviations of the sensors' noise, rad/s and rad.
const NOISE: [f64; 2] = [6e-3, 1.5e-3];

/// What an effect may depend on.
#[derive(Clone, Copy, Default)]
struct Now {
    t: f64,
    /// Delayed command and the one a step before.
    u: f64,
    u_before: f64,
    u_roll: f64,
    p: f64,
    thrust: f64,
    volts: f64,
    q: f64,
    theta: f64,
}

/// An effect: what the blades do, the moment on the airframe, what the sensors show; all of them once a step.
trait Concealed {
    fn blade(&mut self, now: &Now) -> f64 {
        now.u
    }
    fn moment(&self, _now: &Now) -> f64 {
        0.0
    }
    /// Moves on, at the end of a step over which the rate changed by `dq`.
    fn follow(&mut self, _now: &Now, _dq: f64) {}
    fn shown(&self, now: &Now) -> [f64; 2] {
        [now.q, now.theta]
    }
}

struct Moment<F: Fn(&Now) -> f64>(F);

impl<F: Fn(&Now) -> f64> Concealed for Moment<F> {
    fn moment(&self, now: &Now) -> f64 {
        (self.0)(now)
    }
}

struct Blade<F: FnMut(&Now) -> f64>(F);

impl<F: FnMut(&Now) -> f64> Concealed for Blade<F> {
    fn blade(&mut self, now: &Now) -> f64 {
        (self.0)(now)
    }
}

struct Shown<F: Fn(&Now) -> [f64; 2]>(F);

impl<F: Fn(&Now) -> [f64; 2]> Concealed for Shown<F> {
    fn shown(&self, now: &Now) -> [f64; 2] {
        (self.0)(now)
    }
}

/// Mh, k and the state z.
struct BoucWen(f64, f64, f64);

impl Concealed for BoucWen {
    fn moment(&self, _now: &Now) -> f64 {
        -self.0 * self.2
    }
    fn follow(&mut self, now: &Now, _dq: f64) {
        self.2 += DT * self.1 / self.0 * (now.q - now.q.abs() * self.2);
    }
}

/// ω, ζ, share, and how far the load is ahead, with its rate.
struct Load(f64, f64, f64, [f64; 2]);

impl Concealed for Load {
    fn moment(&self, _now: &Now) -> f64 {
        let Load(omega, zeta, share, [ahead, rate]) = self;
        share * INERTIA * (omega * omega * ahead + 2.0 * zeta * omega * rate)
    }
    fn follow(&mut self, _now: &Now, dq: f64) {
        let Load(omega, zeta, _, [ahead, rate]) = self;
        *rate += -dq - DT * (*omega * *omega * *ahead + 2.0 * *zeta * *omega * *rate);
        *ahead += DT * *rate;
    }
}

/// T, the angle as it is shown, and the angle.
struct Trailing(f64, f64, f64);

impl Concealed for Trailing {
    fn follow(&mut self, now: &Now, _dq: f64) {
        let Trailing(time, shown, before) = self;
        lagged(shown, 0.5 * (*before + now.theta), *time);
        *before = now.theta;
    }
    fn shown(&self, now: &Now) -> [f64; 2] {
        [now.q, self.1]
    }
}

/// A signal that switches between ± its size after 0.2 to 0.9 s.
struct Switching {
    level: f64,
    left: usize,
}

impl Switching {
    fn next(&mut self, random: &mut Pcg64) -> f64 {
        if self.left == 0 {
            self.level = -self.level;
            self.left = SAMPLE * random.random_range(10..45);
        }
        self.left -= 1;
        self.level
    }
}

fn normal(random: &mut Pcg64) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (TAU * random.random::<f64>()).cos()
}

/// A flight with `concealed`; with the columns beside the pitch axis or without.
fn flown(seed: u64, beside: bool, concealed: &mut dyn Concealed) -> Recording {
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut pitch, mut roll) = (Switching { level: 0.012, left: 0 }, Switching { level: 0.01, left: 130 });
    let mut text = String::from("t_s,u_rad,q_rad_s,theta_rad");
    text.push_str(if beside { ",p_rad_s,u_roll_rad,thrust_norm,battery_v\n" } else { "\n" });
    let (mut now, mut sent, mut rough) = (Now::default(), vec![0.0; DELAY], 0.0);
    let mut commanded = 0.0;
    for step in 0..DURATION_S * 1000 {
        now.t = DT * step as f64;
        let (excitation, u_roll) = (pitch.next(&mut random), roll.next(&mut random));
        if step % SAMPLE == 0 {
            let [q, theta] = concealed.shown(&now);
            let [q, theta] = [q + NOISE[0] * normal(&mut random), theta + NOISE[1] * normal(&mut random)];
            // an operator who keeps the angle small
            commanded = excitation - 0.02 * theta;
            now.u_roll = u_roll;
            now.thrust = 0.5 + 0.1 * (0.4 * now.t).sin() + 0.06 * (0.91 * now.t).sin();
            now.volts = 12.6 - 1.5 * (0.05 * now.t).sin();
            text.push_str(&format!("{:.3},{commanded},{q},{theta}", now.t));
            if beside {
                let Now { p, u_roll, thrust, volts, .. } = now;
                text.push_str(&format!(",{p},{u_roll},{thrust},{volts}"));
            }
            text.push('\n');
        }
        now.u_before = now.u;
        now.u = sent[step % DELAY];
        sent[step % DELAY] = commanded;
        rough += DT * -3.0 * rough + 0.05 * DT.sqrt() * normal(&mut random);
        let control = GAIN * concealed.blade(&now);
        let slope = |now: &Now| (control + concealed.moment(now) + 0.2 * rough - DAMPING * now.q) / INERTIA;
        let first = slope(&now);
        let ahead = Now { q: now.q + DT * first, theta: now.theta + DT * now.q, ..now };
        let dq = 0.5 * DT * (first + slope(&ahead));
        now.theta += DT * (now.q + 0.5 * dq);
        now.q += dq;
        now.p += DT * (135.0 * u_roll - 2.0 * now.p);
        concealed.follow(&now, dq);
    }
    parse("flight.csv", text.as_bytes(), &ReadOptions::default()).expect("the recording is well formed")
}

fn model() -> ModelFile {
    let text = format!(
        "[plant]\ninertia_kg_m2 = {INERTIA}\ndelay_s = {}\ndM_dq_N_m_s = -{DAMPING}\ndM_du_N_m = {GAIN}\n",
        DT * DELAY as f64
    );
    sysid::model::file::parse("model.toml", &text, None, &[]).expect("the model is well formed")
}

fn answer(recording: Recording) -> Answer {
    diagnose(&[recording], Some(&model()), &|_| ()).expect("it can be diagnosed").answer
}

/// The diagnosis names `id` first, with each of `truth` within its interval, widened by its half on both sides; what else it
/// names must be in `others`.
fn finds(id: &str, truth: &[(&str, f64)], others: &[&str], concealed: &mut dyn Concealed) {
    let found = answer(flown(7, true, concealed));
    println!("{id}: {:?} {}", found.verdict, found.summary);
    assert_eq!(found.verdict, Verdict::Named, "{id}: {}", found.summary);
    assert_eq!(found.effects[0].id, id, "{}", found.summary);
    for effect in &found.effects[1..] {
        assert!(others.contains(&effect.id.as_str()), "{id}: {}", found.summary);
    }
    covers(&found, id, truth);
}

/// Whether the effect `id` is named with each of `truth` within its interval, widened by its half on both sides.
fn covers(found: &Answer, id: &str, truth: &[(&str, f64)]) {
    let effect = found.effects.iter().find(|effect| effect.id == id).expect("it is named");
    for (name, truth) in truth {
        let parameter = effect.parameters.iter().find(|p| p.name == *name).expect("it is told");
        let [low, high] = parameter.ci95;
        let slack = 0.5 * (high - low);
        println!("  {name} {truth}: {} [{low}, {high}]", parameter.value);
        assert!((low - slack..=high + slack).contains(truth), "{id}.{name}: {parameter:?} for {truth}");
    }
}

/// A first-order lag over one step: its mean.
fn lagged(state: &mut f64, input: f64, time: f64) -> f64 {
    let before = *state;
    *state += (input - *state) * -(-DT / time).exp_m1();
    0.5 * (before + *state)
}

/// Smooth enough for Heun's rule: the sign of a rate.
fn sign(q: f64) -> f64 {
    (q / 2e-3).tanh()
}

#[test]
fn stribeck_friction() {
    let (mc, ms, qs) = (0.03, 0.12, 0.1);
    let mut concealed = Moment(|now: &Now| -(mc + (ms - mc) * (-(now.q / qs).powi(2)).exp()) * sign(now.q));
    finds("stribeck_friction", &[("Mc", mc), ("Ms", ms), ("qs", qs)], &[], &mut concealed);
}

/// It is dry friction of the mean beside a constant moment, to the bit: it is told as undecided between the two readings.
#[test]
fn asymmetric_friction() {
    let (up, down) = (0.1, 0.03);
    let mut concealed = Moment(|now: &Now| if now.q > 0.0 { -up } else { down } * sign(now.q).abs());
    let found = answer(flown(7, true, &mut concealed));
    println!("{:?} {}", found.verdict, found.summary);
    assert_eq!(found.verdict, Verdict::Ambiguous, "{}", found.summary);
    covers(&found, "coulomb_friction", &[("Mc", 0.5 * (up + down))]);
    let rivals = &found.effects[0].alternatives;
    assert!(rivals.iter().any(|rival| rival.id == "asymmetric_friction"), "{}", found.summary);
    assert!(found.summary.contains("trim_offset"), "{}", found.summary);
}

#[test]
fn plain_friction_stays_plain() {
    let mut concealed = Moment(|now: &Now| -0.07 * sign(now.q));
    finds("coulomb_friction", &[("Mc", 0.07)], &[], &mut concealed);
}

#[test]
fn hysteresis() {
    finds("hysteresis", &[("Mh", 0.08), ("k", 1.2)], &[], &mut BoucWen(0.08, 1.2, 0.0));
}

#[test]
fn servo_second_order() {
    let (f_hz, zeta) = (5.0, 0.2);
    let omega = TAU * f_hz;
    let (mut u, mut rate) = (0.0, 0.0);
    let mut concealed = Blade(move |now: &Now| {
        // half a step before and behind the rate's
        let before = u;
        u += 0.5 * DT * rate;
        let loss = zeta * omega * DT;
        rate = (rate * (1.0 - loss) + DT * omega * omega * (now.u - u)) / (1.0 + loss);
        u += 0.5 * DT * rate;
        0.5 * (before + u)
    });
    finds("servo_second_order", &[("f_hz", f_hz), ("zeta", zeta)], &[], &mut concealed);
}

#[test]
fn asymmetric_servo() {
    let (up, down) = (0.04, 0.12);
    let mut u = 0.0;
    let mut concealed = Blade(move |now: &Now| {
        let time = if now.u > u { up } else { down };
        lagged(&mut u, now.u, time)
    });
    finds("asymmetric_servo", &[("T_up", up), ("T_down", down)], &[], &mut concealed);
}

#[test]
fn plain_lag_stays_plain() {
    let mut u = 0.0;
    let mut concealed = Blade(move |now: &Now| lagged(&mut u, now.u, 0.08));
    finds("servo_lag", &[("T", 0.08)], &[], &mut concealed);
}

#[test]
fn moment_step_that_goes() {
    let mut concealed = Moment(|now: &Now| if (21.3..38.7).contains(&now.t) { 0.06 } else { 0.0 });
    finds("moment_step", &[("M0", 0.06), ("t0", 21.3), ("t1", 38.7)], &[], &mut concealed);
}

#[test]
fn moment_step_that_stays() {
    let mut concealed = Moment(|now: &Now| if now.t > 27.1 { -0.06 } else { 0.0 });
    finds("moment_step", &[("M0", -0.06), ("t0", 27.1)], &[], &mut concealed);
}

#[test]
fn long_data_are_searched_in_part_and_answered_whole() {
    let flights: Vec<Recording> = (1..=4)
        .map(|seed| {
            let step = |now: &Now| if now.t > 27.1 { -0.06 } else { 0.0 };
            flown(seed, false, &mut Moment(|now: &Now| step(now) - 0.07 * sign(now.q)))
        })
        .collect();
    let found = diagnose(&flights, Some(&model()), &|_| ()).expect("it can be diagnosed").answer;
    println!("{:?} {}", found.verdict, found.summary);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.summary);
    assert_eq!(found.effects.len(), 2, "{}", found.summary);
    covers(&found, "coulomb_friction", &[("Mc", 0.07)]);
    covers(&found, "moment_step", &[("t0", 27.1), ("M0", -0.06)]);
}

#[test]
fn slung_load() {
    let (f_hz, share, zeta) = (0.6, 0.15, 0.04);
    let truth = [("f_hz", f_hz), ("share", share), ("zeta", zeta)];
    finds("slung_load", &truth, &[], &mut Load(TAU * f_hz, zeta, share, [0.0; 2]));
}

#[test]
fn unilateral_spring() {
    let (k, theta_0) = (1.0, -0.08);
    let mut concealed = Moment(|now: &Now| k * (theta_0 - now.theta).max(0.0));
    finds("unilateral_spring", &[("k", k), ("theta_0", theta_0)], &[], &mut concealed);
}

#[test]
fn cross_feed() {
    let mut concealed = Moment(|now: &Now| 3.0 * now.u_roll);
    finds("cross_feed", &[("c", 3.0)], &[], &mut concealed);
}

#[test]
fn axis_misalignment() {
    let (sin, cos) = 6.0_f64.to_radians().sin_cos();
    let mut concealed = Shown(move |now: &Now| [now.q * cos + now.p * sin, now.theta]);
    finds("axis_misalignment", &[("angle_deg", 6.0)], &[], &mut concealed);
}

#[test]
fn rotor_reaction() {
    let mut concealed = Moment(|now: &Now| 1.5 * (now.u - now.u_before) / DT);
    finds("rotor_reaction", &[("Jr", 1.5)], &[], &mut concealed);
}

#[test]
fn asymmetric_thrust() {
    for a in [0.24, -0.15] {
        let mut concealed = Blade(move |now: &Now| now.u + a * now.u.abs());
        finds("asymmetric_thrust", &[("a", a)], &[], &mut concealed);
    }
}

#[test]
fn thrust_dependence() {
    let mut concealed = Blade(|now: &Now| now.u * (1.0 + 0.7 * (now.thrust - 0.5) / 0.5));
    finds("thrust_dependence", &[("k", 0.7)], &[], &mut concealed);
}

#[test]
fn thrust_offset() {
    for c in [0.15, -0.06] {
        let mut concealed = Moment(move |now: &Now| c * (now.thrust - 0.5) / 0.5);
        finds("thrust_offset", &[("c", c)], &[], &mut concealed);
    }
}

#[test]
fn periodic_moment() {
    let (amplitude, f_hz, phase) = (0.02, 1.83, 0.2);
    let mut concealed = Moment(|now: &Now| amplitude * (TAU * f_hz * now.t + phase).sin());
    finds("periodic_moment", &[("amplitude", amplitude), ("f_hz", f_hz)], &[], &mut concealed);
}

#[test]
fn cogging() {
    let (amplitude, n, phase) = (0.05, 42.0, 0.7);
    let mut concealed = Moment(|now: &Now| amplitude * (n * now.theta + phase).sin());
    finds("cogging", &[("amplitude", amplitude), ("n", n), ("phase", phase)], &[], &mut concealed);
}

#[test]
fn encoder_error() {
    let (amplitude, n, phase) = (0.006, 35.0, 2.1);
    let mut concealed = Shown(|now: &Now| [now.q, now.theta + amplitude * (n * now.theta + phase).sin()]);
    finds("encoder_error", &[("amplitude", amplitude), ("n", n), ("phase", phase)], &[], &mut concealed);
}

#[test]
fn voltage_droop() {
    let mut concealed = Blade(|now: &Now| now.u * (now.volts / 11.7).powf(2.0));
    finds("voltage_droop", &[("n", 2.0)], &["effectiveness_fade"], &mut concealed);
}

#[test]
fn angle_lag() {
    finds("angle_lag", &[("T", 0.09)], &[], &mut Trailing(0.09, 0.0, 0.0));
}

#[test]
fn angle_skew() {
    for delta in [0.012, -0.012] {
        let mut concealed = Shown(move |now: &Now| [now.q, now.theta - delta * now.q]);
        finds("angle_skew", &[("delta", delta)], &[], &mut concealed);
    }
}

#[test]
fn nothing_is_found_where_nothing_is_concealed() {
    let found = answer(flown(7, true, &mut Moment(|_: &Now| 0.0)));
    assert!(found.effects.is_empty(), "{}", found.summary);
}

#[test]
fn what_needs_a_column_is_tried_only_where_the_column_varies() {
    let applies = |recording: Recording| {
        let data = Dataset::new(&[recording]).expect("it is one recording");
        let baseline = Baseline::from_model(&model(), &data).expect("the model is of this kind");
        let ids = ["cross_feed", "axis_misalignment", "thrust_dependence", "thrust_offset", "voltage_droop"];
        ids.map(|id| find(id).expect("it is in the catalogue").applies(&baseline, &data))
    };
    let with = flown(1, true, &mut Moment(|_: &Now| 0.0));
    let mut dead = with.clone();
    for column in [&mut dead.p, &mut dead.u_roll, &mut dead.thrust, &mut dead.battery] {
        column.as_mut().expect("it was logged").fill(1.0);
    }
    let mut angle_only = with.clone();
    angle_only.q = None;
    assert_eq!(applies(with), [true; 5]);
    assert_eq!(applies(dead), [false; 5]);
    assert_eq!(applies(flown(1, false, &mut Moment(|_: &Now| 0.0))), [false; 5]);
    assert_eq!(applies(angle_only), [true, false, true, true, true]);
}
