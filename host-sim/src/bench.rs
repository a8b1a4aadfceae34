//! A test without the core: an airframe under an input of one's own, logged at any rate, from any state.
//!
//! For what a campaign of the core cannot show: a step from rest, a ring-down, a tail in which nothing moves, an input
//! that switches by what the airframe does, an oscillator that is sampled coarsely.

use std::f64::consts::TAU;

use crate::aircraft::Aircraft;
use crate::disturbance::{Colour, ColouredMoment};
use crate::effects::Setting;
use crate::error::Error;
use crate::excitation::{Excitation, Input};
use crate::plant::{Plant, State};
use crate::reading::{Beside, Others, RollYaw};
use crate::scenario::Background;
use crate::seeds::{Stream, generator};
use crate::sensors::Noise;
use crate::table::Table;

/// One test on a bench.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Seed of everything random.
    pub seed: u64,
    /// The true plant.
    pub plant: Plant,
    /// What is concealed in it.
    pub effects: Vec<Setting>,
    /// State that it is released from; at rest and level if not told otherwise.
    pub start: State,
    /// What is sent.
    pub input: Input,
    /// When the input works, s; nought is sent before and after.
    pub works_s: [f64; 2],
    /// Unit of the input in its column's name: `rad`, `pct`, `V`, `N_m`, `N` or `norm`.
    pub unit: &'static str,
    /// Whether the input goes its own way between the samples, as one that is measured does, instead of being held.
    pub interpolated: bool,
    /// Length, s.
    pub duration_s: f64,
    /// Time between two rows, s.
    pub sample_s: f64,
    /// What the air does: band-passed about 5 rad/s, so that the test without it has this VAF.
    pub background: Background,
    /// From when (s) to when the air is so many times as strong.
    pub gusts: Vec<([f64; 2], f64)>,
    /// Noise of the IMU.
    pub noise: Noise,
    /// Whether the angle is logged.
    pub angle_logged: bool,
    /// What goes on beside the pitch axis, apart from what the effects need.
    pub others: Others,
}

/// What a bench or a flight of its own logged.
#[derive(Clone, Debug)]
pub struct Logged {
    /// The recording.
    pub table: Table,
    /// The true state at each row.
    pub states: Vec<State>,
    /// Standard deviation of the background moment, N m.
    pub sigma: f64,
}

/// Background: centre, rad/s, and damping ratio.
const AIR: Colour = Colour::BandPass { omega: 5.0, zeta: 0.4 };
/// Longest integration step, s.
const STEP_S: f64 = 1e-3;

impl Bench {
    /// The nominal plant under the PRBS of campaign 4 (0.015 rad) for 100 s at 50 Hz, background `Lab`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            plant: Plant::nominal(),
            effects: Vec::new(),
            start: State::default(),
            input: Input::Prbs { amplitude: 0.015, dwell_s: [0.4, 0.8] },
            works_s: [0.0, f64::INFINITY],
            unit: "rad",
            interpolated: false,
            duration_s: 100.0,
            sample_s: 0.02,
            background: Background::Lab,
            gusts: Vec::new(),
            noise: Noise::default(),
            angle_logged: true,
            others: Others::default(),
        }
    }

    /// A Duffing oscillator of 1 Hz, damping ratio 0.09, that is half as stiff again at 0.3 rad, under 60 tones of 0.05 to
    /// 1.5 Hz (as the Silverbox; Wigren, Schoukens 2013), with so many samples per period of its small oscillations:
    /// I q̇ = u − 0.2 q − G sin θ − k3 θ³, G = 6.73 N m, k3 = 37 N m/rad³, for 200 s without delay, the input in N m.
    ///
    /// # Errors
    /// None that a caller could cause: the effects are in the catalogue.
    pub fn duffing(samples_per_period: f64, interpolated: bool, seed: u64) -> Result<Self, Error> {
        let plant = Plant { dm_dq: -0.2, dm_du: 1.0, delay_s: 0.0, ..Plant::nominal() }.rigid();
        let gravity = plant.inertia_kg_m2 * TAU * TAU;
        Ok(Self {
            plant,
            effects: vec![
                Setting::new("gravity_stiffness", &[("G", gravity)])?,
                Setting::new("cubic_stiffness", &[("k3", 37.0)])?,
            ],
            input: Input::Tones { effective: 0.6, band_hz: [0.05, 1.5], count: 60 },
            unit: "N_m",
            interpolated,
            duration_s: 200.0,
            sample_s: 1.0 / samples_per_period.max(2.0),
            background: Background::Clean,
            ..Self::new(seed)
        })
    }

    /// Flies it.
    ///
    /// # Errors
    /// A plant that cannot be; a time between rows, or a length, that is no positive number.
    pub fn run(&self) -> Result<Logged, Error> {
        self.plant.check()?;
        for (name, found) in [("sample_s", self.sample_s), ("duration_s", self.duration_s)] {
            if !(found.is_finite() && found > 0.0) {
                return Err(Error::Plant { name, found, expected: "a positive number of seconds" });
            }
        }
        Ok(self.shaken(self.sigma()))
    }

    /// The moment that leaves the test the VAF that its background promises: sized for the undisturbed test, by what a
    /// moment of a first guess adds to it.
    fn sigma(&self) -> f64 {
        let Some(share) = self.background.explainable() else { return 0.0 };
        let calm = Self { gusts: Vec::new(), noise: Noise::none(), ..self.clone() };
        let undisturbed = calm.shaken(0.0);
        let caused = power(undisturbed.states.iter().map(|x| x.q_p));
        let wanted = caused * (1.0 / share - 1.0);
        let guess = 0.1 * self.plant.inertia_kg_m2 * caused.sqrt() * 5.0;
        let added = |sigma: f64| {
            let disturbed = calm.shaken(sigma).states;
            power(disturbed.iter().zip(&undisturbed.states).map(|(with, without)| with.q_p - without.q_p))
        };
        let first = added(guess);
        if first > 0.0 { guess * (wanted / first).sqrt() } else { 0.0 }
    }

    fn shaken(&self, sigma: f64) -> Logged {
        let seeded = |stream| generator(self.seed, stream);
        let background = (sigma > 0.0).then(|| ColouredMoment::new(sigma, AIR, seeded(Stream::Background)));
        // an input that goes its own way is one that is held over many short ticks
        let ticks = if self.interpolated { (self.sample_s / STEP_S).ceil().max(1.0) as u32 } else { 1 };
        let mut aircraft = Aircraft::new(self.plant, &self.effects, background, self.seed)
            .sampled_every(self.sample_s / f64::from(ticks), STEP_S)
            .among(self.others, self.seed);
        aircraft.set_state(self.start);
        let mut excitation = Excitation::new(self.input, seeded(Stream::Excitation));
        let (mut of_pitch, mut of_others) = (seeded(Stream::Sensors), seeded(Stream::RollYaw));
        let mut sent = |t: f64, q: f64| {
            // the small share keeps the first sample in the window
            let works = t + 1e-9 >= self.works_s[0] && t + 1e-9 < self.works_s[1];
            if works { excitation.at(t - self.works_s[0].max(0.0), q) } else { 0.0 }
        };
        let mut log = Log::default();
        let rows = (self.duration_s / self.sample_s).round() as usize;
        for k in 0..rows {
            let t = k as f64 * self.sample_s;
            let gust = self.gusts.iter().find(|([from, to], _)| (*from..*to).contains(&t));
            aircraft.gust_by(gust.map_or(1.0, |(_, factor)| *factor));
            let mut reading = aircraft.read();
            self.noise.add(&mut reading, &mut of_pitch);
            aircraft.limit(&mut reading);
            let mut beside = aircraft.beside(t);
            self.noise.add_roll_yaw(&mut beside.roll_yaw, &mut of_others);
            log.states.push(aircraft.state());
            let u = sent(t, reading.q);
            log.row(t, u, [reading.q, reading.theta], beside);
            for tick in 0..ticks {
                let middle = t + self.sample_s * (f64::from(tick) + 0.5) / f64::from(ticks);
                aircraft.advance(if self.interpolated { sent(middle, reading.q) } else { u });
            }
        }
        log.finish(self, aircraft.others(), sigma)
    }
}

fn power(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value * value));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Rows as they come.
#[derive(Default)]
struct Log {
    t_s: Vec<f64>,
    u: Vec<f64>,
    q: Vec<f64>,
    theta: Vec<f64>,
    beside: Vec<Beside>,
    states: Vec<State>,
}

impl Log {
    fn row(&mut self, t: f64, u: f64, [q, theta]: [f64; 2], beside: Beside) {
        self.t_s.push(t);
        self.u.push(u);
        self.q.push(q);
        self.theta.push(theta);
        self.beside.push(beside);
    }

    fn finish(self, bench: &Bench, others: Others, sigma: f64) -> Logged {
        let beside = |value: fn(&Beside) -> f64| self.beside.iter().map(value).collect();
        let turns = others.roll || others.yaw;
        let columns: [(bool, String, Vec<f64>); 8] = [
            (true, format!("u_{}", bench.unit), self.u),
            (true, "q_rad_s".into(), self.q),
            (bench.angle_logged, "theta_rad".into(), self.theta),
            (turns, "p_rad_s".into(), beside(|now| now.roll_yaw.p)),
            (turns, "r_rad_s".into(), beside(|now| now.roll_yaw.r)),
            (turns, "phi_rad".into(), beside(|Beside { roll_yaw: RollYaw { phi, .. }, .. }| *phi)),
            (others.roll_command, format!("u_roll_{}", bench.unit), beside(|now| now.u_roll)),
            (others.thrust, "thrust_norm".into(), beside(|now| now.thrust)),
        ];
        let voltage = (others.battery, "battery_v".to_owned(), beside(|now| now.battery_v));
        let logged = columns.into_iter().chain([voltage]).filter(|(logged, ..)| *logged);
        let empty = Table::new(format!("bench test, seed {}", bench.seed), self.t_s);
        let table = logged.fold(empty, |table, (_, name, values)| table.with(name, values));
        Logged { table, states: self.states, sigma }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Plant = Plant { mount: None, dm_dq: 0.0, delay_s: 0.0, ..Plant::nominal() };

    /// A free plant in still air, read without noise.
    fn quiet() -> Bench {
        Bench { plant: FREE, background: Background::None, noise: Noise::none(), ..Bench::new(3) }
    }

    #[test]
    fn a_step_after_a_rest_is_the_closed_form_and_ends_in_a_dead_tail() {
        let plant = Plant::nominal().rigid();
        let (input, works_s) = (Input::Step { height: 0.01 }, [1.0, 7.0]);
        let logged = Bench { plant, input, works_s, duration_s: 15.0, ..quiet() }.run().unwrap();
        let q = logged.table.column("q_rad_s").unwrap();
        assert!(q[..53].iter().all(|q| *q == 0.0));
        let (a, gain) = (0.27 / 0.1705, 23.0 * 0.01 / 0.27);
        let at = |seconds: f64| gain * (1.0 - (-a * seconds).exp());
        assert!((q[100] - at(0.94)).abs() < 1e-9, "{} {}", q[100], at(0.94));
        assert!(q[600..].iter().all(|q| q.abs() < 1e-3));
        assert!(logged.table.column("u_rad").unwrap()[350..].iter().all(|u| *u == 0.0));
    }

    #[test]
    fn a_release_rings_down_at_its_frequency() {
        let spring = Setting::new("gravity_stiffness", &[("G", 2.0)]).unwrap();
        let start = State { theta: 0.02, theta_p: 0.02, ..State::default() };
        let logged = Bench { effects: vec![spring], start, input: Input::Rest, duration_s: 5.0, ..quiet() };
        let theta = logged.run().unwrap().table.column("theta_rad").unwrap().to_vec();
        let omega = (2.0_f64 / 0.1705).sqrt();
        assert!(theta.iter().enumerate().all(|(k, theta)| {
            let expected = 0.02 * (omega * 0.02 * k as f64).cos();
            (theta - expected).abs() < 1e-5
        }));
    }

    #[test]
    fn the_rate_is_the_integral_of_the_input_as_it_runs_between_the_samples() {
        let input = Input::Tones { effective: 0.01, band_hz: [0.1, 1.0], count: 5 };
        let flown = |interpolated: bool, sample_s: f64| {
            let table =
                Bench { input, interpolated, sample_s, duration_s: 30.0, ..quiet() }.run().unwrap().table;
            [table.column("u_rad").unwrap().to_vec(), table.column("q_rad_s").unwrap().to_vec()]
        };
        let [u, q] = flown(false, 0.15);
        let mut expected = 0.0;
        for k in 1..u.len() {
            expected += 0.15 * 23.0 * u[k - 1] / 0.1705;
            assert!((q[k] - expected).abs() < 1e-9, "{k}");
        }
        let [fine, _] = flown(false, 0.001);
        let [_, smooth] = flown(true, 0.15);
        let mut expected = 0.0;
        for (k, smooth) in smooth.iter().enumerate() {
            assert!((smooth - expected).abs() < 1e-5, "{k}: {smooth} {expected}");
            let between = fine.windows(2).skip(150 * k).take(150);
            expected += between.map(|u| 0.001 * 23.0 * (u[0] + u[1]) / 2.0 / 0.1705).sum::<f64>();
        }
    }

    #[test]
    fn a_load_that_hangs_on_twice_gives_the_impulses_of_both_times() {
        let pull =
            |from: f64, to: f64| Setting::new("moment_step", &[("M0", 0.05), ("t0", from), ("t1", to)]);
        let effects = vec![pull(1.0, 3.0).unwrap(), pull(6.0, 7.0).unwrap()];
        let states = Bench { effects, input: Input::Rest, duration_s: 10.0, ..quiet() }.run().unwrap().states;
        for (row, seconds) in [(50, 0.0), (200, 2.0), (320, 2.4), (499, 3.0)] {
            assert!((states[row].q - 0.05 / 0.1705 * seconds).abs() < 1e-9, "{row}");
        }
    }

    #[test]
    fn dwells_follow_the_rate_at_the_switch() {
        let input = Input::PrbsByRate { amplitude: 0.015, dwell_s: [0.2, 0.4], lengthened: 0.6 };
        let plant = Plant::nominal().rigid();
        let table = Bench { plant, input, ..quiet() }.run().unwrap().table;
        let (u, q) = (table.column("u_rad").unwrap(), table.column("q_rad_s").unwrap());
        let switches: Vec<usize> = (1..u.len()).filter(|k| u[*k] != u[k - 1]).collect();
        let mut longest: f64 = 0.0;
        for pair in switches.windows(2) {
            let drawn = 0.02 * (pair[1] - pair[0]) as f64 - 0.6 * q[pair[0]].abs();
            assert!((0.2 - 1e-6..0.42).contains(&drawn), "{drawn}");
            longest = longest.max(0.02 * (pair[1] - pair[0]) as f64);
        }
        assert!(switches.len() > 50 && longest > 0.5);
    }

    #[test]
    fn the_air_leaves_what_it_promises_and_gusts_shake_their_window() {
        let share = |bench: &Bench| {
            let undisturbed = Bench { background: Background::None, ..bench.clone() }.run().unwrap().states;
            let disturbed = bench.run().unwrap().states;
            let part = |range: std::ops::Range<usize>| {
                let pairs = disturbed[range.clone()].iter().zip(&undisturbed[range]);
                power(pairs.clone().map(|(a, b)| a.q_p - b.q_p)) / power(pairs.map(|(a, _)| a.q_p))
            };
            (part(0..5000), part(0..2500), part(2600..5000))
        };
        let paper = Bench { background: Background::Paper, ..Bench::new(5) };
        let (whole, ..) = share(&paper);
        assert!((0.18..0.32).contains(&whole), "{whole}");
        let gusty =
            Bench { gusts: vec![([50.0, 100.0], 4.0)], background: Background::Clean, ..Bench::new(5) };
        let (_, before, within) = share(&gusty);
        assert!(before < 0.05 && within > 4.0 * before, "{before} {within}");
    }

    #[test]
    fn a_coarse_duffing_oscillator_stiffens_and_hangs_on_its_seed() {
        for samples in [6.0, 9.0, 20.0, 60.0] {
            for interpolated in [false, true] {
                let bench = Bench::duffing(samples, interpolated, 4).unwrap();
                let logged = bench.run().unwrap();
                assert_eq!(logged.table.t_s.len(), (200.0 * samples) as usize);
                assert_eq!(logged.table.to_csv(), bench.run().unwrap().table.to_csv());
                let largest = logged.states.iter().fold(0.0_f64, |top, x| top.max(x.theta.abs()));
                assert!((0.25..0.9).contains(&largest), "{samples} {largest}");
            }
        }
    }

    #[test]
    fn what_goes_on_beside_is_logged_with_the_unit_of_the_input() {
        let others = Others { roll: true, roll_command: true, battery: true, ..Others::default() };
        let bench = Bench { others, unit: "norm", angle_logged: false, duration_s: 1.0, ..Bench::new(1) };
        let text = bench.run().unwrap().table.to_csv();
        let header = "t_s,u_norm,q_rad_s,p_rad_s,r_rad_s,phi_rad,u_roll_norm,battery_v";
        assert_eq!(text.lines().nth(1), Some(header));
        assert!(Bench { sample_s: 0.0, ..bench }.run().unwrap_err().to_string().contains("sample_s"));
    }
}
