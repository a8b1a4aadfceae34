//! `pitchid monitor`: whether the craft still is what was identified.

use super::reading::{Reading, long};
use crate::failure::Failure;
use crate::format::fixed;
use crate::progress::Progress;
use crate::{output, text};
use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use clap::Args;
use estimator_core::monitor::{Cause, Change, MonitorConfig, Verdict};
use serde_json::json;
use std::path::PathBuf;
use sysid::dataset::Dataset;
use sysid::monitor::{Row, read_monitor, replay};

/// Says of a flight whether the craft still is what was identified, and if not, what changed, by how much and since when
///
/// Runs the board's own monitor over the recording: the innovations of the identified model, and for each cause the evidence
/// that they hold of it. Causes are effectiveness, added lag or delay, trim moment, damping, friction, gyro bias and gyro scale.
/// The verdict follows the flight: it says so when a change has gone again, and when there is too little motion to tell.
#[derive(Args)]
#[command(after_help = AFTER_HELP, mut_arg("model", |model| model.hide(true)))]
pub struct Arguments {
    #[command(flatten)]
    reading: Reading,

    /// The monitor, as pitchid identify --monitor-out wrote it
    #[arg(long, value_name = "MONITOR.toml")]
    monitor: PathBuf,

    /// Mean time between false alarms that is asked for, h; a bound from below
    #[arg(long, value_name = "H", default_value_t = 10.0)]
    run_length: f32,

    /// Write the verdicts as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,

    /// Draw the evidence of each cause over time
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid identify bench.csv --monitor-out craft.toml
  pitchid monitor flight.csv --monitor craft.toml --plot evidence.svg
  pitchid identify flight.ulg --axis roll --time 20..80 --monitor-out craft.toml
  pitchid monitor flight.ulg --axis roll --time 80..200 --monitor craft.toml

Exit status: 0 replayed, whatever it says; 2 the input could not be used.";

/// Points that are drawn of a run.
const POINTS: usize = 1500;
/// Causes whose evidence reaches this share of the threshold are drawn in colour.
const SHOWN: f32 = 0.5;

/// Monitors.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let outputs = [&arguments.json, &arguments.plot];
    let reading = arguments.reading.resolved()?;
    let mut inputs = reading.inputs();
    inputs.push(&arguments.monitor);
    output::check(outputs.into_iter().flatten().map(PathBuf::as_path), &inputs)?;
    if arguments.reading.has_model() {
        let help = "leave it out: --monitor holds the model; pitchid identify --model makes another";
        return Err(Failure::new("--model is not for pitchid monitor", help));
    }
    let (model, step) = read_monitor(&arguments.monitor)?;
    let config = MonitorConfig { run_length_h: arguments.run_length, ..MonitorConfig::default() };
    let refuse = |error: estimator_core::ConfigError| {
        Failure::new(error.to_string(), "choose a --run-length within it")
    };
    let monitor = config.build(&model).map_err(refuse)?;
    reading.say_what_is_large();
    let progress = Progress::start("reading");
    let recordings = reading.recordings()?;
    progress.note(long(&recordings).as_deref());
    let data = Dataset::on_board(&recordings, Some(step))?;
    if let Some(run) = data.runs.iter().find(|run| (run.step / step - 1.0).abs() > 0.02) {
        return Err(Failure::new(
            format!(
                "the recording has a sample every {:.4} s, the monitor was made for {step:.4} s",
                run.step
            ),
            "identify the monitor from a recording of the same rate",
        ));
    }
    progress.say("following the recording".into());
    let runs = replay(&monitor, &data);
    drop(progress);
    let events: Vec<Vec<Event>> = runs.iter().map(|rows| events(rows)).collect();
    output::print(&told(&runs, &events))?;
    if let Some(path) = &arguments.plot {
        output::write(path, &picture(&runs))?;
    }
    let Some(path) = &arguments.json else { return Ok(()) };
    let answer = json!({
        "schema": "pitchid.monitoring/1",
        "run_length_h": arguments.run_length,
        "stretches": runs.iter().zip(&events).map(|(rows, events)| json!({
            "from_s": rows.first().map(|row| row.t),
            "to_s": rows.last().map(|row| row.t),
            "events": events.iter().map(Event::json).collect::<Vec<_>>(),
            "most_evidence": Cause::ALL.iter().zip(most(rows)).map(|(cause, most)| (cause.name(), most)).collect::<std::collections::BTreeMap<_, _>>(),
        })).collect::<Vec<_>>(),
    });
    output::write(path, &output::json(&answer)?)
}

/// A change of the verdict.
struct Event {
    t: f64,
    /// When that which is told began, s.
    since: Option<f64>,
    verdict: Verdict,
}

/// The changes of the verdict; one that was told carries the size that it had when it was taken back, or at the end.
fn events(rows: &[Row]) -> Vec<Event> {
    let mut all: Vec<Event> = Vec::new();
    let time = |tick: u32| rows.get(tick as usize).map(|row| row.t);
    for row in rows {
        let verdict = row.report.verdict;
        let since = match verdict {
            Verdict::Changed(change) | Verdict::OneOf(change, _) => time(change.since),
            Verdict::SomethingElse { since } => time(since),
            Verdict::AsIdentified | Verdict::CannotTell(_) => None,
        };
        match all.last_mut().filter(|_| !row.report.changed) {
            Some(last) => (last.verdict, last.since) = (verdict, last.since.or(since)),
            None => all.push(Event { t: row.t, since, verdict }),
        }
    }
    all
}

impl Event {
    fn words(&self) -> String {
        let since = self.since.map_or(String::new(), |since| format!(" since {since:.1} s"));
        match self.verdict {
            Verdict::Changed(change) => format!("changed: {change}{since}"),
            Verdict::OneOf(a, b) => format!("changed: {a}, or {b}{since}"),
            Verdict::SomethingElse { .. } => format!("changed: something else{since}"),
            other => other.to_string(),
        }
    }

    fn json(&self) -> serde_json::Value {
        let of = |change: Change| {
            let (unit, per) = change.cause.unit(change.specific);
            let [size, interval] = [change.size * per, change.interval * per].map(f64::from);
            json!({ "cause": change.cause.name(), "value": size, "unit": unit, "ci95": [size - interval, size + interval] })
        };
        let changes: Vec<_> = match self.verdict {
            Verdict::Changed(change) => vec![of(change)],
            Verdict::OneOf(a, b) => vec![of(a), of(b)],
            _ => Vec::new(),
        };
        json!({ "t_s": self.t, "since_s": self.since, "verdict": self.words(), "changes": changes })
    }
}

/// Largest evidence of each cause over the threshold.
fn most<'a>(rows: impl IntoIterator<Item = &'a Row>) -> [f32; Cause::ALL.len()] {
    let mut most = [0.0_f32; Cause::ALL.len()];
    for row in rows {
        most.iter_mut().zip(row.report.evidence).for_each(|(most, evidence)| *most = most.max(evidence));
    }
    most
}

fn told(runs: &[Vec<Row>], events: &[Vec<Event>]) -> String {
    let mut told = String::new();
    for (rows, events) in runs.iter().zip(events) {
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else { continue };
        told += &text::heading(&format!("{} to {} s", fixed(first.t, 1), fixed(last.t, 1)));
        for event in events {
            told += &format!("{:>9} s  {}\n", fixed(event.t, 1), event.words());
        }
        let mut most: Vec<_> = Cause::ALL.iter().zip(most(rows)).collect();
        most.sort_by(|a, b| b.1.total_cmp(&a.1));
        let named: Vec<String> =
            most.iter().take(3).map(|(cause, most)| format!("{} {most:.2}", cause.name())).collect();
        told += &text::paragraph(&format!("Largest evidence over the threshold: {}.", named.join(", ")));
    }
    told
}

/// Evidence of each cause over time.
fn picture(runs: &[Vec<Row>]) -> String {
    let rows: Vec<&Row> = runs.iter().flatten().collect();
    let every = rows.len().div_ceil(POINTS).max(1);
    let largest = most(rows.iter().copied());
    let mut order: Vec<usize> = (0..Cause::ALL.len()).filter(|&place| largest[place] >= SHOWN).collect();
    order.sort_by(|&a, &b| largest[b].total_cmp(&largest[a]));
    let tones = [Tone::After, Tone::Before, Tone::Third];
    let top = f64::from(largest.iter().copied().fold(1.0, f32::max)) * 1.1;
    let (from, to) = (rows.first().map_or(0.0, |row| row.t), rows.last().map_or(1.0, |row| row.t));
    let of_cause = |place: usize| {
        let rank = order.iter().position(|&of| of == place).filter(|rank| *rank < tones.len());
        let points = |run: &Vec<Row>| {
            run.chunks(every).map(|chunk| [chunk[0].t, f64::from(most(chunk)[place])]).collect()
        };
        let lines = Shape::Lines(runs.iter().map(points).collect());
        match rank {
            Some(rank) => Series::new(Cause::ALL[place].name(), tones[rank], lines),
            None => Series::new("other causes", Tone::Measured, lines),
        }
    };
    let mut series: Vec<Series> = (0..Cause::ALL.len()).map(of_cause).collect();
    series.push(Series::new("told", Tone::Ink, Shape::Dashes(vec![vec![[from, 1.0], [to, 1.0]]])));
    let chart = Chart {
        label: "evidence of each cause over time".into(),
        x: Axis::linear("time, s", from..to),
        panels: vec![Panel {
            height: 190,
            y: Axis::linear("evidence, 1 where it is told", 0.0..top),
            series,
        }],
        windows: Vec::new(),
    };
    chart.file(900)
}
