//! A flight of a log as a recording of one axis.

use super::Flight;
use super::align::{align, beside, between, last_before};
use crate::axes::neighbours;
use crate::failure::Failure;
use flight_logs::Log;
use flight_logs::axes::{Axis, Channel, Channels, Proposal, Series, Setting, assess, channels};
use sysid::error::nearest;
use sysid::recording::{ColumnMap, Expression, Note, NoteKind, ReadOptions, Recording, from_signals};

/// Names of the proposed channels in `--column`, and the columns that they make.
const OWN: [(&str, &str); 3] = [("input", "u_norm"), ("rate", "q_rad_s"), ("angle", "theta_rad")];

/// The channels that were chosen, and what a recording calls them.
pub struct Choice {
    /// The channels, and whether they serve.
    pub proposal: Proposal,
    /// Of input, rate and angle: the column, the name that the user knows, and the factor on top of the channel's own.
    picks: [Pick; 3],
}

#[derive(Clone)]
struct Pick {
    map: ColumnMap,
    factor: f64,
    by_hand: bool,
}

/// The channels of an axis, those by hand before those that are proposed.
pub fn choose_channels(log: &Log, axis: Axis, maps: &[ColumnMap]) -> Result<Choice, Failure> {
    let mut channels = channels(log, axis);
    let mut picks = OWN.map(|(source, target)| Pick {
        map: ColumnMap { target: target.into(), source: Expression::column(source), factor: 1.0 },
        factor: 1.0,
        by_hand: false,
    });
    let proposed = [channels.input.clone(), channels.rate.clone(), channels.angle.clone()];
    for map in maps {
        let option = format!("--column {}={}", map.target, map.source);
        let (slot, target, unit, to_si) = match map.target.as_str() {
            "q_rad_s" => (1, "q_rad_s", "rad/s", 1.0),
            "q_deg_s" => (1, "q_rad_s", "rad/s", 1_f64.to_radians()),
            "theta_rad" => (2, "theta_rad", "rad", 1.0),
            "theta_deg" => (2, "theta_rad", "rad", 1_f64.to_radians()),
            "u_deg" => (0, "u_rad", "rad", 1_f64.to_radians()),
            input if input.starts_with("u_") => (0, input, "", 1.0),
            _ => {
                let help = "of a flight log, map the input (u_norm, u_V, ...), q_rad_s or theta_rad";
                return Err(Failure::new(format!("{option}: not a channel of a flight log"), help));
            }
        };
        let factor = to_si * map.factor;
        let of = |name: &str| named(log, &proposed, name).ok_or_else(|| unknown(log, &option, name));
        let (channel, more) = match map.source.as_column() {
            Some(name) if OWN.iter().any(|(own, _)| *own == name) => (of(name)?, factor),
            Some(name) => {
                (Channel::named(log, name, factor, unit).ok_or_else(|| unknown(log, &option, name))?, 1.0)
            }
            None => {
                let parts = map.source.names().iter().map(|name| Ok(of(name)?.series(log)));
                let parts = parts.collect::<Result<Vec<Series>, Failure>>()?;
                let series = worked(&map.source, &parts, slot == 0);
                (Channel::worked(map.source.to_string(), series, unit), factor)
            }
        };
        let place = [&mut channels.input, &mut channels.rate, &mut channels.angle];
        for (k, place) in place.into_iter().enumerate() {
            if k == slot {
                *place = Some(channel.clone());
            }
        }
        let map = ColumnMap { target: target.into(), source: map.source.clone(), factor };
        picks[slot] = Pick { map, factor: more, by_hand: true };
    }
    Ok(Choice { proposal: assess(log, axis, channels), picks })
}

/// A channel by the name that a user gives it.
fn named(log: &Log, proposed: &[Option<Channel>; 3], name: &str) -> Option<Channel> {
    match OWN.iter().position(|(own, _)| *own == name) {
        Some(own) => proposed[own].clone(),
        None => Channel::named(log, name, 1.0, ""),
    }
}

/// `expression` over channels of several clocks, on that with the most rows: of the others the last row where they are
/// `held`, else what lies between two rows.
fn worked(expression: &Expression, parts: &[Series], held: bool) -> Series {
    let Some(clock) = parts.iter().max_by_key(|part| part.time_s.len()) else { return Series::default() };
    let at = |part: &Series, t: f64| {
        if held { last_before(part, t) } else { between(part, t) }
    };
    let rows = clock.time_s.iter().filter_map(|&t| {
        let values = parts.iter().map(|part| at(part, t)).collect::<Option<Vec<f64>>>()?;
        Some((t, expression.value(&values))).filter(|(_, value)| value.is_finite())
    });
    let (time_s, values) = rows.unzip();
    Series { time_s, values }
}

fn unknown(log: &Log, option: &str, source: &str) -> Failure {
    let fields = log
        .topics
        .iter()
        .flat_map(|topic| topic.fields.iter().map(|field| format!("{}.{}", topic.title(), field.name)));
    let fields: Vec<String> = OWN.map(|(own, _)| own.to_owned()).into_iter().chain(fields).collect();
    let names = nearest(fields.iter().map(String::as_str), source);
    let help = format!(
        "name a field as topic.field, or what is proposed as input, rate or angle; there are {names}"
    );
    Failure::new(format!("{option}: the log has no channel {source}"), help)
}

/// A channel that stands beside an axis.
struct Beside {
    /// What a recording calls it.
    column: &'static str,
    channel: Channel,
    /// Whether it is a command, held from row to row.
    held: bool,
    /// Whether it may be logged more slowly than the axis.
    slow: bool,
}

/// The other axes' rates, in the places that a recording has for those of roll and yaw beside pitch; thrust and supply. Not their
/// commands: a controller makes them of the same gusts that move this axis, and they would be taken for a cause.
fn others(log: &Log, axis: Axis, own: &Channels) -> Vec<Beside> {
    let [roll, yaw] = neighbours(axis).map(|other| channels(log, other));
    let phi = roll.angle.filter(|_| axis == Axis::Pitch);
    let measured = [("p_rad_s", roll.rate), ("r_rad_s", yaw.rate), ("phi_rad", phi)];
    let all =
        measured.into_iter().chain([("thrust_norm", own.thrust.clone()), ("battery_v", own.battery.clone())]);
    all.filter_map(|(column, channel)| {
        let (held, slow) = (column == "thrust_norm", matches!(column, "thrust_norm" | "battery_v"));
        Some(Beside { column, channel: channel?, held, slow })
    })
    .collect()
}

/// The recording of one axis of a flight.
pub fn recording(flight: &Flight, axis: Axis, options: &ReadOptions) -> Result<Recording, Failure> {
    let log = &flight.log;
    let choice = choose_channels(log, axis, &options.columns)?;
    let proposal = &choice.proposal;
    let (Some(input), Some(rate), true) =
        (&proposal.channels.input, &proposal.channels.rate, proposal.serves())
    else {
        return Err(refusal(flight, proposal));
    };
    let [u, q, theta] = &choice.picks;
    let scaled = |channel: &Channel, pick: &Pick| {
        let series = channel.series(log);
        Series { values: series.values.iter().map(|value| pick.factor * value).collect(), ..series }
    };
    let angle = proposal.channels.angle.as_ref();
    let attitude = angle.map(|angle| scaled(angle, theta));
    let aligned = align(&scaled(input, u), &scaled(rate, q), attitude.as_ref(), theta.by_hand);
    let aligned = aligned.map_err(|found| {
        Failure::new(format!("{}: {found}", flight.name), "cut what is sound with --time FROM..TO")
    })?;
    let mut signals = vec![(u.map.clone(), aligned.input), (q.map.clone(), aligned.rate)];
    let mut told = format!("{}: input {input}, {axis} rate {rate}", flight.name);
    if let (Some(values), Some(angle)) = (aligned.angle, angle) {
        told += &format!(", angle {angle}");
        signals.push((theta.map.clone(), values));
    }
    for Beside { column, channel, held, slow } in others(log, axis, &proposal.channels) {
        let Some(values) = beside(&aligned.t, &channel.series(log), held, slow) else { continue };
        told += &format!(", {column} {channel}");
        signals.push((
            ColumnMap { target: column.into(), source: Expression::column(column), factor: 1.0 },
            values,
        ));
    }
    if axis != Axis::Pitch {
        told += &format!("; what is called pitch here is {axis}");
    }
    let mut notes = vec![told];
    if !u.by_hand {
        let loop_closed = "the input is what the autopilot's controller asks for: the loop is closed";
        notes.push(loop_closed.to_owned());
    }
    notes.extend(aligned.notes);
    notes.extend(proposal.cautions.iter().chain(&log.notes).cloned());
    let mut recording = from_signals(&flight.name, aligned.t, signals, options)?;
    if !(u.by_hand || q.by_hand || theta.by_hand) {
        // the format says the units
        recording.notes.retain(|note| note.kind != NoteKind::Unit);
    }
    let notes = notes.into_iter().map(|text| Note { kind: NoteKind::Converted, time_s: None, text });
    recording.notes.splice(0..0, notes);
    Ok(recording)
}

fn refusal(flight: &Flight, proposal: &Proposal) -> Failure {
    let file = flight.files();
    let found = format!(
        "{}: cannot serve to identify {}: {}",
        flight.name,
        proposal.axis,
        proposal.hindrances.join("; ")
    );
    let help = match settings(&proposal.settings) {
        text if text.is_empty() => format!("pitchid show {file} tells what is in it"),
        text => format!("before the next flight set {text}; pitchid show {file} tells what is in it"),
    };
    Failure::new(found, help)
}

/// Parameters with their values, and what each does.
fn settings(settings: &[Setting]) -> String {
    let words = settings.iter().map(|s| format!("{} = {} ({})", s.parameter, s.value, s.effect()));
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_of_two_clocks_are_worked_out_on_the_faster() {
        let series = |count: u32, step: f64| {
            let time_s: Vec<f64> = (0..count).map(|k| step * f64::from(k)).collect();
            Series { values: time_s.clone(), time_s }
        };
        let mut slow = series(21, 0.1);
        slow.time_s.drain(10..15);
        slow.values.drain(10..15);
        let parts = [slow, series(200, 0.01)];
        let expression: Expression = "a-b".parse().unwrap();
        let (line, held) = (worked(&expression, &parts, false), worked(&expression, &parts, true));
        assert!(line.values.iter().all(|value| value.abs() < 1e-12), "{:?}", line.values);
        assert!(held.values.iter().all(|value| (-0.36..1e-9).contains(value)), "{:?}", held.values);
        assert!(
            !line.time_s.iter().any(|t| (0.95..1.45).contains(t)),
            "nothing is made up where one is silent"
        );
        assert_eq!(held.time_s[0], 0.0);
        let divided: Expression = "b/(a-a)".parse().unwrap();
        assert!(worked(&divided, &parts, true).values.is_empty(), "rows without a finite value are left out");
    }
}
