//! Faults of sensors and of the servo, over a simulated vehicle.
//!
//! A fault changes what the core is given, or what becomes of its command; it knows nothing of either side.

use estimator_core::{Input, Telemetry, Vehicle};
use serde::Serialize;

use crate::vehicle::SimulatedVehicle;

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// No sample arrives.
    SamplesLost,
    /// Every second sample is lost.
    SamplesPatchy,
    /// Samples arrive so many ticks after they were taken.
    SamplesLate {
        /// Age, ticks.
        ticks: u32,
    },
    /// The rate stays as it was last.
    RateFrozen,
    /// The angle stays as it was last.
    AngleFrozen,
    /// The rate is no number.
    RateNotFinite,
    /// The angle is infinite.
    AngleInfinite,
    /// One channel reads a wild value, finite.
    Wild {
        /// Added to the rate, rad/s.
        q_rad_s: f32,
        /// Added to the angle, rad.
        theta_rad: f32,
    },
    /// The angle is off.
    AngleOff {
        /// By so much, rad.
        rad: f32,
    },
    /// The servo stays where it is.
    ServoStuck,
    /// The servo goes to neutral.
    ServoNeutral,
    /// The servo does a part of what it is told.
    ServoWeak {
        /// The part.
        share: f32,
    },
    /// Every second command does not arrive.
    CommandsPatchy,
}

impl Fault {
    /// Whether the samples are what breaks.
    #[must_use]
    pub const fn is_of_sensors(&self) -> bool {
        !matches!(self, Self::ServoStuck | Self::ServoNeutral | Self::ServoWeak { .. } | Self::CommandsPatchy)
    }

    /// What breaks, in words.
    #[must_use]
    pub const fn told(&self) -> &'static str {
        match self {
            Self::SamplesLost => "no samples",
            Self::SamplesPatchy => "every second sample lost",
            Self::SamplesLate { .. } => "samples late",
            Self::RateFrozen => "rate frozen",
            Self::AngleFrozen => "angle frozen",
            Self::RateNotFinite => "rate not a number",
            Self::AngleInfinite => "angle infinite",
            Self::Wild { .. } => "wild values",
            Self::AngleOff { .. } => "angle off",
            Self::ServoStuck => "servo stuck",
            Self::ServoNeutral => "servo at neutral",
            Self::ServoWeak { .. } => "servo weak",
            Self::CommandsPatchy => "every second command lost",
        }
    }
}

/// A fault, and when it is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Failing {
    /// What breaks.
    pub fault: Fault,
    /// First tick of it.
    pub from: u32,
    /// First tick after it.
    pub to: u32,
}

/// A vehicle that something breaks on, or nothing.
#[derive(Debug)]
pub struct FailingVehicle {
    vehicle: SimulatedVehicle,
    failing: Option<Failing>,
    tick: u32,
    /// The inputs before the fault, and while samples are late those under way.
    earlier: Vec<Input>,
    sent: f32,
}

impl FailingVehicle {
    /// The vehicle, and what breaks on it.
    #[must_use]
    pub const fn new(vehicle: SimulatedVehicle, failing: Option<Failing>) -> Self {
        Self { vehicle, failing, tick: 0, earlier: Vec::new(), sent: 0.0 }
    }

    /// The vehicle with its log.
    #[must_use]
    pub fn into_vehicle(self) -> SimulatedVehicle {
        self.vehicle
    }

    fn fault(&self) -> Option<(Fault, u32)> {
        let failing = self.failing.filter(|f| (f.from..f.to).contains(&self.tick))?;
        Some((failing.fault, self.tick - failing.from))
    }
}

impl Vehicle for FailingVehicle {
    fn sense(&mut self, tick: u32) -> Input {
        self.tick = tick;
        let mut input = self.vehicle.sense(tick);
        self.earlier.push(input);
        let Some((fault, since)) = self.fault() else { return input };
        let before = (since + 1) as usize;
        let last = self.earlier.iter().nth_back(before).and_then(|input| input.sample);
        if let Fault::SamplesLate { ticks } = fault {
            let late = self.earlier.iter().nth_back(ticks as usize).and_then(|input| input.sample);
            input.sample = late;
            return input;
        }
        if fault == Fault::SamplesLost || (fault == Fault::SamplesPatchy && since.is_multiple_of(2)) {
            input.sample = None;
        }
        let Some(sample) = &mut input.sample else { return input };
        match fault {
            Fault::RateFrozen => sample.q_rad_s = last.map_or(sample.q_rad_s, |last| last.q_rad_s),
            Fault::AngleFrozen => sample.theta_rad = last.map_or(sample.theta_rad, |last| last.theta_rad),
            Fault::RateNotFinite => sample.q_rad_s = f32::NAN,
            Fault::AngleInfinite => sample.theta_rad = f32::INFINITY,
            Fault::Wild { q_rad_s, theta_rad } => {
                sample.q_rad_s += q_rad_s;
                sample.theta_rad += theta_rad;
            }
            Fault::AngleOff { rad } => sample.theta_rad += rad,
            _ => {}
        }
        input
    }

    fn actuate(&mut self, u_rad: f32) {
        let arrives = match self.fault() {
            Some((Fault::ServoStuck, _)) => self.sent,
            Some((Fault::ServoNeutral, _)) => 0.0,
            Some((Fault::ServoWeak { share }, _)) => share * u_rad,
            Some((Fault::CommandsPatchy, since)) if since.is_multiple_of(2) => self.sent,
            _ => u_rad,
        };
        self.sent = arrives;
        self.vehicle.actuate(arrives);
    }

    fn emit(&mut self, telemetry: &Telemetry) {
        self.vehicle.emit(telemetry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::{BackgroundTruth, vehicle};
    use crate::scenario::Scenario;

    /// What the core is given, and what the servo does, over 20 ticks of commands 1, 2, 3, …
    fn flown(fault: Fault) -> Vec<(Input, f32)> {
        let scenario = Scenario::campaign(4, 0.015, 1).unwrap();
        let calm = BackgroundTruth::of_strength(crate::Air::BandPassed, 0.0, 5.0, 0.4);
        let failing = Failing { fault, from: 5, to: 9 };
        let mut failing = FailingVehicle::new(vehicle(&scenario, calm).unwrap(), Some(failing));
        let flown = (0..20).map(|tick| {
            let input = failing.sense(tick);
            failing.actuate(tick as f32);
            (input, failing.sent)
        });
        flown.collect()
    }

    #[test]
    fn a_fault_is_there_in_its_ticks_alone() {
        let lost: Vec<usize> = (0..20).filter(|&k| flown(Fault::SamplesLost)[k].0.sample.is_none()).collect();
        assert_eq!(lost, [5, 6, 7, 8]);
        let sound = flown(Fault::ServoWeak { share: 1.0 });
        let frozen = flown(Fault::RateFrozen);
        for k in 0..20 {
            let [q, truth] = [&frozen, &sound].map(|flown| flown[k].0.sample.unwrap().q_rad_s);
            let held = sound[4].0.sample.unwrap().q_rad_s;
            assert_eq!(q, if (5..9).contains(&k) { held } else { truth }, "{k}");
        }
    }

    #[test]
    fn late_samples_keep_the_time_at_which_they_were_taken() {
        let late = flown(Fault::SamplesLate { ticks: 2 });
        let times: Vec<u64> = late.iter().map(|(input, _)| input.sample.unwrap().time_us / 20_000).collect();
        assert_eq!(times[3..11], [3, 4, 3, 4, 5, 6, 9, 10]);
    }

    #[test]
    fn a_stuck_servo_stays_and_a_patchy_link_repeats() {
        let servo = |fault| flown(fault).iter().map(|(_, sent)| *sent).collect::<Vec<_>>()[3..11].to_vec();
        assert_eq!(servo(Fault::ServoStuck), [3.0, 4.0, 4.0, 4.0, 4.0, 4.0, 9.0, 10.0]);
        assert_eq!(servo(Fault::CommandsPatchy), [3.0, 4.0, 4.0, 6.0, 6.0, 8.0, 9.0, 10.0]);
        assert_eq!(servo(Fault::ServoNeutral), [3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 9.0, 10.0]);
    }
}
