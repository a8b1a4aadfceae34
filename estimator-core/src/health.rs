//! Is the sample fit to act on?
//!
//! A sample is *usable* when it is present, no older than the limit, finite, and within what a sensor can read. Lost
//! samples (missing, late, out of range, or ticks that the caller skipped) are bridged for a few ticks, then they are a
//! fault; NaN, infinity and a frozen channel are faults at once.
//!
//! The range is that of the widest gyro of the class, ±2000 °/s = 34.9 rad/s, and one turn of the angle: a controller that acts on a
//! rate of 1000 rad/s throws the vehicle over in the very time in which it holds its output at the limit.
//!
//! Frozen: n identical bit patterns in a row of one channel, n = 10 by default. Odds of a false alarm: a gyro
//! of 0.015 rad/s noise and a resolution of 0.001 rad/s repeats a sample with probability 1/(2√π·15) = 0.019,
//! nine times in a row with 3e-16; even with noise of one step only it is 0.27⁹ = 8e-6 per sample, so such a
//! sensor wants n = 20.

use crate::cause::{Channel, Fault};
use crate::input::Sample;

/// Largest |q| that a sample can have, rad/s.
const MAX_RATE_RAD_S: f32 = 35.0;
/// Largest |θ| that a sample can have, rad.
const MAX_ANGLE_RAD: f32 = 6.3;

/// Limits on samples, checked by the supervisor's `build`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Health {
    pub(crate) lost_ticks: u32,
    pub(crate) max_age_us: u64,
    /// 0 switches the check off.
    pub(crate) frozen_samples: u32,
}

/// What the checks remember.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HealthState {
    lost: u32,
    last_tick: Option<u32>,
    q: Repeats,
    theta: Repeats,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Repeats {
    bits: u32,
    count: u32,
}

impl Repeats {
    fn count(&mut self, value: f32) -> u32 {
        let bits = value.to_bits();
        self.count = if bits == self.bits { self.count.saturating_add(1) } else { 1 };
        self.bits = bits;
        self.count
    }
}

impl Health {
    /// The usable sample, nothing while a loss is bridged, or the fault.
    ///
    /// # Errors
    /// The fault that ends a test.
    pub fn check(
        &self,
        state: &mut HealthState,
        tick: u32,
        now_us: u64,
        sample: Option<Sample>,
    ) -> Result<Option<Sample>, Fault> {
        let skipped = state.last_tick.map_or(0, |last| tick.wrapping_sub(last).wrapping_sub(1));
        state.last_tick = Some(tick);
        let age_us = sample.map(|s| now_us.saturating_sub(s.time_us));
        let mut timely = sample.filter(|_| age_us.is_some_and(|age| age <= self.max_age_us));
        let mut wild = None;
        if let Some(sample) = timely
            && !(sample.q_rad_s.abs() <= MAX_RATE_RAD_S && sample.theta_rad.abs() <= MAX_ANGLE_RAD)
        {
            timely = None;
            wild = Some(out_of_range(&sample)?);
        }
        let lost_now = u32::from(timely.is_none());
        if skipped == 0 && lost_now == 0 {
            state.lost = 0;
        } else {
            state.lost = state.lost.saturating_add(skipped).saturating_add(lost_now);
        }
        if state.lost >= self.lost_ticks {
            let ticks = state.lost;
            return Err(match (age_us, wild) {
                (_, Some(channel)) => Fault::OutOfRange { channel, ticks },
                (Some(age_us), _) if age_us > self.max_age_us => Fault::Late { ticks, age_us },
                _ => Fault::Missing { ticks },
            });
        }
        timely.map(|sample| self.content(state, sample)).transpose()
    }

    fn content(&self, state: &mut HealthState, sample: Sample) -> Result<Sample, Fault> {
        let channels = [
            (Channel::PitchRate, sample.q_rad_s, &mut state.q),
            (Channel::PitchAngle, sample.theta_rad, &mut state.theta),
        ];
        for (channel, value, repeats) in channels {
            let samples = repeats.count(value);
            if self.frozen_samples > 0 && samples >= self.frozen_samples {
                return Err(Fault::Frozen { channel, samples });
            }
        }
        Ok(sample)
    }
}

/// The channel that reads what no sensor can, of a sample that has one.
///
/// # Errors
/// It reads NaN or infinity.
#[cold]
fn out_of_range(sample: &Sample) -> Result<Channel, Fault> {
    for (channel, value) in [(Channel::PitchRate, sample.q_rad_s), (Channel::PitchAngle, sample.theta_rad)] {
        if !value.is_finite() {
            return Err(Fault::NotFinite { channel });
        }
    }
    Ok(if sample.q_rad_s.abs() > MAX_RATE_RAD_S { Channel::PitchRate } else { Channel::PitchAngle })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEALTH: Health = Health { lost_ticks: 3, max_age_us: 20_000, frozen_samples: 10 };

    fn sample(tick: u32) -> Sample {
        let time_us = u64::from(tick) * 20_000;
        Sample { time_us, q_rad_s: 0.01 * tick as f32, theta_rad: 0.02 * tick as f32 }
    }

    fn check(state: &mut HealthState, tick: u32, sample: Option<Sample>) -> Result<Option<Sample>, Fault> {
        HEALTH.check(state, tick, u64::from(tick) * 20_000, sample)
    }

    #[test]
    fn two_lost_samples_are_bridged_and_the_third_is_a_fault() {
        let mut state = HealthState::default();
        assert!(check(&mut state, 0, Some(sample(0))).unwrap().is_some());
        assert_eq!(check(&mut state, 1, None), Ok(None));
        assert_eq!(check(&mut state, 2, None), Ok(None));
        assert_eq!(check(&mut state, 3, None), Err(Fault::Missing { ticks: 3 }));
    }

    #[test]
    fn a_good_sample_ends_the_count_of_lost_ones() {
        let mut state = HealthState::default();
        for tick in 0..300 {
            let present = (tick % 3 == 0).then(|| sample(tick));
            assert_eq!(check(&mut state, tick, present), Ok(present));
        }
    }

    #[test]
    fn ticks_that_were_skipped_count_as_lost() {
        let mut state = HealthState::default();
        check(&mut state, 0, Some(sample(0))).unwrap();
        assert!(check(&mut state, 2, Some(sample(2))).is_ok());
        assert_eq!(check(&mut state, 5, Some(sample(5))), Err(Fault::Missing { ticks: 3 }));
    }

    #[test]
    fn old_samples_are_not_used() {
        let mut state = HealthState::default();
        for tick in 2..4 {
            assert_eq!(check(&mut state, tick, Some(sample(tick - 2))), Ok(None));
        }
        let found = check(&mut state, 4, Some(sample(2)));
        assert_eq!(found, Err(Fault::Late { ticks: 3, age_us: 40_000 }));
    }

    #[test]
    fn what_no_sensor_can_read_is_bridged_and_then_a_fault() {
        let mut state = HealthState::default();
        let wild = |tick| Some(Sample { q_rad_s: -1e30, ..sample(tick) });
        assert!(check(&mut state, 0, Some(sample(0))).unwrap().is_some());
        assert_eq!(check(&mut state, 1, wild(1)), Ok(None));
        assert_eq!(check(&mut state, 2, wild(2)), Ok(None));
        let found = check(&mut state, 3, wild(3));
        assert_eq!(found, Err(Fault::OutOfRange { channel: Channel::PitchRate, ticks: 3 }));
    }

    #[test]
    fn one_frozen_channel_is_found_while_the_other_lives() {
        let mut state = HealthState::default();
        for tick in 0..9 {
            assert!(check(&mut state, tick, Some(Sample { q_rad_s: 0.5, ..sample(tick) })).is_ok());
        }
        let found = check(&mut state, 9, Some(Sample { q_rad_s: 0.5, ..sample(9) }));
        assert_eq!(found, Err(Fault::Frozen { channel: Channel::PitchRate, samples: 10 }));
    }

    #[test]
    fn the_range_itself_can_be_read_and_the_channel_beyond_it_is_named() {
        let read = |q_rad_s: f32, theta_rad: f32| {
            let health = Health { lost_ticks: 1, ..HEALTH };
            let sample = Sample { time_us: 0, q_rad_s, theta_rad };
            health.check(&mut HealthState::default(), 0, 0, Some(sample)).err()
        };
        let beyond = |channel| Some(Fault::OutOfRange { channel, ticks: 1 });
        let (q, theta) = (MAX_RATE_RAD_S, MAX_ANGLE_RAD);
        assert_eq!((read(q, -theta), read(-q, theta)), (None, None));
        assert_eq!(read(-q.next_up(), theta), beyond(Channel::PitchRate));
        assert_eq!(read(q, -theta.next_up()), beyond(Channel::PitchAngle));
    }

    #[test]
    fn without_the_check_for_frozen_samples_they_may_stand_for_ever() {
        let health = Health { frozen_samples: 0, ..HEALTH };
        let mut state = HealthState::default();
        for tick in 0..2000 {
            let sample = Sample { time_us: u64::from(tick) * 20_000, ..sample(1) };
            assert_eq!(health.check(&mut state, tick, sample.time_us, Some(sample)), Ok(Some(sample)));
        }
    }

    #[test]
    fn nan_and_infinity_are_faults_at_once() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let found = check(&mut HealthState::default(), 0, Some(Sample { theta_rad: bad, ..sample(0) }));
            assert_eq!(found, Err(Fault::NotFinite { channel: Channel::PitchAngle }));
        }
    }
}
