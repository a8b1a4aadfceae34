//! `pitchid plan`: the experiment before it is flown.

pub mod page;
mod rivals;
pub mod words;

use super::effect_spec::EffectSpec;
use super::reading::model_at;
use super::simulate::Level;
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use crate::report::repeat::Repeat;
use crate::vehicle::{Limits, Vehicle, Wanted};
use clap::Args;
use experiment::{Craft, Plan, Weather, Wishes, plan};
use flight_logs::axes::Axis;
use host_sim::Air;
use std::path::{Path, PathBuf};

/// Plans the experiment before it is flown: amplitude, dwell, length and order, and what to expect of it
///
/// From a model file, or from nothing but size and mass. Looks for the excitation that tells most within the limits, flies it in the
/// simulator with the board's own core, some hundred times, each time on a craft as it may be (a value of the model that has an
/// interval is drawn within it) and in air drawn afresh, and estimates from what was flown as if it were real. Says how far the craft
/// will go, how much of the test the supervisor will take, and how well the parameters will be known; for two rivals of a diagnosis,
/// the chance to tell them apart. Writes the parameters for the board and a page to take to the bench. Takes about half a minute.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// What is known of the craft: a model file, as pitchid identify or diagnose writes it
    #[arg(long, value_name = "MODEL.toml", conflicts_with_all = ["mass", "arm"])]
    model: Option<PathBuf>,

    /// The axis of a model file of several [default: pitch]
    #[arg(long, value_name = "AXIS", value_enum)]
    axis: Option<crate::axes::AxisChoice>,

    /// Mass of the craft, kg, where there is no model
    #[arg(long, value_name = "KG", requires = "arm")]
    mass: Option<f64>,

    /// Distance of the rotors' hubs from the pitch axis, m, where there is no model
    #[arg(long, value_name = "M", requires = "mass")]
    arm: Option<f64>,

    /// Two effects to be told apart, the first at the size that is given or usual; the second at the size that imitates it
    #[arg(long, value_name = "ID[:PARAM=VALUE,...]", num_args = 2, conflicts_with = "diagnosis")]
    rivals: Option<Vec<EffectSpec>>,

    /// The answer of a diagnosis that ended with rivals, as pitchid diagnose --json wrote it
    #[arg(long, value_name = "ANSWER.json", conflicts_with = "mass")]
    diagnosis: Option<PathBuf>,

    /// Angle that must not be passed, rad: the travel of the rig, or what the pilot bears [default: that of pitchid.toml, or 0.5]
    #[arg(long, value_name = "RAD")]
    limit: Option<f64>,

    /// Largest amplitude of the excitation, rad [default: that of pitchid.toml, or 0.03]
    #[arg(long, value_name = "RAD")]
    amplitude: Option<f64>,

    /// Share of the excitation that the supervisor may take, %
    #[arg(long, value_name = "PERCENT", default_value_t = 15.0)]
    supervised: f64,

    /// Longest test, recoveries not counted, s
    #[arg(long, value_name = "S", default_value_t = 240.0)]
    time: f64,

    /// Half the 95 % interval of dM/du that is wanted, %; of dM/dq four times that, of the delay 2 ms for each per cent
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0)]
    accuracy: f64,

    /// How strong the air is: in a test of usual size the true model reaches a VAF of 98, 90 or 75 %
    #[arg(long, value_enum, default_value_t = Level::Lab)]
    background: Level,

    /// Kind of the air: band_passed, three_poles, heavy_tailed or grows_with_command
    #[arg(long, value_name = "AIR", default_value_t = Air::default())]
    air: Air,

    /// Flights by which each test is foretold
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u64).range(10..=10_000))]
    flights: u64,

    /// Seed of everything drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Folder for the parameters of each test, the page and the plan as JSON
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Write the plan as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,

    #[command(flatten)]
    wanted: Wanted,
}

/// Angle that must not be passed where nothing is said, rad: the travel of the paper's test-bed.
const LIMIT_RAD: f64 = 0.5;
/// Most that the board takes as an amplitude, rad.
const MOST_AMPLITUDE_RAD: f64 = 0.03;

const AFTER_HELP: &str = "\
The folder holds afterwards:
  test-1.param    the board's parameters of the first test: pitchid fly --parameters test-1.param
  page.html       to take to the bench                plan.json    all of it, for programs

Examples:
  pitchid plan --mass 5 --arm 0.415 --out bench
  pitchid plan --model fitted.toml --limit 0.3 --accuracy 3 --out bench
  pitchid plan --model extended.toml --diagnosis answer.json --out bench
  pitchid plan --model fitted.toml --rivals servo_lag:T=0.05 gyro_lag

Exit status: 0 there is a plan; 2 no excitation keeps the limits, or the arguments could not be used.";

/// Plans.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let vehicle = arguments.vehicle()?;
    if let Some(vehicle) = &vehicle {
        vehicle.say();
    }
    let vehicle = vehicle.as_ref();
    let inputs = arguments.inputs(vehicle);
    output::check(arguments.json.as_deref(), &inputs)?;
    if let Some(folder) = &arguments.out {
        output::folder(folder)?;
    }
    let progress = Progress::start("reading");
    let planned = Planned::new(arguments, vehicle, &|what| progress.say(what))?;
    drop(progress);
    output::print(&words::text(&planned.plan, &planned.wishes))?;
    output::print(&write(arguments, &planned, &inputs)?)
}

/// A plan, and what it was made for.
pub struct Planned {
    /// The plan.
    pub plan: Plan,
    /// Within what.
    pub wishes: Wishes,
    /// Of what.
    pub craft: Craft,
}

impl Planned {
    /// Plans.
    pub fn new(
        arguments: &Arguments,
        vehicle: Option<&Vehicle>,
        progress: &sysid::progress::Progress<'_>,
    ) -> Result<Self, Failure> {
        let limits = vehicle.map(|vehicle| vehicle.limits).unwrap_or_default();
        let wishes = wishes(arguments, limits)?;
        let craft = craft(arguments, arguments.model(vehicle))?;
        let (craft, rivals) = rivals::asked(arguments, craft, &wishes)?;
        let plan = plan(&craft, &wishes, rivals.as_ref(), progress)?;
        Ok(Self { plan, wishes, craft })
    }
}

impl Arguments {
    /// The model that is meant.
    fn model<'a>(&'a self, vehicle: Option<&'a Vehicle>) -> Option<&'a PathBuf> {
        let own = vehicle.and_then(|vehicle| vehicle.model.as_ref());
        self.model.as_ref().or(own.filter(|_| self.mass.is_none()))
    }

    /// All files that are read.
    pub fn inputs<'a>(&'a self, vehicle: Option<&'a Vehicle>) -> Vec<&'a Path> {
        self.model(vehicle).into_iter().chain(&self.diagnosis).map(PathBuf::as_path).collect()
    }

    /// The vehicle's file, where it is wanted.
    pub fn vehicle(&self) -> Result<Option<Vehicle>, Failure> {
        self.wanted.find()
    }
}

fn craft(arguments: &Arguments, model: Option<&PathBuf>) -> Result<Craft, Failure> {
    let axis: Option<Axis> = arguments.axis.map(crate::axes::AxisChoice::single).transpose()?;
    Ok(match (model, arguments.mass, arguments.arm) {
        (Some(path), ..) => Craft::of_model(model_at(path, axis)?, &path.display().to_string())?,
        (None, Some(mass), Some(arm)) => Craft::of_size_and_mass(mass, arm)?,
        _ => {
            let help = "give --model MODEL.toml, or --mass KG and --arm M, or name a model in pitchid.toml";
            return Err(Failure::new("nothing is known of the craft", help));
        }
    })
}

fn wishes(arguments: &Arguments, limits: Limits) -> Result<Wishes, Failure> {
    let limit_rad = arguments.limit.or(limits.attitude_rad).unwrap_or(LIMIT_RAD);
    let most_amplitude_rad = arguments.amplitude.or(limits.input).unwrap_or(MOST_AMPLITUDE_RAD);
    let legal = [
        ("--limit", limit_rad, [0.02, 0.75], "rad"),
        ("--amplitude", most_amplitude_rad, [0.0002, MOST_AMPLITUDE_RAD], "rad"),
        ("--supervised", arguments.supervised, [0.0, 90.0], "%"),
        ("--time", arguments.time, [80.0, 3600.0], "s"),
        ("--accuracy", arguments.accuracy, [0.01, 100.0], "%"),
    ];
    for (name, value, [low, high], unit) in legal {
        if !(low..=high).contains(&value) {
            return Err(Failure::new(format!("{name} {value}"), format!("choose {low} to {high} {unit}")));
        }
    }
    Ok(Wishes {
        limit_rad,
        most_amplitude_rad,
        most_overridden: arguments.supervised / 100.0,
        longest_s: arguments.time,
        accuracy_percent: arguments.accuracy,
        weather: Weather { background: arguments.background.into(), air: arguments.air },
        flights: arguments.flights,
        seed: arguments.seed,
    })
}

/// Writes what was asked for and says so.
fn write(
    arguments: &Arguments,
    Planned { plan, wishes, craft }: &Planned,
    inputs: &[&Path],
) -> Result<String, Failure> {
    let mut said = String::new();
    let json = output::json(plan)?;
    if let Some(folder) = &arguments.out {
        said.push('\n');
        for (k, test) in plan.tests.iter().enumerate() {
            let path = folder.join(format!("test-{}.param", k + 1));
            output::write(&path, &words::parameters(&test.test))?;
            said.push_str(&format!("parameters of test {}: {}\n", k + 1, path.display()));
        }
        let path = folder.join("page.html");
        output::write(&path, &page::page(plan, wishes, craft, &Repeat::of_this_run(inputs))?)?;
        said.push_str(&format!("page for the bench: {}\n", path.display()));
        output::write(&folder.join("plan.json"), &json)?;
    }
    if let Some(path) = &arguments.json {
        output::write(path, &json)?;
    }
    Ok(said)
}
