//! The simulated vehicle behind the core's port.

use estimator_core::{Command, Input, Sample, Section, Telemetry, Vehicle};
use rand_pcg::Pcg64;

use crate::aircraft::{Aircraft, SAMPLE_PERIOD_S};
use crate::pilot::ManualReference;
use crate::plant::State;
use crate::reading::{Reading, RollYaw};
use crate::recording::Row;
use crate::sensors::Noise;

const TICK_US: u64 = 20_000;
/// Pitch rate that no vehicle reaches, rad/s: the integration has left the solution. The core takes a larger one for no sample, and a
/// simulation that blew up would end as a fault of the sensor.
const BLOWN_UP_RAD_S: f64 = 35.0;

/// Aircraft, IMU and pilot; keeps what a rig would log, and the true states apart.
#[derive(Debug)]
pub struct SimulatedVehicle {
    aircraft: Aircraft,
    noise: Noise,
    generator: Pcg64,
    roll_yaw_generator: Option<Pcg64>,
    gusty: Option<(Section, f64)>,
    gusts: Vec<([f64; 2], f64)>,
    reference: ManualReference,
    closed_loop_ticks: u32,
    reading: Reading,
    rows: Vec<Row>,
    states: Vec<State>,
    events: Vec<(f64, String)>,
    blown_up: Option<u32>,
}

impl SimulatedVehicle {
    /// A vehicle whose pilot starts the test at tick 0.
    #[must_use]
    pub fn new(aircraft: Aircraft, noise: Noise, generator: Pcg64, reference: ManualReference) -> Self {
        Self {
            aircraft,
            noise,
            generator,
            roll_yaw_generator: None,
            gusty: None,
            gusts: Vec::new(),
            reference,
            closed_loop_ticks: 0,
            reading: Reading::default(),
            rows: Vec::new(),
            states: Vec::new(),
            events: Vec::new(),
            blown_up: None,
        }
    }

    /// The first tick at which the motion had left every bound, or a reading was no number.
    #[must_use]
    pub const fn blown_up(&self) -> Option<u32> {
        self.blown_up
    }

    /// Logs roll and yaw too, with noise from `generator`.
    #[must_use]
    pub fn logging_roll_yaw(self, generator: Pcg64) -> Self {
        Self { roll_yaw_generator: Some(generator), ..self }
    }

    /// Makes the background moment so many times as strong in one section.
    #[must_use]
    pub fn gusty_in(self, gusty: Option<(Section, f64)>) -> Self {
        Self { gusty, ..self }
    }

    /// Makes the background moment so many times as strong in spans of time, s.
    #[must_use]
    pub fn gusty_during(self, gusts: Vec<([f64; 2], f64)>) -> Self {
        Self { gusts, ..self }
    }

    /// Rows of the recording, the true state at each of them, and the supervisor's transitions with their
    /// times.
    #[must_use]
    pub fn into_log(self) -> (Vec<Row>, Vec<State>, Vec<(f64, String)>) {
        (self.rows, self.states, self.events)
    }
}

impl Vehicle for SimulatedVehicle {
    fn sense(&mut self, tick: u32) -> Input {
        self.reading = self.aircraft.read();
        let noise = self.noise.with_gyros_times(self.aircraft.strength());
        noise.add(&mut self.reading, &mut self.generator);
        self.aircraft.limit(&mut self.reading);
        if let Some(generator) = &mut self.roll_yaw_generator {
            noise.add_roll_yaw(&mut self.reading.roll_yaw, generator);
        }
        let state = self.aircraft.state();
        let bounded = [state.q, state.q_p, self.reading.q].iter().all(|rate| rate.abs() < BLOWN_UP_RAD_S);
        if self.blown_up.is_none() && !(bounded && self.reading.theta.is_finite()) {
            self.blown_up = Some(tick);
        }
        self.states.push(state);
        let now_us = u64::from(tick) * TICK_US;
        let sample =
            Sample { time_us: now_us, q_rad_s: self.reading.q as f32, theta_rad: self.reading.theta as f32 };
        Input {
            tick,
            now_us,
            sample: Some(sample),
            theta_ref_rad: self.reference.at(f64::from(self.closed_loop_ticks) * SAMPLE_PERIOD_S) as f32,
            command: if tick == 0 { Command::Start } else { Command::None },
        }
    }

    fn actuate(&mut self, u_rad: f32) {
        self.aircraft.advance(f64::from(u_rad));
    }

    fn emit(&mut self, telemetry: &Telemetry) {
        let t_s = f64::from(telemetry.tick) * SAMPLE_PERIOD_S;
        if let Some(event) = telemetry.event {
            self.events.push((t_s, event.to_string()));
        }
        self.closed_loop_ticks += u32::from(telemetry.section == Section::IV);
        let RollYaw { p, r, phi } = self.reading.roll_yaw;
        let of_section = self.gusty.filter(|(section, _)| telemetry.section == *section);
        let of_time = self.gusts.iter().find(|([from, to], _)| (*from..*to).contains(&t_s));
        let factor = of_section.map(|(_, factor)| factor).or(of_time.map(|(_, factor)| *factor));
        self.aircraft.gust_by(factor.unwrap_or(1.0));
        let (others, beside) = (self.aircraft.others(), self.aircraft.beside(t_s));
        self.rows.push(Row {
            t_s,
            u_rad: telemetry.u_rad,
            q_rad_s: self.reading.q as f32,
            theta_rad: self.reading.theta as f32,
            qdot_rad_s2: self.reading.q_dot as f32,
            section: telemetry.section,
            supervised: telemetry.supervised,
            theta_ref_rad: telemetry.theta_ref_rad,
            roll_yaw: self.roll_yaw_generator.as_ref().map(|_| [p as f32, r as f32, phi as f32]),
            u_roll_rad: others.roll_command.then_some(beside.u_roll as f32),
            thrust_norm: others.thrust.then_some(beside.thrust as f32),
            battery_v: others.battery.then_some(beside.battery_v as f32),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Plant;
    use crate::seeds::{Stream, generator};

    #[test]
    fn noise_that_grows_with_the_command_is_drawn_alike_and_spares_the_angle() {
        const AMPLITUDE: f64 = 0.015;
        // the state is put back before every reading, so that what is read is noise
        let read = |aircraft: Aircraft, u: f64| {
            let [noise, reference] = [Stream::Sensors, Stream::Reference].map(|stream| generator(3, stream));
            let pilot = ManualReference::drawn(10.0, &mut { reference });
            let mut vehicle = SimulatedVehicle::new(aircraft, Noise::default(), noise, pilot);
            let readings = (0..20).map(|tick| {
                vehicle.aircraft.set_state(State::default());
                let sample = vehicle.sense(tick).sample.unwrap();
                vehicle.actuate(u as f32);
                (sample.q_rad_s, sample.theta_rad)
            });
            readings.collect::<Vec<_>>()
        };
        let bare = || Aircraft::new(Plant { delay_s: 0.0, ..Plant::nominal() }.rigid(), &[], None, 0);
        let plain = read(bare(), 0.0);
        for (u, strength) in [(0.0, 0.5), (AMPLITUDE, 1.0), (3.0 * AMPLITUDE, 2.0)] {
            let grown = read(bare().growing_with_command(AMPLITUDE), u);
            for ((q, theta), (plain_q, plain_theta)) in grown.into_iter().zip(&plain).skip(1) {
                assert!((q - strength * plain_q).abs() < 1e-6, "{u}: {q} {plain_q}");
                assert_eq!(theta, *plain_theta, "{u}");
            }
        }
    }
}
