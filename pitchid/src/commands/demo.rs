//! `pitchid demo`: the whole way, from a concealed effect to its name, without data of one's own.

use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::Report;
use crate::report::content::Content;
use crate::report::repeat::Repeat;
use crate::report::traces::View;
use crate::{output, report, text};
use benchmark::nominal;
use clap::Args;
use host_sim::calibrate::{Strength, draw_effect};
use host_sim::{Plant, Scenario, fly};
use std::path::{Path, PathBuf};
use sysid::diagnosis::{Diagnosis, diagnose};
use sysid::identify::compare::{Identification, identify};
use sysid::recording::{ReadOptions, Recording, read};

mod reveal;

/// Conceals an effect in a simulated vehicle, flies the experiment, and finds out what was concealed
///
/// Flies a test on a vehicle whose parameters and concealed effect a seed has drawn, identifies it by every method, diagnoses
/// the recording against the nominal model, and only then opens the truth file. Prints the methods side by side, the fit
/// before and after, and whether the diagnosis was right. Takes some seconds.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Seed that draws the vehicle, the effect, its size, and the noise
    #[arg(long, value_name = "N", default_value_t = 8)]
    seed: u64,

    /// Folder for recording, model, report and truth
    #[arg(long, value_name = "DIR", default_value = "pitchid-demo")]
    out: PathBuf,

    /// Write identification, diagnosis and truth as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Writes into DIR:
  recording.csv   what a rig would have logged       model.toml      the nominal model, as a user would have it
  truth.json      what was concealed                 extended.toml   the model with what was found
  report.html     the report                         diagnosis.json  the answer
  demo.svg        measured, before and after

Examples:
  pitchid demo
  pitchid demo --seed 7 --out /tmp/seven

Exit status: 0 the demonstration ran, whether or not the diagnosis was right; 2 the folder could not be used.";

/// Dwell 0.4 to 0.8 s: the excitation with which the paper validates.
const CAMPAIGN: usize = 4;
const AMPLITUDE_RAD: f32 = 0.015;

/// What may be concealed: effects whose names say what they are.
const DRAWN: [&str; 7] = [
    "servo_lag",
    "trim_offset",
    "coulomb_friction",
    "quadratic_drag",
    "gravity_stiffness",
    "extra_delay",
    "gust_disturbance",
];

/// The files of a demonstration.
struct Files<'a>(&'a Path);

impl Files<'_> {
    fn named(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
    fn write(&self, name: &str, text: &str) -> Result<(), Failure> {
        output::write(&self.named(name), text)
    }
}

/// Demonstrates.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = arguments.out.as_path();
    output::check(arguments.json.as_deref(), &[])?;
    output::folder(folder)?;
    let files = Files(folder);
    let progress = Progress::start("concealing an effect and flying the test");
    conceal_and_fly(arguments.seed, &files)?;
    let model = nominal();
    files.write("model.toml", &model.to_toml()?)?;

    let path = files.named("recording.csv");
    let recording = [read(&path, &ReadOptions::default())?];
    let identified = identify(&recording, Some(&model), &|step| progress.say(step))?;
    progress.say("diagnosing".into());
    let found = diagnose(&recording, Some(&model), &|step| progress.say(step))?;
    drop(progress);

    let named = Some((files.named("model.toml").display().to_string(), model));
    let named = named.as_ref().map(|(name, model)| (name.as_str(), model));
    let content = Content::new(&found.answer, &found.traces, vec![path.display().to_string()], named);
    write_answers(&files, &found, &content, &recording)?;
    output::print(&told(arguments, &recording[0], &identified, &content))?;
    output::print(&reveal::reveal(&files.named("truth.json"), &found.answer)?)?;
    output::print(&format!("\nReport: {}\n", files.named("report.html").display()))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    let answer = serde_json::json!({
        "schema": "pitchid.demo/1",
        "seed": arguments.seed,
        "folder": folder.display().to_string(),
        "identification": identified,
        "diagnosis": found.answer,
        "truth": reveal::truth(&files.named("truth.json"))?,
    });
    output::write(path, &output::json(&answer)?)
}

/// Draws a vehicle and an effect, flies the test, and leaves nothing behind but the files.
fn conceal_and_fly(seed: u64, files: &Files<'_>) -> Result<(), Failure> {
    let mut scenario = Scenario::campaign(CAMPAIGN, AMPLITUDE_RAD, seed)?;
    scenario.plant = Plant::drawn(seed);
    let (effect, _) = draw_effect(&scenario, &DRAWN, Strength::Strong)?;
    scenario.effects = vec![effect];
    let flight = fly(&scenario)?;
    files.write("recording.csv", &flight.recording())?;
    files.write("truth.json", &flight.truth_json()?)
}

fn write_answers(
    files: &Files<'_>,
    found: &Diagnosis,
    content: &Content,
    recordings: &[Recording],
) -> Result<(), Failure> {
    files.write("diagnosis.json", &output::json(&found.answer)?)?;
    files.write("extended.toml", &found.model.to_toml()?)?;
    let inputs = ["recording.csv", "model.toml"].map(|name| files.named(name));
    let repeat = Repeat::of_this_run(&inputs.each_ref().map(PathBuf::as_path));
    files.write("report.html", &Report { content, found, recordings, repeat }.html())?;
    let Some(trace) = report::headline_trace(&found.traces) else { return Ok(()) };
    let view = View {
        trace,
        recording: recordings.get(trace.recording),
        changed: report::is_changed(&found.answer),
        windows: &[],
    };
    files.write("demo.svg", &view.large().file(900))
}

fn told(
    arguments: &Arguments,
    recording: &Recording,
    identified: &Identification,
    content: &Content,
) -> String {
    let sections: Vec<&str> = recording.sections.iter().map(|s| s.label.as_str()).collect();
    let mut text = text::paragraph(&format!(
        "Flown: seed {}, PRBS of 0.4 to 0.8 s and {AMPLITUDE_RAD} rad, sections {}; {} samples at {:.0} Hz. A vehicle and an \
         effect drawn by the seed; the model knows neither.",
        arguments.seed,
        sections.join(", "),
        recording.len(),
        1.0 / recording.step,
    ));
    text.push_str(&format!("\nIdentified. {}", text::methods(identified)));
    text.push_str("\nDiagnosed. ");
    text.push_str(&text::diagnosis(content));
    text
}
