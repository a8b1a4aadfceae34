//! What is shown of a log, as data.

use crate::logs::excitation::{Span, spans};
use crate::logs::{Flight, format_name};
use chart::min_max_rows;
use flight_logs::axes::{Axis, Channel, Series, propose};
use flight_logs::{Log, Topic};
use serde::Serialize;
use sysid::recording::Recording;

/// A step beyond this many of the usual ones is a gap.
const GAP: f64 = 3.5;
/// Points of each curve.
const POINTS: usize = 2400;

/// One flight of a log, or one recording.
#[derive(Serialize)]
#[serde(untagged)]
pub enum Shown {
    Flight(ShownFlight),
    Recording(ShownRecording),
}

/// One flight of a log.
#[derive(Serialize)]
pub struct ShownFlight {
    pub name: String,
    /// The files, as arguments of a command.
    pub files: String,
    /// Counted from 1.
    pub flight: usize,
    #[serde(skip)]
    pub one_of_several: bool,
    pub format: &'static str,
    pub firmware: Option<String>,
    pub vehicle: Option<String>,
    /// First and last time of the log's own clock, s.
    pub time_s: Option<[f64; 2]>,
    pub axes: Vec<ShownAxis>,
    pub topics: Vec<ShownTopic>,
    pub notes: Vec<String>,
}

/// What a log offers for an axis.
#[derive(Serialize)]
pub struct ShownAxis {
    pub axis: String,
    pub can_serve: bool,
    pub channels: Vec<ShownChannel>,
    /// Where input and rate move.
    pub excitation: Vec<Span>,
    /// Why it cannot serve.
    pub hindrances: Vec<String>,
    /// What makes a result doubtful.
    pub cautions: Vec<String>,
    /// What to set before the next flight.
    pub settings: Vec<ShownSetting>,
    /// What a report draws.
    #[serde(skip)]
    pub curves: Vec<Curve>,
}

/// A channel over time, in as many points as a picture shows.
pub struct Curve {
    /// input, rate, angle, set-point.
    pub role: &'static str,
    pub unit: &'static str,
    pub series: Series,
}

/// One channel of an axis.
#[derive(Serialize)]
pub struct ShownChannel {
    /// input, rate, angle, set-point.
    pub role: &'static str,
    pub source: String,
    pub rate_hz: Option<f64>,
    pub unit: &'static str,
    pub reason: String,
}

/// A parameter of the flight stack.
#[derive(Serialize)]
pub struct ShownSetting {
    pub parameter: &'static str,
    pub value: String,
    pub now: Option<f64>,
    pub effect: String,
}

/// One topic.
#[derive(Serialize)]
pub struct ShownTopic {
    pub name: String,
    pub rows: usize,
    pub rate_hz: Option<f64>,
    pub gaps: usize,
    pub time_s: [f64; 2],
    pub fields: Vec<String>,
}

/// A recording in the project's format.
#[derive(Serialize)]
pub struct ShownRecording {
    pub name: String,
    /// Which of several.
    pub axis: Option<String>,
    pub format: &'static str,
    pub rows: usize,
    pub rate_hz: f64,
    pub time_s: [f64; 2],
    /// Column of the format, and the file's.
    pub columns: Vec<[String; 2]>,
    pub sections: Vec<ShownSection>,
    pub gaps: usize,
    pub excitation: Vec<Span>,
    pub notes: Vec<String>,
    /// Options that it was read with, as the next command takes them.
    #[serde(skip)]
    pub options: String,
    /// What a report draws.
    #[serde(skip)]
    pub curves: Vec<Curve>,
}

/// A section of a recording.
#[derive(Serialize)]
pub struct ShownSection {
    pub label: String,
    pub rows: usize,
    pub time_s: [f64; 2],
}

/// Of one flight.
pub fn of_flight(flight: &Flight, axes: &[Axis]) -> ShownFlight {
    let log = &flight.log;
    ShownFlight {
        name: flight.name.clone(),
        files: flight.files(),
        flight: flight.number,
        one_of_several: flight.one_of_several,
        format: format_name(log.format),
        firmware: log.firmware.clone(),
        vehicle: log.vehicle.clone(),
        time_s: log.span_s(),
        axes: axes.iter().map(|&axis| of_axis(log, axis)).collect(),
        topics: log.topics.iter().map(of_topic).collect(),
        notes: log.notes.clone(),
    }
}

fn of_axis(log: &Log, axis: Axis) -> ShownAxis {
    let proposal = propose(log, axis);
    let channels = &proposal.channels;
    let roles = [
        ("input", &channels.input),
        ("rate", &channels.rate),
        ("angle", &channels.angle),
        ("set-point", &channels.setpoint),
    ];
    let shown = |(role, channel): (&'static str, &Option<Channel>)| {
        channel.as_ref().map(|channel| ShownChannel {
            role,
            source: channel.to_string(),
            rate_hz: channel.rate_hz,
            unit: channel.unit,
            reason: channel.reason.clone(),
        })
    };
    let series = |channel: &Option<Channel>| channel.as_ref().map(|channel| channel.series(log));
    let (mut input, mut rate) = (series(&channels.input), series(&channels.rate));
    let excitation = input.as_ref().map(|input| spans(input, rate.as_ref()));
    let curve = |(role, channel): (&'static str, &Option<Channel>)| {
        let all = match role {
            "input" => input.take(),
            "rate" => rate.take(),
            _ => series(channel),
        };
        Some(Curve::new(role, channel.as_ref()?.unit, &all?))
    };
    let setting = |setting: &flight_logs::axes::Setting| ShownSetting {
        parameter: setting.parameter,
        value: setting.value.clone(),
        now: log.parameter(setting.parameter),
        effect: setting.effect(),
    };
    ShownAxis {
        axis: axis.to_string(),
        can_serve: proposal.serves(),
        channels: roles.into_iter().filter_map(shown).collect(),
        excitation: excitation.unwrap_or_default(),
        hindrances: proposal.hindrances.clone(),
        cautions: proposal.cautions.clone(),
        settings: proposal.settings.iter().map(setting).collect(),
        curves: roles.into_iter().filter_map(curve).collect(),
    }
}

impl Curve {
    fn new(role: &'static str, unit: &'static str, all: &Series) -> Self {
        let rows = min_max_rows(&all.values, POINTS);
        let of = |values: &[f64]| rows.iter().map(|&k| values[k]).collect();
        Self { role, unit, series: Series { time_s: of(&all.time_s), values: of(&all.values) } }
    }
}

fn of_topic(topic: &Topic) -> ShownTopic {
    let rate_hz = topic.rate_hz();
    let is_gap = |pair: &&[f64]| rate_hz.is_some_and(|rate| (pair[1] - pair[0]) * rate > GAP);
    let ends = [topic.time_s.first(), topic.time_s.last()];
    ShownTopic {
        name: topic.title(),
        rows: topic.time_s.len(),
        rate_hz,
        gaps: topic.time_s.windows(2).filter(is_gap).count(),
        time_s: ends.map(|time| time.copied().unwrap_or_default()),
        fields: topic.fields.iter().map(|field| field.name.clone()).collect(),
    }
}

/// Of one recording, or one axis of it.
pub fn of_recording(recording: &Recording, axis: Option<Axis>) -> ShownRecording {
    let series = |values: &[f64]| Series { time_s: recording.t.clone(), values: values.to_vec() };
    let rate = recording.q.as_deref().map(series);
    let curves = [
        ("input", recording.u_unit.symbol(), Some(recording.u.as_slice())),
        ("rate", "rad/s", recording.q.as_deref()),
        ("angle", "rad", recording.theta.as_deref()),
    ];
    let span = |rows: &std::ops::Range<usize>| [recording.t[rows.start], recording.t[rows.end - 1]];
    let section = |section: &sysid::recording::Section| ShownSection {
        label: section.label.clone(),
        rows: section.rows.len(),
        time_s: span(&section.rows),
    };
    ShownRecording {
        name: recording.name.clone(),
        axis: axis.map(|axis| axis.to_string()),
        format: "recording",
        rows: recording.len(),
        rate_hz: 1.0 / recording.step,
        time_s: span(&(0..recording.len())),
        columns: recording.columns.iter().map(|map| [map.target.clone(), map.source.label()]).collect(),
        sections: recording.sections.iter().map(section).collect(),
        gaps: recording.t.windows(2).filter(|pair| pair[1] - pair[0] > 1.5 * recording.step).count(),
        excitation: spans(&series(&recording.u), rate.as_ref()),
        notes: recording.notes.iter().map(|note| note.text.clone()).collect(),
        options: String::new(),
        curves: curves
            .into_iter()
            .filter_map(|(role, unit, values)| Some(Curve::new(role, unit, &series(values?))))
            .collect(),
    }
}
