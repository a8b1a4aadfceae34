//! What is shown of a log, as text.

use super::content::{Shown, ShownAxis, ShownFlight, ShownRecording};
use crate::format::{fixed, plain, plural};
use crate::input;
use crate::logs::excitation::Span;
use crate::text::{bullets, heading, indented, next, paragraph, table};

/// Spans that are listed; the others are counted.
const MOST_SPANS: usize = 6;

/// All, one after the other.
pub fn text(shown: &[Shown]) -> String {
    let texts = shown.iter().map(|shown| match shown {
        Shown::Flight(flight) => of_flight(flight),
        Shown::Recording(recording) => of_recording(recording),
    });
    texts.collect::<Vec<_>>().join("\n\n")
}

fn of_flight(flight: &ShownFlight) -> String {
    let unknown = "firmware unknown";
    let mut head =
        format!("{}: {}, {}", flight.name, flight.format, flight.firmware.as_deref().unwrap_or(unknown));
    if let Some(vehicle) = &flight.vehicle {
        head += &format!(", {vehicle}");
    }
    if let Some([from, to]) = flight.time_s {
        head += &format!("; {} of its clock", lasting([from, to]));
    }
    let mut text = paragraph(&head);
    for axis in &flight.axes {
        text += &of_axis(axis, flight);
    }
    let rows = flight.topics.iter().map(|topic| {
        vec![
            topic.name.clone(),
            topic.rows.to_string(),
            topic.rate_hz.map_or("-".into(), |rate| format!("{rate:.1}")),
            topic.gaps.to_string(),
            fixed(topic.time_s[0], 3),
            fixed(topic.time_s[1], 3),
        ]
    });
    text += &heading("Topics");
    text += &table(&["topic", "rows", "Hz", "gaps", "from, s", "to, s"], rows, 1);
    text + &notes(&flight.notes)
}

fn of_axis(axis: &ShownAxis, flight: &ShownFlight) -> String {
    let verdict = if axis.can_serve { "can be asked" } else { "cannot serve" };
    let mut text = heading(&format!("{}: {verdict}", axis.axis.to_uppercase()));
    let mut line = |words: &str| text += &indented(words, "  ", "    ");
    for channel in &axis.channels {
        let rate = channel.rate_hz.map_or("a single row".into(), |rate| format!("{rate:.1} Hz"));
        line(&format!("{}: {}, {rate}: {}", channel.role, channel.source, channel.reason));
    }
    for words in moving(&axis.excitation) {
        line(&words);
    }
    for hindrance in &axis.hindrances {
        line(&format!("hindered: {hindrance}"));
    }
    for caution in &axis.cautions {
        line(&format!("doubtful: {caution}"));
    }
    for setting in &axis.settings {
        let now = setting.now.map_or(String::new(), |now| format!(" (now {now})"));
        line(&format!("set {} = {}{now}: {}", setting.parameter, setting.value, setting.effect));
    }
    if axis.can_serve {
        let number =
            if flight.one_of_several { format!(" --flight {}", flight.flight) } else { String::new() };
        let longest = axis.excitation.iter().max_by(|a, b| length(a).total_cmp(&length(b)));
        let time = longest
            .map(|span| format!(" --time {}..{}", span.time_s[0].floor(), span.time_s[1].ceil()))
            .unwrap_or_default();
        let files = &flight.files;
        let command = format!("pitchid diagnose {files} --axis {}{number}{time}", axis.axis);
        text += &next("next, and whether the motion suffices", &command);
    }
    text
}

/// "16.8 s, from 121.104 to 137.949 s".
fn lasting([from, to]: [f64; 2]) -> String {
    format!("{:.1} s, from {} to {} s", to - from, fixed(from, 3), fixed(to, 3))
}

fn length(span: &Span) -> f64 {
    span.time_s[1] - span.time_s[0]
}

fn moving(spans: &[Span]) -> Vec<String> {
    let mut longest: Vec<&Span> = spans.iter().collect();
    longest.sort_by(|a, b| length(b).total_cmp(&length(a)));
    let (told, rest) = longest.split_at(longest.len().min(MOST_SPANS));
    let mut told = told.to_vec();
    told.sort_by(|a, b| a.time_s[0].total_cmp(&b.time_s[0]));
    let mut lines: Vec<String> = told
        .into_iter()
        .map(|span| {
            let band = match span.band_rad_s {
                Some([low, high]) => format!(", {} to {} rad/s", plain(low), plain(high)),
                None => String::new(),
            };
            let [from, to] = span.time_s;
            let input = plain(span.input_deviation);
            let rate =
                span.rate_deviation.map_or(String::new(), |rate| format!(", rate ± {} rad/s", plain(rate)));
            format!("moves: {} to {} s{band}; input ± {input}{rate}", fixed(from, 1), fixed(to, 1))
        })
        .collect();
    if !rest.is_empty() {
        let seconds: f64 = rest.iter().map(|span| length(span)).sum();
        lines.push(format!("moves: {}, {seconds:.0} s together", plural(rest.len() as u64, "shorter span")));
    }
    if lines.is_empty() {
        lines.push("moves: never for as long as 3 s".into());
    }
    lines
}

fn of_recording(recording: &ShownRecording) -> String {
    let mut text = paragraph(&format!(
        "{}: {}{}; {} at {} Hz, {}; {} of its clock",
        recording.name,
        recording.format,
        recording.axis.as_ref().map_or(String::new(), |axis| format!(", {axis}")),
        plural(recording.rows as u64, "row"),
        plain(recording.rate_hz),
        plural(recording.gaps as u64, "gap"),
        lasting(recording.time_s),
    ));
    let columns: Vec<String> = recording
        .columns
        .iter()
        .map(|[column, own]| if column == own { column.clone() } else { format!("{column} (from {own})") })
        .collect();
    text += &indented(&format!("columns: {}", columns.join(", ")), "  ", "    ");
    for words in moving(&recording.excitation) {
        text += &indented(&words, "  ", "    ");
    }
    let axis = recording.axis.as_ref().map_or(String::new(), |axis| format!(" --axis {axis}"));
    let file = input::argument(&recording.name);
    text += &next("next", &format!("pitchid diagnose {file}{}{axis}", recording.options));
    let rows = recording.sections.iter().map(|section| {
        let [from, to] = section.time_s;
        vec![section.label.clone(), section.rows.to_string(), fixed(from, 3), fixed(to, 3)]
    });
    text += &heading("Sections");
    text += &table(&["section", "rows", "from, s", "to, s"], rows, 1);
    text + &notes(&recording.notes)
}

fn notes(notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    heading("Noticed") + &bullets(notes)
}
