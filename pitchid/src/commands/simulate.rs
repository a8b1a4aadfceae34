//! `pitchid simulate`: flies a test on the simulated test-bed.

use super::effect_spec::EffectSpec;
use crate::failure::Failure;
use crate::output;
use clap::{Args, ValueEnum};
use estimator_core::Phase;
use experiment::vehicle::{plant, settings};
use host_sim::effects::{Entry, Parameter, named};
use host_sim::{Air, Background, Flight, OUTSIDE, Scenario, UNTOUCHED, fly};
use serde::Serialize;
use std::path::{Path, PathBuf};
use sysid::catalogue::model_file::read_model;

/// Flies a whole test (PRBS sections I to III, closed loop IV) on a simulated vehicle and writes the recording
///
/// Prints what was flown and how the test ended. Without --model the vehicle is the nominal one. The recording holds what a
/// rig would have logged; what was really there goes to --truth. The same arguments give the same bytes.
#[derive(Args)]
#[command(after_help = after_help())]
pub struct Arguments {
    /// Dwell of the PRBS: 1 = 0.05..0.1 s, 2 = 0.1..0.2 s, 3 = 0.2..0.4 s, 4 = 0.4..0.8 s
    #[arg(long, value_name = "1..4", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=4))]
    campaign: u8,

    /// Amplitude of the PRBS, rad
    #[arg(long, value_name = "RAD", default_value_t = 0.015)]
    amplitude: f32,

    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Physics to conceal; without parameters at a usual size
    #[arg(long = "effect", value_name = "ID[:PARAM=VALUE,...]")]
    effects: Vec<EffectSpec>,

    /// How much of the motion nothing causes: the true model reaches a VAF of 98, 90 or 75 %
    #[arg(long, value_enum, default_value_t = Level::Lab)]
    background: Level,

    /// Kind of that motion: band_passed, three_poles, heavy_tailed or grows_with_command
    #[arg(long, value_name = "AIR", default_value_t = Air::default())]
    air: Air,

    /// Fly the plant and the effects of this model file
    #[arg(long, value_name = "FILE.toml")]
    model: Option<PathBuf>,

    /// Where the recording goes; - is standard output
    #[arg(long, value_name = "RECORDING.csv")]
    out: PathBuf,

    /// Where the truth goes
    #[arg(long, value_name = "TRUTH.json")]
    truth: Option<PathBuf>,

    /// Write what is printed as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

/// Size of the background moment.
#[derive(Clone, Copy, ValueEnum)]
pub enum Level {
    /// 98 % of the motion follows from the model
    Clean,
    /// 90 %
    Lab,
    /// 75 %, as on the paper's vehicle
    Paper,
}

impl From<Level> for Background {
    fn from(level: Level) -> Self {
        match level {
            Level::Clean => Self::Clean,
            Level::Lab => Self::Lab,
            Level::Paper => Self::Paper,
        }
    }
}

fn after_help() -> String {
    let outside = OUTSIDE.iter().chain(UNTOUCHED);
    format!(
        "Effects and their parameters, with the usual range of magnitudes (± where negative values are usual too):\n{}\
         imu_mount replaces the vehicle's own mount: diagnose it against a model without one. rest_angle shows only beside a spring.\n\n\
         Outside the catalogue, to try what a diagnosis says of physics that it has no name for:\n{}\n\
         Examples:\n  \
         pitchid simulate --out nominal.csv\n  \
         pitchid simulate --effect coulomb_friction:Mc=0.1 --seed 7 --out friction.csv --truth friction.json\n  \
         pitchid simulate --effect gyro_lag --effect end_stop:ks=3,theta_s=0.2 --out two.csv\n  \
         pitchid simulate --model extended.toml --background paper --out again.csv\n\n\
         Exit status: 0 the test was flown, however it ended; 2 the arguments could not be used.",
        grouped(),
        outside.map(line).collect::<String>()
    )
}

/// The catalogue, by place in the loop.
fn grouped() -> String {
    let places = ["actuator", "pitch_moment", "timing", "sensor", "environment"];
    let group = |place: &str| -> String {
        let lines = named().filter(|entry| entry.locus == place).map(line);
        format!(" {}\n{}", place.replace('_', " "), lines.collect::<String>())
    };
    places.map(group).concat()
}

fn line(entry: &Entry) -> String {
    let parameters: Vec<String> = entry.parameters.iter().map(parameter).collect();
    format!("  {:<26} {}\n", entry.id, parameters.join(", "))
}

fn parameter(p: &Parameter) -> String {
    let sign = if p.signed { "±" } else { "" };
    let unit = if ["-", "1"].contains(&p.unit) { String::new() } else { format!(" {}", p.unit) };
    format!("{} {sign}{}..{}{unit}", p.name, p.range[0], p.range[1])
}

/// Simulates.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let outputs = [Some(&arguments.out), arguments.truth.as_ref(), arguments.json.as_ref()];
    let inputs: Vec<&Path> = arguments.model.iter().map(PathBuf::as_path).collect();
    output::check(outputs.into_iter().flatten().map(PathBuf::as_path), &inputs)?;
    let (flight, flown) = flown(arguments)?;
    output::write(&arguments.out, &flight.recording())?;
    if let Some(path) = &arguments.truth {
        output::write(path, &output::json(&flight.truth)?)?;
    }
    if let Some(path) = &arguments.json {
        output::write(path, &output::json(&flown)?)?;
    }
    output::print(&flown.told())
}

/// Flies, and says what was flown.
pub fn flown(arguments: &Arguments) -> Result<(Flight, Flown), Failure> {
    let flight = fly(&scenario(arguments)?)?;
    let flown = Flown::new(arguments, &flight);
    Ok((flight, flown))
}

fn scenario(arguments: &Arguments) -> Result<Scenario, Failure> {
    let mut scenario = Scenario::campaign(arguments.campaign.into(), arguments.amplitude, arguments.seed)?;
    scenario.background = arguments.background.into();
    scenario.air = arguments.air;
    let mut concealed = Vec::new();
    if let Some(path) = &arguments.model {
        let model = read_model(path, None)?;
        scenario.plant = plant(&model, &path.display().to_string())?;
        concealed = settings(&model)?;
    }
    for spec in &arguments.effects {
        concealed.push(spec.setting()?);
    }
    scenario.conceal(concealed);
    Ok(scenario)
}

/// What was flown.
#[derive(Serialize)]
pub struct Flown {
    schema: &'static str,
    recording: String,
    campaign: u8,
    amplitude_rad: f64,
    seed: u64,
    seconds: f64,
    samples: usize,
    overridden_percent: f64,
    outcome: String,
}

impl Flown {
    fn new(arguments: &Arguments, flight: &Flight) -> Self {
        let overridden = flight.rows.iter().filter(|row| row.supervised).count();
        Self {
            schema: "pitchid.simulation/1",
            recording: arguments.out.display().to_string(),
            campaign: arguments.campaign,
            // as it was written, not as the nearest f32
            amplitude_rad: arguments.amplitude.to_string().parse().unwrap_or(arguments.amplitude.into()),
            seed: arguments.seed,
            seconds: flight.rows.last().map_or(0.0, |row| row.t_s),
            samples: flight.rows.len(),
            overridden_percent: 100.0 * overridden as f64 / flight.rows.len().max(1) as f64,
            outcome: match flight.outcome {
                Phase::Aborted { cause } => format!("broken off by the supervisor: {cause}"),
                _ => "finished".into(),
            },
        }
    }

    /// In words.
    pub fn told(&self) -> String {
        let Self {
            recording,
            campaign,
            amplitude_rad,
            seed,
            seconds,
            samples,
            overridden_percent,
            outcome,
            ..
        } = self;
        format!(
            "{recording}: campaign {campaign}, amplitude {amplitude_rad} rad, seed {seed}; {seconds:.1} s, {samples} samples, \
             {overridden_percent:.1} % overridden by the supervisor; {outcome}\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::sensors::Noise;
    use sysid::catalogue::scaled_shape;
    use sysid::dataset::Amplitudes;
    use sysid::held_out::Split;
    use sysid::likelihood::free_run::vaf_by_place;
    use sysid::likelihood::problem::Problem;
    use sysid::model::baseline::Baseline;
    use sysid::model::effect::Effect;
    use sysid::model::file::{EffectEntry, ModelFile};

    const ANY: Amplitudes = Amplitudes {
        inertia: 1.0,
        u: 1.0,
        q: 1.0,
        theta: 1.0,
        turned: 8.0,
        angles: [0.0; 3],
        moment: 1.0,
        moves: 0.0,
        step: 0.02,
        duration: 1.0,
        rate_limit: None,
    };

    /// Free-run VAF of `model` over what `scenario` recorded, the model's values as they are.
    fn simulated(model: &ModelFile, scenario: &Scenario) -> f64 {
        let text = fly(scenario).unwrap().recording();
        let options = sysid::recording::ReadOptions::default();
        let recording = sysid::recording::parse("flown.csv", text.as_bytes(), &options).unwrap();
        let data = sysid::dataset::Dataset::new(&[recording]).unwrap();
        let baseline = Baseline::from_model(model, &data).unwrap();
        let split = Split::new(&data);
        let problem = Problem::new(&data, &baseline, &split.held_out);
        let values = [problem.plant_start(), problem.noise_start(0.03)].concat();
        let vaf = vaf_by_place(&problem, &problem.unpack(&[], &values), &split.training);
        vaf.iter().sum::<f64>() / vaf.len() as f64
    }

    #[test]
    fn a_term_without_a_name_flies_as_the_model_says() {
        let nominal =
            "[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\ndM_du_N_m = 23.0\n";
        let scales =
            [("scale_q_rad_s", 0.4), ("scale_theta_rad", 0.15), ("scale_u", 0.01), ("duration_s", 100.0)];
        for scaled in scaled_shape::all() {
            let shape = scaled.name_in_file();
            let mut model = sysid::model::file::parse("m.toml", nominal, None, &[]).unwrap();
            let bare = model.clone();
            let size = |name: &str| scales.iter().find(|(scale, _)| *scale == name).map_or(-0.02, |s| s.1);
            let parameters =
                scaled.parameters(&ANY).iter().map(|p| (p.name.to_owned(), size(p.name))).collect();
            let (id, shape_of) = (scaled_shape::UNLISTED.to_owned(), Some(shape.to_owned()));
            model.effects.push(EffectEntry { id, shape: shape_of, parameters, remark: None });
            let mut scenario = Scenario::campaign(4, 0.015, 3).unwrap();
            scenario.background = Background::None;
            scenario.noise = Noise { q_rad_s: 0.0, theta_rad: 0.0, qdot_rad_s2: 0.0 };
            scenario.plant = plant(&model, "m.toml").unwrap();
            scenario.conceal(settings(&model).unwrap());
            let (with, without) = (simulated(&model, &scenario), simulated(&bare, &scenario));
            println!("{shape}: {with:.3} with the term, {without:.3} without");
            assert!(100.0 - with < 0.01 * (100.0 - without), "{shape}: {with} {without}");
        }
    }
}
