//! Which channels of a log serve to identify an axis, why, and what to set where none do.
//!
//! The input is what the autopilot asks of the axis (normalised moment); the rate comes from the gyro. Both have to be
//! logged often enough, and the craft has to move.

mod ardupilot;
mod betaflight;
mod channel;
mod px4;

use std::fmt;

pub use channel::{Channel, Formula, Series, Term};

use crate::{Format, Log};

/// Rows per second that input and rate need: the rate loops of small rotorcraft cross over at 3 to 8 Hz, and a period
/// there needs five samples.
pub const LEAST_HZ: f64 = 40.0;

/// Below this standard deviation (rad/s) of the angular rate nothing moved: gyros at rest show some 0.002 rad/s, small
/// craft in flight 0.1 and more.
pub const LEAST_MOTION_RAD_S: f64 = 0.02;

/// Shorter logs hold a handful of periods at the most, s.
const LEAST_S: f64 = 4.0;

/// An axis of the body: x forward, y right, z down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// About x.
    Roll,
    /// About y.
    Pitch,
    /// About z.
    Yaw,
}

impl Axis {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Roll, Self::Pitch, Self::Yaw];

    fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(["roll", "pitch", "yaw"][self.index()])
    }
}

/// The signals of one axis, as far as the log holds them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    /// What the autopilot asks of the axis, normalised.
    pub input: Option<Channel>,
    /// Angular rate, rad/s.
    pub rate: Option<Channel>,
    /// Attitude angle, rad.
    pub angle: Option<Channel>,
    /// Set-point of the angular rate, rad/s.
    pub setpoint: Option<Channel>,
    /// Thrust that is asked for, normalised, up positive.
    pub thrust: Option<Channel>,
    /// Supply, V.
    pub battery: Option<Channel>,
}

/// A parameter of the flight stack and the value to give it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Its name.
    pub parameter: &'static str,
    /// Its value, as the flight stack takes it.
    pub value: String,
    /// What it does.
    effect: &'static str,
    /// Whether the log lists parameters, and this one not.
    unknown: bool,
}

impl Setting {
    /// Of a log's flight stack.
    fn new(log: &Log, parameter: &'static str, value: impl Into<String>, effect: &'static str) -> Self {
        let unknown = !log.parameters.is_empty() && log.parameter(parameter).is_none();
        Self { parameter, value: value.into(), effect, unknown }
    }

    /// What it does, and whether the firmware of the log seems to be without it.
    #[must_use]
    pub fn effect(&self) -> String {
        let missing = "; not among this log's parameters: a firmware that has none of this name passes it over, or is updated";
        format!("{}{}", self.effect, if self.unknown { missing } else { "" })
    }
}

/// What a log offers for an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// The axis.
    pub axis: Axis,
    /// The channels to use.
    pub channels: Channels,
    /// Why the log does not serve, for people; empty where it does.
    pub hindrances: Vec<String>,
    /// What makes a result doubtful, for people.
    pub cautions: Vec<String>,
    /// What to set before the next flight; empty where nothing hinders that a setting could change.
    pub settings: Vec<Setting>,
}

impl Proposal {
    /// Whether an identification can be tried.
    #[must_use]
    pub fn serves(&self) -> bool {
        self.hindrances.is_empty()
    }
}

/// Proposes the channels of `axis`; or says what hinders, and what to set.
#[must_use]
pub fn propose(log: &Log, axis: Axis) -> Proposal {
    assess(log, axis, channels(log, axis))
}

/// The channels of `axis` that the flight stack is known to log.
#[must_use]
pub fn channels(log: &Log, axis: Axis) -> Channels {
    match log.format {
        Format::ULog | Format::Ulog2Csv => px4::channels(log, axis),
        Format::DataFlash | Format::DataFlashText => ardupilot::channels(log, axis),
        Format::Blackbox => betaflight::channels(log, axis),
        Format::Tlog => telemetry(log, axis),
    }
}

/// Says of channels, also of others than those of [`channels`], what hinders, and what to set.
#[must_use]
pub fn assess(log: &Log, axis: Axis, channels: Channels) -> Proposal {
    let mut hindrances = Vec::new();
    let mut slow = false;
    for (channel, what) in [(&channels.input, "input"), (&channels.rate, "angular rate")] {
        match channel {
            None => hindrances.push(format!("the log holds no {what} of {axis}")),
            Some(channel) if channel.rate_hz.is_none_or(|rate| rate < LEAST_HZ) => {
                let found =
                    channel.rate_hz.map_or("hardly ever".to_owned(), |rate| format!("at {rate:.1} Hz"));
                hindrances.push(format!("the {what} {channel} is logged {found}: {LEAST_HZ} Hz are needed"));
            }
            Some(_) => continue,
        }
        slow = true;
    }
    let series = |channel: &Option<Channel>| channel.as_ref().map(|channel| channel.series(log));
    let motion = |channel: &Option<Channel>| deviation(&series(channel)?.values);
    if motion(&channels.input) == Some(0.0) {
        hindrances
            .push(format!("nothing is asked of {axis}: its input never changes; fly, and excite the axis"));
    }
    let rate = series(&channels.rate);
    let seconds = rate.as_ref().and_then(|rate| Some(rate.time_s.last()? - rate.time_s.first()?));
    if let Some(seconds) = seconds.filter(|seconds| *seconds < LEAST_S) {
        hindrances.push(format!(
            "{seconds:.1} s are too short: at least {LEAST_S} s are needed, a hundred are good"
        ));
    } else if let Some(never) = px4::never_armed(log) {
        hindrances.push(format!(
            "the craft was never armed ({never}): its motors stood still; fly, and excite the axis"
        ));
    } else if let Some(motion) = rate.and_then(|rate| deviation(&rate.values))
        && motion < LEAST_MOTION_RAD_S
    {
        hindrances.push(format!(
            "the craft is at rest, or nothing excites it: its {axis} rate varies by {motion:.4} rad/s; fly, and excite the axis"
        ));
    }
    let mut cautions = Vec::new();
    if motion(&channels.setpoint) == Some(0.0) {
        cautions.push(format!(
            "no motion of {axis} was asked for: what moves is noise in a closed loop, and a fit may find the controller \
             instead of the craft"
        ));
    }
    let settings = match log.format {
        _ if !slow => Vec::new(),
        Format::ULog | Format::Ulog2Csv => px4::settings(log),
        Format::DataFlash | Format::DataFlashText => ardupilot::settings(log),
        Format::Blackbox => betaflight::settings(log),
        Format::Tlog => {
            hindrances.push(
                "telemetry by radio is too slow: take the log that the autopilot keeps on board".into(),
            );
            if log.parameter("LOG_BITMASK").is_some() {
                ardupilot::settings(log)
            } else if log.parameter("SDLOG_PROFILE").is_some() {
                px4::settings(log)
            } else {
                Vec::new()
            }
        }
    };
    Proposal { axis, channels, hindrances, cautions, settings }
}

/// Standard deviation.
fn deviation(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    Some(square.sqrt()).filter(|deviation| deviation.is_finite())
}

/// The candidate with the most rows per second; one that stands further in front also where it has two thirds of them.
fn fastest(candidates: impl IntoIterator<Item = Option<Channel>>) -> Option<Channel> {
    let rate = |channel: &Channel| channel.rate_hz.unwrap_or(0.0);
    candidates.into_iter().flatten().reduce(
        |best, next| {
            if rate(&next) > 1.5 * rate(&best) { next } else { best }
        },
    )
}

/// The first candidate whose values change.
fn moving(log: &Log, candidates: impl IntoIterator<Item = Option<Channel>>) -> Option<Channel> {
    let changes = |channel: &Channel| deviation(&channel.series(log).values).is_some_and(|size| size > 0.0);
    candidates.into_iter().flatten().find(changes)
}

/// The topic of this name with the most rows.
fn richest<'a>(log: &'a Log, name: &str) -> Option<&'a crate::Topic> {
    log.topics.iter().filter(|topic| topic.name == name).max_by_key(|topic| topic.time_s.len())
}

fn telemetry(log: &Log, axis: Axis) -> Channels {
    let attitude = richest(log, "ATTITUDE");
    let field = |suffix: &str| format!("{axis}{suffix}");
    let take = |suffix: &str, unit| {
        Channel::sum(attitude?, &[(field(suffix), 1.0)], unit, "estimated on board, sent by radio")
    };
    Channels { rate: take("speed", "rad/s"), angle: take("", "rad"), ..Channels::default() }
}
