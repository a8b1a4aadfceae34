//! Public benchmarks in their official split: the diagnosis names what is missing on the training data, the model with it is
//! fitted for simulation, and runs freely over the test data, which nothing else sees.
//!
//! 1. The diagnosis of (the first rows of) the training data gives a plant and named terms; where the rig is an oscillator, it
//!    is asked what a linear one, fitted to the training data by output error, leaves out.
//! 2. Plant and terms that are the answer, not its remainder nor those without a name, and a constant moment, are fitted to all
//!    training data: by the diagnosis as it is, by one-step prediction, and by output error from either. That with the least
//!    free-run error over the training data is taken.
//! 3. Free run over the test data from the state that the first rows of it give; RMSE over the rows after them.

pub mod page;
mod piece;
mod simulation;

use crate::{Error, files};
use piece::Piece;
use serde::Serialize;
use simulation::{CONSTANT, Simulation};
use std::path::Path;
use sysid::catalogue::model_file::model_file;
use sysid::dataset::Dataset;
use sysid::diagnosis::diagnose;
use sysid::files::{LARGEST_RECORDING, read};
use sysid::likelihood::fit::fit_baseline;
use sysid::likelihood::problem::{Problem, Unpacked};
use sysid::model::baseline::Baseline;
use sysid::model::file::{EffectEntry, ModelFile, PlantSection};
use sysid::progress::Progress;
use sysid::recording::{InputHold, ReadOptions, Recording, parse};

/// A benchmark: its files and its protocol.
pub struct Benchmark {
    /// Name.
    pub name: &'static str,
    /// Where the data come from.
    pub source: &'static str,
    /// Unit of the error, and how many of it are one unit of the recording.
    pub unit: (&'static str, f64),
    train: &'static str,
    tests: &'static [Test],
    hold: InputHold,
    /// Natural frequency (rad/s) and damping (1/s) of the linear oscillator that a fit of the user's model starts from.
    oscillator: Option<[f64; 2]>,
    /// Rows of the training data that are diagnosed.
    diagnosed: usize,
    /// Parts into which a sample is cut for the simulation.
    finer: usize,
    /// Samples that give the state at the start of a test.
    initialisation: usize,
}

struct Test {
    name: &'static str,
    file: &'static str,
    /// Rows that count.
    rows: usize,
    goal: Option<f64>,
    rivals: &'static [(&'static str, f64)],
}

const EVERY: usize = usize::MAX;
/// The oscillator's spring.
const SPRING: &str = "linear_stiffness";

/// The benchmarks.
pub const BENCHMARKS: [Benchmark; 2] = [
    Benchmark {
        name: "EMPS",
        source: "Janot, Gautier, Brunot, Data set and reference models of EMPS, Workshop on Nonlinear System Identification \
                 Benchmarks, 2019",
        unit: ("mm", 1e3),
        train: "emps_train.csv",
        tests: &[Test {
            name: "test",
            file: "emps_test.csv",
            rows: EVERY,
            goal: Some(5.0),
            rivals: &[("LSTM", 74.1), ("RNN", 89.2), ("GRU", 220.0)],
        }],
        hold: InputHold::Held,
        oscillator: None,
        diagnosed: EVERY,
        finer: 1,
        initialisation: 20,
    },
    Benchmark {
        name: "Silverbox",
        source: "Wigren, Schoukens, Three free data sets for development and benchmarking in nonlinear system identification, \
                 ECC 2013",
        unit: ("mV", 1e3),
        train: "silverbox_multisine_train.csv",
        tests: &[
            Test {
                name: "multisine",
                file: "silverbox_multisine_test.csv",
                rows: EVERY,
                goal: None,
                rivals: &[("GRU", 1.49)],
            },
            Test {
                name: "arrow, no extrapolation",
                file: "silverbox_arrow.csv",
                rows: 32_000,
                goal: None,
                rivals: &[("GRU", 0.95)],
            },
            Test {
                name: "arrow, all of it",
                file: "silverbox_arrow.csv",
                rows: EVERY,
                goal: Some(0.6),
                rivals: &[("GRU", 2.80)],
            },
        ],
        hold: InputHold::Interpolated,
        oscillator: Some([425.0, 30.0]),
        diagnosed: 4_096,
        finer: 8,
        initialisation: 50,
    },
];

/// What came out of one benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Name of the benchmark.
    pub name: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// The verdict on the training data, as in the JSON of a diagnosis.
    pub verdict: String,
    /// Terms of the diagnosis: id, and in how many of how many rotations it was chosen.
    pub diagnosed: Vec<(String, [usize; 2])>,
    /// Rows of the training data that were diagnosed.
    pub diagnosed_rows: usize,
    /// Free-run error over the training data by each way of fitting.
    pub fits: Vec<(&'static str, f64)>,
    /// The model that was simulated: parameters by name.
    pub model: Vec<(String, f64)>,
    /// Error of its free run over the training data.
    pub train: f64,
    /// By test.
    pub tests: Vec<TestOutcome>,
}

/// One test.
#[derive(Clone, Debug, Serialize)]
pub struct TestOutcome {
    /// Name.
    pub name: &'static str,
    /// Rows that count, after the initialisation.
    pub rows: usize,
    /// Root mean square error.
    pub rmse: f64,
    /// The same with a step of the simulation a quarter as long.
    pub rmse_finer: f64,
    /// Of the plant alone, fitted in the same way.
    pub linear: f64,
    /// What is to be reached, if anything.
    pub goal: Option<f64>,
    /// Published errors of black boxes in the same protocol.
    pub rivals: Vec<(&'static str, f64)>,
}

/// Runs all benchmarks of the folder `data`, and writes page and figures into `folder`. `say` hears what is being done.
///
/// # Errors
/// A file of the split that is not there or cannot be used, a model that diverges, or a file that could not be written.
pub fn published(data: &Path, folder: &Path, say: &Progress<'_>) -> Result<Vec<Outcome>, Error> {
    let outcomes =
        BENCHMARKS.iter().map(|benchmark| benchmark.run(data, say)).collect::<Result<Vec<_>, _>>()?;
    files::make_folder(folder)?;
    files::write(&folder.join("benchmarks.json"), &files::json(&outcomes)?)?;
    files::write(&folder.join("benchmarks.md"), &page::markdown(&outcomes))?;
    Ok(outcomes)
}

impl Benchmark {
    fn run(&self, data: &Path, say: &Progress<'_>) -> Result<Outcome, Error> {
        let train = self.read(data, self.train, EVERY)?;
        let first = self.read(data, self.train, self.diagnosed)?;
        let rows = train.t.len();
        let all = Piece::new(&train, 0..rows, self.finer);
        say(format!("{}: diagnosing the training data", self.name).as_str().into());
        let model = self.oscillator.map(|of| self.oscillator(of, &train, &all)).transpose()?;
        let found = diagnose(std::slice::from_ref(&first), model.as_ref(), &|_| {})?;
        let verdict = serde_json::to_value(found.answer.verdict).ok();
        let answer = &found.answer;
        let given = model.iter().flat_map(|model| &model.effects).map(|effect| effect.id.as_str());
        let ids: Vec<&str> = given.chain(answer.effects.iter().map(|effect| effect.id.as_str())).collect();
        let mut named = found.model;
        named.effects.retain(|effect| effect.shape.is_none() && ids.contains(&effect.id.as_str()));
        say(format!("{}: fitting to all training data", self.name).as_str().into());
        let diagnosed = simulation(&named, &train)?;
        let predicted = self.predicting(&named, &train)?;
        let by_output_error = |start: &Simulation| start.fitted(&all, self.initialisation);
        let ways = [
            ("as diagnosed", Some(diagnosed.clone())),
            ("one-step prediction", Some(predicted.clone())),
            ("output error from the diagnosis", by_output_error(&diagnosed)),
            ("output error from the prediction", by_output_error(&predicted)),
        ];
        let mut tried: Vec<(&'static str, Simulation, f64)> = ways
            .into_iter()
            .filter_map(|(way, fitted)| {
                let fitted = fitted?;
                let error = fitted.error(&all, self.initialisation, all.len())?;
                Some((way, fitted, self.unit.1 * error))
            })
            .collect();
        tried.sort_by(|a, b| a.2.total_cmp(&b.2));
        let fits = tried.iter().map(|(way, _, error)| (*way, *error)).collect();
        let (_, fitted, training) = tried.into_iter().next().ok_or_else(|| self.diverged(self.train))?;
        let linear = self.linear(&fitted, &all)?;
        let error = |simulation: &Simulation, piece: &Piece, end: usize| {
            simulation.error(piece, self.initialisation, end).ok_or_else(|| self.diverged("a free run"))
        };
        let scale = self.unit.1;
        let tests = self.tests.iter().map(|test| {
            say(format!("{}: {}", self.name, test.name).as_str().into());
            let recording = self.read(data, test.file, test.rows)?;
            let rows = recording.t.len();
            let [piece, finer] = [1, 4].map(|times| Piece::new(&recording, 0..rows, times * self.finer));
            Ok(TestOutcome {
                name: test.name,
                rows: rows - self.initialisation,
                rmse: scale * error(&fitted, &piece, rows)?,
                rmse_finer: scale * error(&fitted, &finer, rows)?,
                linear: scale * error(&linear, &piece, rows)?,
                goal: test.goal,
                rivals: test.rivals.to_vec(),
            })
        });
        let tests = tests.collect::<Result<Vec<_>, Error>>()?;
        Ok(Outcome {
            name: self.name,
            unit: self.unit.0,
            verdict: verdict.and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default(),
            diagnosed: answer.fit.chosen_in.clone().into_iter().collect(),
            diagnosed_rows: first.t.len(),
            fits,
            model: parameters(&fitted),
            train: training,
            tests,
        })
    }

    /// The plant and terms of `model` by maximum likelihood of the one-step prediction over the training data.
    fn predicting(&self, model: &ModelFile, train: &Recording) -> Result<Simulation, Error> {
        let data = Dataset::new(std::slice::from_ref(train))?;
        let mut baseline = Baseline::from_model(model, &data)?;
        baseline.delay_free = true;
        let problem = Problem::new(&data, &baseline, &[]);
        let fit = fit_baseline(&problem).ok_or_else(|| self.diverged("the prediction"))?;
        let Unpacked { plant, terms, .. } = problem.unpack(&[], &fit.minimum.values);
        Ok(Simulation::new(plant, terms, data.amplitudes(plant.inertia, plant.dm_du)))
    }

    /// The linear oscillator nearest to `piece`, as the user's model.
    fn oscillator(
        &self,
        [frequency, damping]: [f64; 2],
        train: &Recording,
        piece: &Piece,
    ) -> Result<ModelFile, Error> {
        let stiffness = frequency * frequency;
        let spring = EffectEntry {
            id: SPRING.into(),
            shape: None,
            remark: None,
            parameters: [("k".to_owned(), stiffness)].into(),
        };
        let plant = PlantSection {
            inertia_kg_m2: 1.0,
            delay_s: Some(0.0),
            dm_dq: Some(-damping),
            dm_du: Some(stiffness),
            mount_k: None,
            mount_c: None,
            mount_j: None,
        };
        let start = ModelFile { plant, effects: vec![spring], intervals: Default::default() };
        let fitted = simulation(&start, train)?.fitted(piece, self.initialisation);
        let Simulation { plant, mut terms, .. } =
            fitted.ok_or_else(|| self.diverged("the linear oscillator"))?;
        terms.retain(|term| term.effect.about().id == SPRING);
        // The delay is estimated again.
        let mut model = model_file(&plant, &terms, train.t[0]);
        model.plant.delay_s = None;
        Ok(model)
    }

    /// The same plant with nothing beside it but the oscillator's spring.
    fn linear(&self, fitted: &Simulation, all: &Piece) -> Result<Simulation, Error> {
        let mut linear = fitted.clone();
        linear.terms.retain(|term| {
            let id = term.effect.about().id;
            id == CONSTANT || self.oscillator.is_some() && id == SPRING
        });
        linear.fitted(all, self.initialisation).ok_or_else(|| self.diverged("the plant alone"))
    }

    fn diverged(&self, what: &str) -> Error {
        Error::new(
            format!("{}: the simulation of {what} has no finite answer", self.name),
            "check that the files are those of the official split",
        )
    }

    /// At most `rows` rows of a file of the split.
    fn read(&self, data: &Path, file: &str, rows: usize) -> Result<Recording, Error> {
        let path = data.join(file);
        let unreadable = |why: &dyn std::fmt::Display| {
            Error::new(
                format!("{}: cannot be read: {why}", path.display()),
                "name the folder with the official split: t_s, u and theta_rad in each file",
            )
        };
        let bytes = read(&path, LARGEST_RECORDING).map_err(|error| unreadable(&error.found))?;
        let text = String::from_utf8(bytes).map_err(|error| unreadable(&error))?;
        let comments = text.lines().take_while(|line| line.starts_with('#')).count();
        let kept: Vec<&str> = text.lines().take(rows.saturating_add(comments + 1)).collect();
        let options = ReadOptions { input_hold: self.hold, ..ReadOptions::default() };
        let recording = parse(&path.display().to_string(), kept.join("\n").as_bytes(), &options)?;
        if recording.segments.len() > 1 || recording.theta.is_none() {
            let found = format!("{}: gaps, or no column theta_rad", path.display());
            return Err(Error::new(found, "take the file of the official split as it is"));
        }
        Ok(recording)
    }
}

/// The diagnosis' model, to be simulated at the full rate of `train`.
fn simulation(model: &ModelFile, train: &Recording) -> Result<Simulation, Error> {
    let data = Dataset::new(std::slice::from_ref(train))?;
    let Baseline { plant, terms, .. } = Baseline::from_model(model, &data)?;
    Ok(Simulation::new(plant, terms, data.amplitudes(plant.inertia, plant.dm_du)))
}

/// Parameters by name.
fn parameters(simulation: &Simulation) -> Vec<(String, f64)> {
    let plant = &simulation.plant;
    let mut all =
        vec![("dM_dq".to_owned(), plant.dm_dq), ("dM_du".into(), plant.dm_du), ("delay".into(), plant.delay)];
    for term in &simulation.terms {
        let id = term.effect.about().id;
        let names = term.effect.parameters(&simulation.sizes);
        all.extend(names.iter().zip(&term.values).map(|(p, value)| (format!("{id}.{}", p.name), *value)));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_official_split_reads() {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/benchmarks");
        if !data.is_dir() {
            assert!(std::env::var_os("CI").is_none(), "the benchmarks' data are not beside this checkout");
            println!("skipped: no benchmarks' data beside this checkout");
            return;
        }
        for benchmark in &BENCHMARKS {
            let tests = benchmark.tests.iter().map(|test| test.file);
            for file in std::iter::once(benchmark.train).chain(tests) {
                let recording = benchmark.read(&data, file, 1000).unwrap();
                assert_eq!(recording.t.len(), 1000, "{file}");
                assert_eq!(recording.input_hold, benchmark.hold);
                let piece = Piece::new(&recording, 0..1000, benchmark.finer);
                assert_eq!((piece.len(), piece.run.len()), (1000, 1000 * benchmark.finer));
            }
        }
    }

    #[test]
    fn a_missing_file_is_told_with_what_to_do() {
        let error = published(Path::new("nowhere"), Path::new("nowhere-out"), &|_| ()).unwrap_err();
        let Error::Place { message, help } = error else { panic!("{error}") };
        assert!(message.contains("emps_train.csv") && help.contains("official split"), "{message}");
    }
}
