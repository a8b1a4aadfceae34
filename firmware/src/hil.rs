//! Hardware in the loop: the simulator's clock in place of the timer's.
//!
//! Every `HIL_SENSOR` is one cycle. The clock starts at the first frame's time, in tick 0; each further frame moves it by the
//! whole ticks that have passed in the simulator, at least one. A frame that skips ticks shows as lost samples, one with an
//! old time as a late sample, one that does not claim to hold rate and specific force as a missing one.

use estimator_core::constants::TICK_US;
use messages::board::{HIL_SENSOR_DATA, HilSensorUpdatedFlags as Updated};

use crate::pitch_filter::Motion;

/// One cycle of the simulator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HilTick {
    /// Number of the cycle.
    pub tick: u32,
    /// The clock, µs.
    pub now_us: u64,
    /// When the sensors were read, µs.
    pub sampled_us: u64,
    /// What they read, if anything.
    pub motion: Option<Motion>,
}

/// The simulator's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HilClock {
    last: Option<(u32, u64)>,
}

impl HilClock {
    /// The cycle that `sensor` stands for.
    pub fn step(&mut self, sensor: &HIL_SENSOR_DATA) -> HilTick {
        let sampled_us = sensor.time_usec;
        let (tick, now_us) = match self.last {
            None => (0, sampled_us),
            Some((tick, now_us)) => {
                let passed = sampled_us.saturating_sub(now_us).saturating_add(u64::from(TICK_US / 2));
                let ticks = (passed / u64::from(TICK_US)).clamp(1, 1_000_000);
                (tick.wrapping_add(ticks as u32), now_us.saturating_add(ticks * u64::from(TICK_US)))
            }
        };
        self.last = Some((tick, now_us));
        let needed = Updated::HIL_SENSOR_UPDATED_XACC
            | Updated::HIL_SENSOR_UPDATED_YACC
            | Updated::HIL_SENSOR_UPDATED_ZACC
            | Updated::HIL_SENSOR_UPDATED_YGYRO;
        let motion = sensor
            .fields_updated
            .contains(needed)
            .then_some(Motion { q_rad_s: sensor.ygyro, force_m_s2: [sensor.xacc, sensor.yacc, sensor.zacc] });
        HilTick { tick, now_us, sampled_us, motion }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_usec: u64) -> HIL_SENSOR_DATA {
        HIL_SENSOR_DATA { time_usec, fields_updated: Updated::all(), ..HIL_SENSOR_DATA::default() }
    }

    fn ticks(times: &[u64]) -> Vec<(u32, u64)> {
        let mut clock = HilClock::default();
        times.iter().map(|&t| clock.step(&at(t))).map(|step| (step.tick, step.now_us)).collect()
    }

    #[test]
    fn frames_on_time_make_one_tick_each_and_gaps_are_counted() {
        let found = ticks(&[500, 20_500, 40_500, 140_500]);
        assert_eq!(found, [(0, 500), (1, 20_500), (2, 40_500), (7, 140_500)]);
    }

    #[test]
    fn a_stale_frame_is_one_tick_with_an_old_sample() {
        let mut clock = HilClock::default();
        clock.step(&at(100_000));
        let step = clock.step(&at(60_000));
        assert_eq!((step.tick, step.now_us - step.sampled_us), (1, 60_000));
    }

    #[test]
    fn no_time_overflows() {
        assert_eq!(ticks(&[0, u64::MAX, 0]).len(), 3);
    }

    #[test]
    fn sensors_that_were_not_read_are_missing() {
        let sensor = HIL_SENSOR_DATA { fields_updated: Updated::HIL_SENSOR_UPDATED_YGYRO, ..at(0) };
        assert_eq!(HilClock::default().step(&sensor).motion, None);
    }
}
