//! The plan: which tests, how long, in which order, and what they will show.

use crate::Error;
use crate::craft::Craft;
use crate::forecast::{Accuracy, Excursion, accuracy};
use crate::rivals::{Chance, Rivals};
use crate::search::{SECTION_S, candidates, settled};
use crate::test::Test;
use crate::wishes::Wishes;
use serde::Serialize;
use sysid::progress::{Counted, Progress};

/// Shortest section, s: three times the memory of the on-board filter.
const SHORTEST_S: f32 = 10.0;
/// Sections are rounded up to this, s.
const ROUND_S: f32 = 5.0;
/// Most tests with one excitation.
const MOST_REPEATS: usize = 3;
/// Two excitations are flown where they take this share of the time that one takes, or less.
const WORTH_TWO: f64 = 0.85;
/// 2 ln(odds) that the contest of rivals is to reach on the average: nine in ten are then decided.
const DECISIVE: f64 = 16.0;

/// A test with what it will show.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedTest {
    /// The test.
    #[serde(flatten)]
    pub test: Test,
    /// Length without recoveries, s.
    pub length_s: f64,
    /// What its flights showed.
    pub excursion: Excursion,
}

/// An excitation, or two, that came into question.
#[derive(Clone, Debug, Serialize)]
pub struct Considered {
    /// The excitations.
    pub excitations: Vec<Test>,
    /// Excitation that is needed in all, s.
    pub needed_s: f64,
    /// The tests that this makes, within what a battery bears.
    #[serde(skip)]
    tests: Vec<Test>,
    /// Time that they take in all, s.
    pub total_s: f64,
}

/// A plan.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// Always `pitchid.plan/1`.
    pub schema: &'static str,
    /// The tests, the gentlest first.
    pub tests: Vec<PlannedTest>,
    /// What all of them together tell of each parameter.
    pub accuracy: Vec<Accuracy>,
    /// Simulated experiments from which that was estimated.
    pub estimated_from: usize,
    /// Whether they tell the rivals apart.
    pub chance: Option<Chance>,
    /// What came into question: the excitations one by one, then the best of them with each other one.
    pub considered: Vec<Considered>,
    /// What was asked for and could not be reached, in words.
    pub notes: Vec<String>,
}

/// Plans an experiment on `craft`.
///
/// `rivals` are asked for with a usual test of the craft, as they have to be told apart by the one that is planned.
///
/// # Errors
/// Limits that no excitation keeps, a craft that cannot be.
pub fn plan(
    craft: &Craft,
    wishes: &Wishes,
    rivals: Option<&Rivals>,
    say: &Progress<'_>,
) -> Result<Plan, Error> {
    let candidates = candidates(craft, wishes, say)?;
    let needed = |tests: &[Test]| match rivals {
        Some(rivals) => time_to_tell(tests, craft, wishes, rivals),
        None => time_to_know(tests, craft, wishes),
    };
    let mut considered = Vec::new();
    let counted = Counted::new(say, "what each tells", 2 * candidates.len() - 1);
    for test in &candidates {
        considered.push(Considered::new(vec![*test], needed(&[*test])?, wishes));
        counted.one();
    }
    let best = quickest(&considered).excitations[0];
    for other in candidates.iter().filter(|other| **other != best) {
        let both = [best, *other];
        considered.push(Considered::new(both.to_vec(), needed(&both)?, wishes));
        counted.one();
    }
    let chosen = quickest(&considered);
    let mut notes = chosen.falls_short(wishes);
    let tests = chosen.tests.clone();
    let mut planned = Vec::new();
    let counted = Counted::new(say, "flying each test many times", tests.len());
    for test in &tests {
        let (test, excursion) = settled(*test, craft, wishes)?;
        planned.push(PlannedTest { length_s: test.length_s(), test, excursion });
        counted.one();
    }
    planned.sort_by(|a, b| a.excursion.angle_rad.median.total_cmp(&b.excursion.angle_rad.median));
    let tests: Vec<Test> = planned.iter().map(|planned| planned.test).collect();
    if tests.iter().any(|test| test.closed_loop_s == 0.0) {
        notes.push(format!(
            "Section IV is left out: following the stick can take the craft beyond {} rad.",
            wishes.limit_rad
        ));
    }
    let seeds = wishes.estimated_seeds();
    let counted = Counted::new(say, "estimating from simulated experiments", seeds.len());
    let accuracy = accuracy(&tests, craft, wishes.weather, &seeds, &|| counted.one())?;
    let chance = rivals
        .map(|rivals| {
            say("letting the rivals contest".into());
            rivals.chance(&tests, craft, wishes.weather, &wishes.contested_seeds())
        })
        .transpose()?;
    Ok(Plan {
        schema: "pitchid.plan/1",
        tests: planned,
        accuracy,
        estimated_from: seeds.len(),
        chance,
        considered,
        notes,
    })
}

/// Sections of `tests`, in s for each, after which the parameters are as well known as wanted: the square of a half-width falls with
/// the time.
fn time_to_know(tests: &[Test], craft: &Craft, wishes: &Wishes) -> Result<f64, Error> {
    let told = accuracy(tests, craft, wishes.weather, &wishes.compared_seeds(), &|| ())?;
    let ratio = |one: &Accuracy| Some(one.half_width.most / wishes.wanted(&one.name)?);
    let worst = told.iter().filter_map(ratio).fold(0.0, f64::max);
    Ok(f64::from(SECTION_S) * worst * worst * tests.len() as f64)
}

/// The same after which the rivals are told apart: 2 ln(odds) grows with the time.
fn time_to_tell(tests: &[Test], craft: &Craft, wishes: &Wishes, rivals: &Rivals) -> Result<f64, Error> {
    let chance = rivals.chance(tests, craft, wishes.weather, &wishes.compared_seeds())?;
    Ok(f64::from(SECTION_S) * DECISIVE / chance.evidence.max(f64::MIN_POSITIVE) * tests.len() as f64)
}

/// What takes the least time in the air, and of equals what needs the least of it.
fn quickest(considered: &[Considered]) -> &Considered {
    let time = |one: &Considered| one.total_s * if one.excitations.len() > 1 { 1.0 / WORTH_TWO } else { 1.0 };
    let order = |a: &&Considered, b: &&Considered| {
        time(a).total_cmp(&time(b)).then(a.needed_s.total_cmp(&b.needed_s))
    };
    let least = considered.iter().min_by(order);
    least.expect("excitations that come into question are never none")
}

impl Considered {
    /// `excitations` with sections of `needed_s` in all, each flown as often as a battery asks.
    fn new(excitations: Vec<Test>, needed_s: f64, wishes: &Wishes) -> Self {
        let longest = wishes.longest_section_s();
        let each = (needed_s / excitations.len() as f64).min(1e6) as f32;
        let repeats = ((each / longest).ceil() as usize).clamp(1, MOST_REPEATS);
        let section = (each / repeats as f32 / ROUND_S).ceil() * ROUND_S;
        let section_s = section.clamp(SHORTEST_S, longest);
        let one = |test: &Test| vec![Test { section_s, ..*test }; repeats];
        let tests: Vec<Test> = excitations.iter().flat_map(one).collect();
        let total_s = tests.iter().map(Test::length_s).sum();
        Self { excitations, needed_s: 3.0 * needed_s, tests, total_s }
    }

    fn falls_short(&self, wishes: &Wishes) -> Vec<String> {
        let flown: f32 = self.tests.iter().map(|test| 3.0 * test.section_s).sum();
        if self.needed_s <= f64::from(flown) {
            return Vec::new();
        }
        vec![format!(
            "What was asked for needs {:.0} s of excitation, more than {} of {:.0} s at most {}: the forecast is of {flown:.0} s.",
            self.needed_s,
            if self.tests.len() == 1 { "one test".to_owned() } else { format!("{} tests", self.tests.len()) },
            wishes.longest_s,
            if self.tests.len() == 1 { "holds" } else { "hold" },
        )]
    }
}
