//! A vehicle that flies freely under a controller of its own, faster than the core's: every axis moves, every loop is
//! closed, and the log holds the controller's own output.
//!
//! ```text
//! rate set point  q* = ka (θ* − θ)
//! command         u  = kp (q* − q) + ki ∫ (q* − q) dt − kd q̇f,   q̇f: the slope of q behind a filter,   |u| ≤ 1
//! ```
//!
//! for each axis alike, at every tick. The set points θ* are two-level sequences, an independent one for each axis.
//!
//! The axes are three aircraft of one simulator. Pitch knows the others: θ̇ = q cos φ − r sin φ, and effects that ask for roll,
//! yaw, the roll command, thrust or battery get what is flown. Roll and yaw are taken as φ̇ = p and ψ̇ = r; to their effects
//! pitch is what roll is to those of pitch.

use std::f64::consts::TAU;

use crate::aircraft::Aircraft;
use crate::bench::Logged;
use crate::disturbance::{Colour, ColouredMoment};
use crate::effects::Setting;
use crate::error::Error;
use crate::excitation::{Excitation, Input};
use crate::plant::Plant;
use crate::reading::{Beside, Others, RollYaw};
use crate::seeds::{Stream, generator};
use crate::sensors::Noise;
use crate::surroundings::Surroundings;
use crate::table::Table;

/// One flight.
#[derive(Clone, Debug)]
pub struct FreeFlight {
    /// Seed of everything random.
    pub seed: u64,
    /// The axes: roll, pitch, yaw; their input is `norm`, from −1 to 1.
    pub plants: [Plant; 3],
    /// What is concealed in each of them.
    pub effects: [Vec<Setting>; 3],
    /// The controller of each of them.
    pub controllers: [Controller; 3],
    /// Height of the angle set points, rad; nought leaves an axis at level.
    pub set_points_rad: [f64; 3],
    /// Shortest and longest time that a set point stays, s.
    pub dwell_s: [f64; 2],
    /// Length, s.
    pub duration_s: f64,
    /// Time between two ticks of controller and log, s.
    pub tick_s: f64,
    /// Standard deviation of the coloured moment on each axis, N m; nought is still air.
    pub sigma: [f64; 3],
    /// Noise of the IMU, of every axis.
    pub noise: Noise,
    /// Whether the angles are logged; the controller always has them.
    pub angles_logged: bool,
    /// Whether the other axes are logged: `u_roll_norm`, `u_pitch_norm`, `u_yaw_norm` and so on with thrust and battery, or
    /// `u_norm`, `q_rad_s` and `theta_rad` alone.
    pub others_logged: bool,
}

/// A controller of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// ka, 1/s.
    pub angle: f64,
    /// kp, 1 per rad/s.
    pub rate: f64,
    /// ki, 1 per rad.
    pub integral: f64,
    /// kd, 1 per rad/s².
    pub derivative: f64,
}

/// Time constant of the filter before the derivative, s.
const FILTER_S: f64 = 0.01;
/// Longest integration step, s.
const STEP_S: f64 = 1e-3;
const ROLL: usize = 0;
const PITCH: usize = 1;
/// What every axis is told.
const ALL: Others = Others { roll: true, yaw: true, roll_command: true, thrust: true, battery: true };

impl FreeFlight {
    /// A quadrotor of 1.2 kg or so for 60 s at 500 Hz: motors of 40 ms on each axis, 20 ms of delay, set points of ±0.15 rad on
    /// every axis, some turbulence.
    ///
    /// # Errors
    /// None that a caller could cause: the effect is in the catalogue.
    pub fn new(seed: u64) -> Result<Self, Error> {
        let plant =
            |inertia_kg_m2, dm_dq, dm_du| Plant { inertia_kg_m2, dm_dq, dm_du, delay_s: 0.02, mount: None };
        let motors = || Setting::new("servo_lag", &[("T", 0.04)]).map(|lag| vec![lag]);
        let controller = Controller { angle: 4.0, rate: 0.1, integral: 0.1, derivative: 0.001 };
        Ok(Self {
            seed,
            plants: [plant(0.011, -0.01, 1.1), plant(0.0123, -0.012, 1.1), plant(0.0224, -0.01, 0.5)],
            effects: [motors()?, motors()?, motors()?],
            controllers: [controller, controller, Controller { angle: 1.5, rate: 0.2, ..controller }],
            set_points_rad: [0.15; 3],
            dwell_s: [0.4, 1.2],
            duration_s: 60.0,
            tick_s: 0.002,
            sigma: [0.01, 0.01, 0.005],
            noise: Noise { q_rad_s: 0.01, theta_rad: 0.001, qdot_rad_s2: 0.5 },
            angles_logged: true,
            others_logged: true,
        })
    }

    /// The same with roll and yaw held level, and pitch alone logged.
    #[must_use]
    pub fn pitch_alone(self) -> Self {
        let [_, pitch, _] = self.set_points_rad;
        Self { set_points_rad: [0.0, pitch, 0.0], others_logged: false, ..self }
    }

    /// Flies it. The states of the answer are those of the pitch axis.
    ///
    /// # Errors
    /// A plant that cannot be; a tick or a length that is no positive number.
    pub fn fly(&self) -> Result<Logged, Error> {
        self.plants.iter().try_for_each(Plant::check)?;
        for (name, found) in [("tick_s", self.tick_s), ("duration_s", self.duration_s)] {
            if !(found.is_finite() && found > 0.0) {
                return Err(Error::Plant { name, found, expected: "a positive number of seconds" });
            }
        }
        let mut axes: Vec<Axis> = (0..3).map(|axis| Axis::new(self, axis)).collect();
        let around =
            Surroundings::drawn(self.seed, Others { thrust: true, battery: true, ..Others::default() });
        let around = around.held_for(self.tick_s);
        let mut log: Vec<[f64; 11]> = Vec::new();
        let (mut times, mut states) = (Vec::new(), Vec::new());
        let ticks = (self.duration_s / self.tick_s).round() as usize;
        for k in 0..ticks {
            let t = k as f64 * self.tick_s;
            let mut now = around.at(t);
            let [roll, yaw] = [0, 2].map(|axis: usize| axes[axis].aircraft.state());
            let pitch = axes[PITCH].aircraft.state();
            states.push(pitch);
            let around_pitch = RollYaw { p: roll.q, r: yaw.q, phi: roll.theta };
            let around_others = RollYaw { p: pitch.q, ..RollYaw::default() };
            let mut tell = |axes: &mut [Axis], commands: [f64; 3]| {
                for (place, axis) in axes.iter_mut().enumerate() {
                    let (roll_yaw, other) =
                        if place == PITCH { (around_pitch, ROLL) } else { (around_others, PITCH) };
                    now = Beside { roll_yaw, u_roll: commands[other], ..now };
                    axis.aircraft.tell(now, ALL);
                }
            };
            // what the gyro of a turned IMU sees is read before the commands of this tick are known
            tell(&mut axes, [0.0; 3]);
            let [roll, pitch, yaw] = [0, 1, 2].map(|axis: usize| axes[axis].react(self, t));
            let sent = [roll, pitch, yaw].map(|[u, ..]| u);
            tell(&mut axes, sent);
            axes.iter_mut().zip(sent).for_each(|(axis, u)| axis.aircraft.advance(u));
            times.push(t);
            let [[ur, p, phi], [up, q, theta], [uy, r, psi]] = [roll, pitch, yaw];
            log.push([ur, up, uy, p, q, r, phi, theta, psi, now.thrust, now.battery_v]);
        }
        let table = self.table(times, &log);
        Ok(Logged { table, states, sigma: self.sigma[PITCH] })
    }

    fn table(&self, t_s: Vec<f64>, log: &[[f64; 11]]) -> Table {
        const NAMES: [&str; 11] = [
            "u_roll_norm",
            "u_pitch_norm",
            "u_yaw_norm",
            "p_rad_s",
            "q_rad_s",
            "r_rad_s",
            "phi_rad",
            "theta_rad",
            "psi_rad",
            "thrust_norm",
            "battery_v",
        ];
        let of_pitch = ["u_pitch_norm", "q_rad_s", "theta_rad"];
        let angles = ["phi_rad", "theta_rad", "psi_rad"];
        let mut table = Table::new(format!("free flight, seed {}", self.seed), t_s);
        for (place, name) in NAMES.into_iter().enumerate() {
            let wanted = (self.others_logged || of_pitch.contains(&name))
                && (self.angles_logged || !angles.contains(&name));
            let alone = !self.others_logged && name == "u_pitch_norm";
            if wanted {
                let values = log.iter().map(|row| row[place]).collect();
                table = table.with(if alone { "u_norm" } else { name }, values);
            }
        }
        table
    }
}

/// One axis with its controller.
struct Axis {
    aircraft: Aircraft,
    controller: Controller,
    set_points: Excitation,
    generator: rand_pcg::Pcg64,
    integral: f64,
    filtered: f64,
}

impl Axis {
    fn new(flight: &FreeFlight, axis: usize) -> Self {
        // every axis has streams of its own
        let seed = flight.seed.wrapping_mul(3).wrapping_add(axis as u64);
        let sigma = flight.sigma[axis];
        let colour = Colour::BandPass { omega: TAU, zeta: 0.5 };
        let air = ColouredMoment::new(sigma, colour, generator(seed, Stream::Background));
        let aircraft =
            Aircraft::new(flight.plants[axis], &flight.effects[axis], (sigma > 0.0).then_some(air), seed)
                .sampled_every(flight.tick_s, STEP_S);
        let input = Input::Prbs { amplitude: flight.set_points_rad[axis], dwell_s: flight.dwell_s };
        Self {
            aircraft,
            controller: flight.controllers[axis],
            set_points: Excitation::new(input, generator(seed, Stream::Excitation)),
            generator: generator(seed, Stream::Sensors),
            integral: 0.0,
            filtered: 0.0,
        }
    }

    /// Command, rate and angle as measured at `t`.
    fn react(&mut self, flight: &FreeFlight, t: f64) -> [f64; 3] {
        let mut reading = self.aircraft.read();
        flight.noise.add(&mut reading, &mut self.generator);
        self.aircraft.limit(&mut reading);
        let Controller { angle, rate, integral, derivative } = self.controller;
        let wanted = angle * (self.set_points.at(t, reading.q) - reading.theta);
        let missing = wanted - reading.q;
        let slope = (reading.q - self.filtered) / FILTER_S;
        self.filtered += slope * FILTER_S * (1.0 - (-flight.tick_s / FILTER_S).exp());
        let unlimited = rate * missing + integral * self.integral - derivative * slope;
        let u = unlimited.clamp(-1.0, 1.0);
        if u == unlimited {
            self.integral += flight.tick_s * missing;
        }
        [u, reading.q, reading.theta]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
    }

    #[test]
    fn it_follows_its_set_points_on_every_axis_and_stays_upright() {
        let table = FreeFlight::new(2).unwrap().fly().unwrap().table;
        assert_eq!(table.t_s.len(), 30_000);
        for (rate, angle) in [("p_rad_s", "phi_rad"), ("q_rad_s", "theta_rad"), ("r_rad_s", "psi_rad")] {
            let of = |name| table.column(name).unwrap();
            let power = of(rate).iter().map(|q| q * q).sum::<f64>() / 30_000.0;
            assert!((0.1..1.0).contains(&power.sqrt()), "{rate} {power}");
            assert!(of(angle).iter().all(|angle| angle.abs() < 0.5), "{angle}");
        }
        for input in ["u_roll_norm", "u_pitch_norm", "u_yaw_norm"] {
            let limited = table.column(input).unwrap().iter().filter(|u| u.abs() >= 1.0).count();
            assert!(limited < 300, "{input} {limited}");
        }
    }

    #[test]
    fn without_set_points_noise_and_air_it_stays_at_rest() {
        let calm = FreeFlight { sigma: [0.0; 3], noise: Noise::none(), ..FreeFlight::new(2).unwrap() };
        let states = FreeFlight { set_points_rad: [0.0; 3], ..calm }.fly().unwrap().states;
        assert!(states.iter().all(|x| x.q == 0.0 && x.theta == 0.0));
    }

    #[test]
    fn at_the_rate_of_the_loop_the_command_answers_the_rate_at_once() {
        let flight = FreeFlight { duration_s: 30.0, ..FreeFlight::new(4).unwrap() }.pitch_alone();
        let still = FreeFlight { set_points_rad: [0.0; 3], ..flight };
        let fast = still.fly().unwrap().table;
        let of = |name: &str| fast.column(name).unwrap().to_vec();
        let (u, q) = (of("u_norm"), of("q_rad_s"));
        assert!(correlation(&u, &q) < -0.3, "{}", correlation(&u, &q));
    }

    #[test]
    fn cross_feed_carries_the_roll_command_that_is_logged_into_pitch() {
        let mut flight = FreeFlight { duration_s: 20.0, ..FreeFlight::new(6).unwrap() };
        flight.set_points_rad = [0.15, 0.0, 0.0];
        flight.sigma = [0.01, 0.0, 0.0];
        flight.noise = Noise::none();
        // nobody holds pitch
        flight.controllers[PITCH] = Controller { angle: 0.0, rate: 0.0, integral: 0.0, derivative: 0.0 };
        let feed = 0.05 * flight.plants[0].dm_du;
        flight.effects[PITCH].push(Setting::new("cross_feed", &[("c", feed)]).unwrap());
        let fed = flight.fly().unwrap().table;
        let (u, q) = (fed.column("u_roll_norm").unwrap(), fed.column("q_rad_s").unwrap());
        let Plant { inertia_kg_m2, dm_dq, .. } = flight.plants[PITCH];
        let decay = (dm_dq / inertia_kg_m2 * flight.tick_s).exp();
        for k in 1..u.len() {
            let expected = q[k - 1] * decay - (1.0 - decay) * feed / dm_dq * u[k - 1];
            assert!((q[k] - expected).abs() < 1e-9, "{k}: {} {expected}", q[k]);
        }
        assert!(q.iter().any(|q| q.abs() > 0.01));
    }

    #[test]
    fn an_imu_that_is_turned_mixes_the_rates_of_both_axes() {
        let turned = |angle| {
            let mut flight =
                FreeFlight { duration_s: 2.0, noise: Noise::none(), ..FreeFlight::new(3).unwrap() };
            // nobody holds the axes, the air alone moves them
            flight.controllers = [Controller { angle: 0.0, rate: 0.0, integral: 0.0, derivative: 0.0 }; 3];
            for (axis, sign) in [(PITCH, 1.0), (ROLL, -1.0)] {
                let turn = Setting::new("axis_misalignment", &[("angle_deg", sign * angle)]).unwrap();
                flight.effects[axis].push(turn);
            }
            flight.fly().unwrap().table
        };
        let (plain, mixed) = (turned(0.0), turned(30.0));
        let rates =
            |table: &Table, k: usize| ["p_rad_s", "q_rad_s"].map(|name| table.column(name).unwrap()[k]);
        let (sine, cosine) = (0.5, 0.75_f64.sqrt());
        for k in 0..1000 {
            let ([p, q], [p_seen, q_seen]) = (rates(&plain, k), rates(&mixed, k));
            assert!((q_seen - (q * cosine + p * sine)).abs() < 1e-9, "{k}");
            assert!((p_seen - (p * cosine - q * sine)).abs() < 1e-9, "{k}");
        }
        assert!(rates(&plain, 999).iter().all(|rate| rate.abs() > 1e-4));
    }

    #[test]
    fn columns_are_those_of_one_axis_or_of_three_and_the_seed_is_all() {
        let short = || FreeFlight { duration_s: 1.0, ..FreeFlight::new(1).unwrap() };
        let header = |flight: FreeFlight| {
            let text = flight.fly().unwrap().table.to_csv();
            text.lines().nth(1).unwrap().to_owned()
        };
        assert_eq!(header(short().pitch_alone()), "t_s,u_norm,q_rad_s,theta_rad");
        assert_eq!(
            header(FreeFlight { angles_logged: false, ..short() }),
            "t_s,u_roll_norm,u_pitch_norm,u_yaw_norm,p_rad_s,q_rad_s,r_rad_s,thrust_norm,battery_v"
        );
        let text = |flight: FreeFlight| flight.fly().unwrap().table.to_csv();
        assert_eq!(text(short()), text(short()));
        assert_ne!(text(short()), text(FreeFlight { seed: 2, ..short() }));
    }
}
