//! `pitchid fly`: runs the experiment on a board.

use super::board_arguments::Line;
use crate::board::taps::TapsFile;
use crate::board::{CycleReport, Heard, Log, Phase, Station, Stop};
use crate::failure::Failure;
use crate::output;
use clap::Args;
use estimator_core::constants::{CAMPAIGN_DWELL_S, SAMPLE_PERIOD_S};
use estimator_core::monitor::MonitorModel;
use messages::MessageData;
use messages::board::{DEBUG_FLOAT_ARRAY_DATA, MavCmd};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use sysid::monitor::read_monitor;

/// Runs the experiment on a board: arms, starts, watches, records, disarms
///
/// Shows state, attitude and convergence once a second, and every text of the board. Ctrl-C breaks the test off and waits
/// until the board has done so. A line that breaks is opened again; the board goes on meanwhile. At the end the recording of
/// the test, until then in RECORDING.csv.part, and the taps of the on-board estimate are written. The blades move: see firmware/README.md before the first time.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    #[command(flatten)]
    line: Line,

    /// Dwell of the PRBS: 1 = 0.05..0.1 s, 2 = 0.1..0.2 s, 3 = 0.2..0.4 s, 4 = 0.4..0.8 s; without it the board's own
    #[arg(long, value_name = "1..4", value_parser = clap::value_parser!(u8).range(1..=4))]
    campaign: Option<u8>,

    /// Amplitude of the PRBS, rad; without it the board's own
    #[arg(long, value_name = "RAD")]
    amplitude: Option<f32>,

    /// Seed of the PRBS; without it the board's own
    #[arg(long, value_name = "N")]
    seed: Option<u32>,

    /// Set the parameters in this file first, as pitchid plan wrote it
    #[arg(long, value_name = "TEST.param")]
    parameters: Option<PathBuf>,

    /// Set any parameter of the board first; goes before those of a file
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting)]
    settings: Vec<(String, f32)>,

    /// Give the board this monitor first, as pitchid identify --monitor-out wrote it; the board keeps it
    #[arg(long, value_name = "MONITOR.toml")]
    monitor: Option<PathBuf>,

    /// Where the recording goes
    #[arg(long, value_name = "RECORDING.csv")]
    out: PathBuf,

    /// Where the taps go
    #[arg(long, value_name = "TAPS.json")]
    taps: Option<PathBuf>,

    /// Write how it ended as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid fly /dev/ttyUSB0 --parameters bench/test-1.param --out first.csv
  pitchid fly /dev/ttyUSB0 --amplitude 0.005 --set LIM_THETA=0.2 --out first.csv
  pitchid identify first.csv --monitor-out craft.toml
  pitchid fly /dev/ttyUSB0 --monitor craft.toml --out second.csv
  pitchid fly tcp:192.168.4.1:5760 --campaign 4 --out flight.csv --taps taps.json

Exit status: 0 the test was flown, however it ended; 2 it could not be begun, or its end was not seen.";

/// How long the board may take to confirm that it has broken the test off.
const ABORT: Duration = Duration::from_secs(5);
/// Pause before it is asked again.
const AGAIN: Duration = Duration::from_millis(300);
/// How long after the start the first cycle of the test may be out.
const START: Duration = Duration::from_secs(30);

fn setting(text: &str) -> Result<(String, f32), String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=VALUE")?;
    Ok((name.to_owned(), value.parse().map_err(|_| format!("{value:?} is no number"))?))
}

/// Flies.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let outputs =
        [Some(&arguments.out), arguments.taps.as_ref(), arguments.json.as_ref()].into_iter().flatten();
    let inputs: Vec<&Path> =
        arguments.monitor.iter().chain(&arguments.parameters).map(PathBuf::as_path).collect();
    output::check(outputs.map(PathBuf::as_path), &inputs)?;
    Log::check(&arguments.out)?;
    let monitor = arguments.monitor.as_deref().map(monitor).transpose()?;
    let wanted = wanted(arguments)?;
    let stop = Stop::on_ctrl_c()?;
    let mut station = arguments.line.open()?;
    station.greet(&stop)?;
    if let Some(monitor) = &monitor {
        station.upload(monitor)?;
    }
    let parameters = set_up(&mut station, wanted)?;
    let mut log = Log::create(&arguments.out, "pitchid fly")?;
    for (name, value) in &parameters {
        log.note(&format!("{name} = {value}"))?;
    }
    station.record(log, true);
    station.order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0)?;
    let flown = start(&mut station, &stop).and_then(|()| watch(&mut station, &stop));
    // whatever happened: the line may be gone, but nothing is left undone that can be done
    let count = parameters.get("LMS_TAPS").map_or(0, |&count| count as usize);
    let taps = flown.is_ok().then(|| fetch_taps(&mut station, count)).transpose()?.flatten();
    let disarmed = station.order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    let kept = station.finish().map(|_| ());
    let last = flown?;
    kept?;
    conclude(arguments, &mut station, &parameters, &last, taps)?;
    disarmed
}

/// The monitor of this file, which must have the board's sample period.
fn monitor(path: &Path) -> Result<MonitorModel, Failure> {
    let (model, step) = read_monitor(path)?;
    if (step / f64::from(SAMPLE_PERIOD_S) - 1.0).abs() > 1e-3 {
        let found = format!("{}: made for a sample every {step:.4} s", path.display());
        return Err(Failure::new(
            found,
            "identify it from a recording of 50 Hz: the board has a cycle every 0.02 s",
        ));
    }
    Ok(model)
}

/// What is to be set: what a file says, and what the command line says instead or besides.
fn wanted(arguments: &Arguments) -> Result<BTreeMap<String, f32>, Failure> {
    let file = arguments.parameters.as_deref().map(experiment::parameters::read).transpose()?;
    let mut wanted: BTreeMap<String, f32> = file.unwrap_or_default().into_iter().collect();
    wanted.extend(arguments.settings.iter().cloned());
    if let Some([low, high]) = arguments.campaign.and_then(|n| CAMPAIGN_DWELL_S.get(usize::from(n) - 1)) {
        wanted.extend([("EXC_DWELL_MIN".to_owned(), *low), ("EXC_DWELL_MAX".to_owned(), *high)]);
    }
    wanted.extend(arguments.amplitude.map(|value| ("EXC_AMPL".to_owned(), value)));
    wanted.extend(arguments.seed.map(|value| ("EXC_SEED".to_owned(), value as f32)));
    Ok(wanted)
}

/// Sets what is wanted and returns all parameters as they stand.
fn set_up(station: &mut Station, wanted: BTreeMap<String, f32>) -> Result<BTreeMap<String, f32>, Failure> {
    let known = station.parameters()?;
    if let Some((name, _)) = wanted.iter().find(|(name, _)| !known.contains_key(*name)) {
        let names: Vec<&str> = known.keys().map(String::as_str).collect();
        return Err(Failure::new(
            format!("the board has no parameter {name}"),
            format!("it has {}", names.join(", ")),
        ));
    }
    // a pair of limits may cross while they are set one by one: what is refused at first is asked for once more
    let mut refused = Vec::new();
    for (name, value) in wanted {
        if station.set(&name, value)?.to_bits() != value.to_bits() {
            refused.push((name, value));
        }
    }
    for (name, value) in refused {
        let found = station.set(&name, value)?;
        if found.to_bits() != value.to_bits() {
            let why = format!("the board keeps {name} at {found}, not {value}: {}", station.said);
            return Err(Failure::new(why, "choose a value in its range, and start it while no test runs"));
        }
    }
    station.parameters()
}

fn start(station: &mut Station, stop: &Stop) -> Result<(), Failure> {
    if stop.wanted() {
        return Err(Failure::new("interrupted before the start; nothing was flown", "run it again"));
    }
    station.order(MavCmd::MAV_CMD_USER_1, 1.0)
}

/// Watches the test to its end and returns its last cycle.
fn watch(station: &mut Station, stop: &Stop) -> Result<CycleReport, Failure> {
    let (begin, mut running, mut shown) = (Instant::now(), false, 0);
    let mut abort = Abort::default();
    loop {
        if stop.wanted() {
            abort.press(station)?;
        }
        let Some(Heard::Cycle(report)) = station.hear(Duration::from_millis(100))? else { continue };
        running |= report.phase.runs();
        if running && !report.phase.runs() {
            return Ok(report);
        }
        if !running && begin.elapsed() > START {
            return Err(Failure::new("the board took the start, but no test runs", "look at what it says"));
        }
        if running && report.time_us / 1_000_000 != shown {
            shown = report.time_us / 1_000_000;
            output::print(&state(&report))?;
        }
    }
}

/// Ctrl-C on its way to the board.
#[derive(Default)]
struct Abort {
    since: Option<Instant>,
    asked: Option<Instant>,
}

impl Abort {
    /// Asks the board to break off, again and again for a while.
    fn press(&mut self, station: &mut Station) -> Result<(), Failure> {
        let since = match self.since {
            Some(since) => since,
            None => {
                output::print("breaking off\n")?;
                *self.since.insert(Instant::now())
            }
        };
        if since.elapsed() > ABORT {
            let message = "the board did not confirm that it has broken the test off";
            return Err(Failure::new(message, "use the kill switch; what was recorded until now is written"));
        }
        if self.asked.is_none_or(|asked| asked.elapsed() > AGAIN) {
            self.asked = Some(Instant::now());
            station.send(MavCmd::MAV_CMD_USER_1, 0.0);
        }
        Ok(())
    }
}

fn state(report: &CycleReport) -> String {
    let CycleReport {
        time_us, section, phase, u_rad, verdict, figures: [settling, drift, innovation], ..
    } = report;
    let motion = report
        .sample
        .map_or("no sample".to_owned(), |[q, theta]| format!("θ {theta:+.3} rad  q {q:+.3} rad/s"));
    format!(
        "{:8.1} s  {section:3} {phase:10}  {motion}  u {u_rad:+.4} rad  taps {verdict}: settling {settling:.1}, drift {drift:.2}, innovation {innovation:.2}\n",
        *time_us as f64 / 1e6
    )
}

/// The taps at the end, asked for again if they were lost.
fn fetch_taps(station: &mut Station, count: usize) -> Result<Option<Vec<f32>>, Failure> {
    let begin = Instant::now();
    loop {
        if let Some(taps) = station.taps(count) {
            return Ok(Some(taps));
        }
        if begin.elapsed() > ABORT {
            return Ok(None);
        }
        station.send(MavCmd::MAV_CMD_REQUEST_MESSAGE, DEBUG_FLOAT_ARRAY_DATA::ID as f32);
        station.hear(Duration::from_millis(300))?;
    }
}

fn conclude(
    arguments: &Arguments,
    station: &mut Station,
    parameters: &BTreeMap<String, f32>,
    last: &CycleReport,
    taps: Option<Vec<f32>>,
) -> Result<(), Failure> {
    if let Some(log) = station.log() {
        let end = match last.phase {
            Phase::Done => "finished",
            Phase::Aborted => "broken off",
            _ => "the board was reset",
        };
        output::print(&format!("{}: {}; {end}\n", arguments.out.display(), log.counted()))?;
        if let Some(path) = &arguments.json {
            let answer = serde_json::json!({
                "schema": "pitchid.flown/1",
                "recording": arguments.out.display().to_string(),
                "samples": log.rows,
                "cycles_lost": log.lost,
                "end": end,
                "taps": taps,
                "taps_verdict": last.verdict,
            });
            output::write(path, &output::json(&answer)?)?;
        }
    }
    let Some(taps) = taps else { return output::print("taps: did not arrive\n") };
    let gain: f32 = taps.iter().sum();
    output::print(&format!("taps: {}, {}, sum {gain:.2} rad/s per rad\n", taps.len(), last.verdict))?;
    let Some(path) = &arguments.taps else { return Ok(()) };
    let [settling, gain_drift, innovation_ratio] = last.figures;
    let first_lag = 1 + parameters.get("LMS_DELAY").map_or(0, |&delay| delay as u32);
    let [schema, unit] = TapsFile::heads();
    let answer = TapsFile {
        schema,
        unit,
        step_s: SAMPLE_PERIOD_S,
        first_lag,
        verdict: last.verdict.into(),
        settling,
        gain_drift,
        innovation_ratio,
        lms_step: parameters.get("LMS_STEP").copied(),
        lms_leakage: parameters.get("LMS_LEAK").copied(),
        taps,
    };
    output::write(path, &output::json(&answer)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_a_name_and_a_number() {
        assert_eq!(setting("LIM_THETA=0.2"), Ok(("LIM_THETA".to_owned(), 0.2)));
        assert!(setting("LIM_THETA").unwrap_err().contains("NAME=VALUE"));
        assert!(setting("LIM_THETA=x").unwrap_err().contains("no number"));
    }
}
