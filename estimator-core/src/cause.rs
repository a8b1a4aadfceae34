//! Why the supervisor acted: causes with their numbers, and the sentences made of them.

use core::fmt;

use crate::constants::SAMPLE_PERIOD_S;
use crate::decimal::Decimal;

/// A limit that was crossed. The attitude controller takes over until the vehicle is level and slow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trip {
    /// |θ| above its limit, rad.
    Angle {
        /// θ found, rad.
        found: f32,
        /// Limit, rad.
        limit: f32,
    },
    /// |q| above its limit, rad/s.
    Rate {
        /// q found, rad/s.
        found: f32,
        /// Limit, rad/s.
        limit: f32,
    },
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angle { found, limit } => {
                let (side, limit) = (sign(*found), Decimal(limit.copysign(*found)));
                write!(f, "pitch {:.2} rad {side} limit {limit:.2} rad", Decimal(*found))
            }
            Self::Rate { found, limit } => {
                let (side, limit) = (sign(*found), Decimal(limit.copysign(*found)));
                write!(f, "pitch rate {:.2} rad/s {side} limit {limit:.2} rad/s", Decimal(*found))
            }
        }
    }
}

const fn sign(found: f32) -> char {
    if found < 0.0 { '<' } else { '>' }
}

/// A measured quantity.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Channel {
    /// q.
    PitchRate,
    /// θ.
    PitchAngle,
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PitchRate => "pitch rate",
            Self::PitchAngle => "pitch angle",
        })
    }
}

/// A reason to end the test early. It cannot be resumed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The vehicle keeps running into the limits.
    TooManyRecoveries {
        /// Recoveries allowed in one test; this would have been one more.
        allowed: u32,
        /// The last limit crossed.
        trip: Trip,
    },
    /// The controller does not bring the vehicle back.
    RecoveryTooLong {
        /// Ticks since the limit was crossed.
        ticks: u32,
        /// The limit crossed.
        trip: Trip,
    },
    /// NaN or infinity.
    NotFinite {
        /// The quantity.
        channel: Channel,
    },
    /// What no sensor can read.
    OutOfRange {
        /// The quantity.
        channel: Channel,
        /// Ticks without a usable sample in a row.
        ticks: u32,
    },
    /// The same bit pattern again and again.
    Frozen {
        /// The quantity.
        channel: Channel,
        /// Identical samples in a row.
        samples: u32,
    },
    /// No sample.
    Missing {
        /// Ticks without a usable sample in a row.
        ticks: u32,
    },
    /// Samples too old to act on.
    Late {
        /// Ticks without a usable sample in a row.
        ticks: u32,
        /// Age of the last one, µs.
        age_us: u64,
    },
    /// The operator's command.
    Operator,
}

impl Fault {
    /// True where the measurements and the controller can still be relied on to hold the vehicle level.
    #[must_use]
    pub const fn leaves_control(&self) -> bool {
        matches!(self, Self::TooManyRecoveries { .. } | Self::Operator)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyRecoveries { allowed, trip } => {
                write!(f, "{trip} after {allowed} recoveries, all that one test may have")
            }
            Self::RecoveryTooLong { ticks, trip } => {
                write!(f, "not level {:.2} s after {trip}", Decimal(seconds(*ticks)))
            }
            Self::NotFinite { channel } => write!(f, "{channel} is not a number"),
            Self::OutOfRange { channel, ticks } => {
                write!(f, "{channel} beyond what a sensor reads, for {ticks} ticks")
            }
            Self::Frozen { channel, samples } => write!(f, "{channel} unchanged for {samples} samples"),
            Self::Missing { ticks } => write!(f, "no sample for {ticks} ticks"),
            Self::Late { ticks, age_us } => {
                write!(
                    f,
                    "no timely sample for {ticks} ticks, the last is {:.1} ms old",
                    Decimal(*age_us as f32 / 1e3)
                )
            }
            Self::Operator => f.write_str("operator's command"),
        }
    }
}

fn seconds(ticks: u32) -> f32 {
    ticks as f32 * SAMPLE_PERIOD_S
}

/// A transition of the supervisor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The test began.
    Started,
    /// A limit was crossed; the controller takes over.
    Tripped(Trip),
    /// The vehicle is level and slow again; the test goes on where it stood.
    Resumed {
        /// Length of the recovery, ticks.
        after_ticks: u32,
    },
    /// The test is complete.
    Finished {
        /// Recoveries that it took.
        recoveries: u32,
    },
    /// The test was broken off.
    Aborted(Fault),
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Started => f.write_str("started"),
            Self::Tripped(trip) => write!(f, "recovering: {trip}"),
            Self::Resumed { after_ticks } => {
                write!(f, "resumed after {:.2} s", Decimal(seconds(*after_ticks)))
            }
            Self::Finished { recoveries } => write!(f, "finished with {recoveries} recoveries"),
            Self::Aborted(fault) => write!(f, "aborted: {fault}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn causes_read_as_sentences_with_numbers() {
        let up = Trip::Angle { found: 0.41, limit: 0.4 };
        let down = Trip::Rate { found: -2.1, limit: 2.0 };
        assert_eq!(up.to_string(), "pitch 0.41 rad > limit 0.40 rad");
        assert_eq!(down.to_string(), "pitch rate -2.10 rad/s < limit -2.00 rad/s");
        assert_eq!(
            Event::Aborted(Fault::RecoveryTooLong { ticks: 251, trip: up }).to_string(),
            "aborted: not level 5.02 s after pitch 0.41 rad > limit 0.40 rad"
        );
        assert_eq!(
            Fault::Late { ticks: 3, age_us: 25_400 }.to_string(),
            "no timely sample for 3 ticks, the last is 25.4 ms old"
        );
    }
}
