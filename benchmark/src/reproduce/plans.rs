//! Planned against flown: whether a test goes as its plan foretold.
//!
//! Each simulated craft is flown by the plan that its size and mass give, with nothing else known. What was recorded is identified; the
//! model, with its intervals, gives a second plan, which is flown too. A plan holds where what was flown lies within its bands: the
//! largest angle, the share that the supervisor took, and the half-width of every interval that the recording gives. Beside it
//! stands how often those intervals hold the truth, which no plan can promise.

use crate::{Error, files};
use experiment::forecast::{Accuracy, half_width, recordings};
use experiment::test::Flown;
use experiment::{Craft, Plan, PlannedTest, Weather, Wishes, plan};
use host_sim::Plant;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use sysid::estimate::Estimate;
use sysid::model::file::{Interval, ModelFile};
use sysid::progress::{Counted as Parts, Progress};

/// Mass and arm of the craft, kg and m: the paper's.
const MASS_KG: f64 = 5.0;
const ARM_M: f64 = 0.415;
/// Seeds of the plans and of the crafts do not meet.
const CRAFTS: u64 = 1 << 32;
/// Accuracy that is asked of the first and of the second plan, %.
const WANTED_PERCENT: [f64; 2] = [8.0, 4.0];

/// What became of a plan.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Flight {
    /// Whether the largest angle of every test lay in its band.
    pub angle: bool,
    /// Whether the angle that must not be passed was kept.
    pub limit: bool,
    /// Whether the share that the supervisor took lay in its band.
    pub supervised: bool,
    /// Whether every half-width lay in its band.
    pub accuracy: bool,
    /// Intervals that hold the truth, and how many there were.
    pub covered: [usize; 2],
}

/// Of one kind of plan.
#[derive(Clone, Debug, Serialize)]
pub struct Counted {
    /// What the plans were made from.
    pub from: &'static str,
    /// Crafts that no plan could be made for within the limits.
    pub refused: usize,
    /// Plans.
    pub plans: usize,
    /// Plans of which each held.
    pub angle: usize,
    /// See [`Flight`].
    pub limit: usize,
    /// See [`Flight`].
    pub supervised: usize,
    /// See [`Flight`].
    pub accuracy: usize,
    /// Plans of which angle, share and accuracy held.
    pub all: usize,
    /// Intervals that hold the truth, and how many there were.
    pub covered: [usize; 2],
}

/// Plans for `crafts` crafts, and what was flown; writes `plans.json` and `plans.md` into `folder`, which is there.
///
/// # Errors
/// A plan that could not be made, or a file that could not be written.
pub fn plans(folder: &Path, crafts: u64, seed: u64, say: &Progress<'_>) -> Result<[Counted; 2], Error> {
    let unknown = Craft::of_size_and_mass(MASS_KG, ARM_M)?;
    say("planning from size and mass".into());
    let first = plan(&unknown, &wishes(seed, 0), None, &|_| ())?;
    let parts = Parts::new(say, "planning and flying", crafts as usize);
    let one = |k: u64| -> Result<[Option<Flight>; 2], Error> {
        let craft = CRAFTS + seed * 100_003 + k;
        let truth = unknown.drawn(craft);
        // the inertia is measured before the first flight: on a bifilar pendulum, or from the drawing
        let model = with_inertia(&unknown.model, truth.inertia_kg_m2);
        let real = Real { truth, model, seed: craft };
        let (flown, estimates) = real.fly(&first)?;
        let known = Craft::of_model(identified(&real.model, &estimates), "identified")?;
        // a craft that the board's controller does not hold within the limit is refused, which is an answer
        let again = match plan(&known, &wishes(seed, 1 + k), None, &|_| ()) {
            Ok(second) => {
                let real = Real { seed: craft + CRAFTS, model: known.model, ..real };
                Some(real.fly(&second)?.0)
            }
            Err(experiment::Error::Craft { .. }) => None,
            Err(error) => return Err(error.into()),
        };
        parts.one();
        Ok([Some(flown), again])
    };
    let flights: Vec<[Option<Flight>; 2]> =
        (0..crafts).into_par_iter().map(one).collect::<Result<_, Error>>()?;
    let counted = [(0, "size and mass"), (1, "the model identified in the first test")]
        .map(|(which, from)| count(from, flights.iter().map(|both| both[which])));
    files::write(&folder.join("plans.json"), &files::json(&counted)?)?;
    files::write(&folder.join("plans.md"), &markdown(&counted, seed))?;
    Ok(counted)
}

fn wishes(seed: u64, number: u64) -> Wishes {
    Wishes {
        limit_rad: 0.5,
        most_amplitude_rad: 0.03,
        most_overridden: 0.15,
        longest_s: 240.0,
        accuracy_percent: WANTED_PERCENT[usize::from(number > 0)],
        weather: Weather::default(),
        flights: 200,
        seed: seed * 10_007 + number,
    }
}

fn with_inertia(model: &ModelFile, inertia_kg_m2: f64) -> ModelFile {
    let mut model = model.clone();
    model.plant.inertia_kg_m2 = inertia_kg_m2;
    model
}

/// The model with what was estimated, and its intervals.
fn identified(model: &ModelFile, estimates: &[Estimate]) -> ModelFile {
    let mut model = model.clone();
    let keys = [("dM_dq", "dM_dq_N_m_s"), ("dM_du", "dM_du_N_m"), ("delay", "delay_s")];
    let places = [&mut model.plant.dm_dq, &mut model.plant.dm_du, &mut model.plant.delay_s];
    let mut intervals = BTreeMap::new();
    for ((name, key), place) in keys.into_iter().zip(places) {
        if let Some(estimate) = estimates.iter().find(|estimate| estimate.name == name) {
            *place = Some(estimate.value);
            intervals.insert(key.to_owned(), Interval { ci95: estimate.ci95 });
        }
    }
    model.intervals = intervals;
    model
}

/// A craft as it is, and the model by which what it does is estimated.
struct Real {
    truth: Plant,
    model: ModelFile,
    seed: u64,
}

impl Real {
    /// Flies a plan and identifies from what was recorded.
    fn fly(&self, plan: &Plan) -> Result<(Flight, Vec<Estimate>), Error> {
        let mut exact = self.model.clone();
        (exact.plant.dm_dq, exact.plant.dm_du, exact.plant.delay_s) =
            (Some(self.truth.dm_dq), Some(self.truth.dm_du), Some(self.truth.delay_s));
        exact.intervals.clear();
        let craft = Craft::of_model(exact, "the craft")?;
        let mut flight =
            Flight { angle: true, limit: true, supervised: true, accuracy: true, covered: [0, 0] };
        for PlannedTest { test, excursion, .. } in &plan.tests {
            let flown = Flown::of(&test.fly(&craft, &[], Weather::default(), self.seed)?);
            flight.angle &= !flown.broken_off && excursion.angle_rad.holds(flown.angle_rad);
            flight.limit &= flown.angle_rad <= 0.5;
            flight.supervised &= excursion.overridden_percent.holds(100.0 * flown.overridden);
        }
        // the search starts from the model that the plan was made with
        let start = Craft::of_model(self.model.clone(), "the model")?;
        let tests: Vec<_> = plan.tests.iter().map(|planned| planned.test).collect();
        let recorded = recordings(&tests, &craft, &[], Weather::default(), self.seed)?;
        let estimates = sysid::likelihood::precision::precision(&recorded, &start.model)?;
        for estimate in &estimates {
            let told = plan.accuracy.iter().find(|accuracy: &&Accuracy| accuracy.name == estimate.name);
            flight.accuracy &= told.is_some_and(|told| told.half_width.holds(half_width(estimate)));
            let truth = match estimate.name.as_str() {
                "dM_dq" => self.truth.dm_dq,
                "dM_du" => self.truth.dm_du,
                _ => self.truth.delay_s,
            };
            flight.covered[1] += 1;
            flight.covered[0] += usize::from((estimate.ci95[0]..=estimate.ci95[1]).contains(&truth));
        }
        Ok((flight, estimates))
    }
}

fn count(from: &'static str, flights: impl Iterator<Item = Option<Flight>>) -> Counted {
    let all: Vec<Option<Flight>> = flights.collect();
    let flights: Vec<Flight> = all.iter().flatten().copied().collect();
    let of = |held: &dyn Fn(&Flight) -> bool| flights.iter().filter(|flight| held(flight)).count();
    Counted {
        from,
        refused: all.len() - flights.len(),
        plans: flights.len(),
        angle: of(&|flight| flight.angle),
        limit: of(&|flight| flight.limit),
        supervised: of(&|flight| flight.supervised),
        accuracy: of(&|flight| flight.accuracy),
        all: of(&|flight| flight.angle && flight.supervised && flight.accuracy),
        covered: [0, 1].map(|i| flights.iter().map(|flight| flight.covered[i]).sum()),
    }
}

/// Head of the table.
pub const HEADER: [&str; 9] = [
    "planned from",
    "refused",
    "plans",
    "largest angle in its band",
    "limit kept",
    "supervised share in its band",
    "every accuracy in its band",
    "all three",
    "intervals that hold the truth",
];

/// Rows of the table.
#[must_use]
pub fn rows(counted: &[Counted]) -> Vec<Vec<String>> {
    let row = |one: &Counted| {
        let counts = [one.refused, one.plans, one.angle, one.limit, one.supervised, one.accuracy, one.all];
        let mut cells = vec![one.from.to_owned()];
        cells.extend(counts.map(|count| count.to_string()));
        cells.push(format!("{} of {}", one.covered[0], one.covered[1]));
        cells
    };
    counted.iter().map(row).collect()
}

fn markdown(counted: &[Counted], seed: u64) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let header = HEADER.map(str::to_owned);
    let body: String = rows(counted).iter().map(|cells| line(cells)).collect();
    format!(
        "# Planned against flown, seed {seed}\n\n{}|{}\n{body}",
        line(&header),
        " --- |".repeat(HEADER.len())
    )
}
