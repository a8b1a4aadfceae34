//! Does the input answer to the motion in sections that claim to be open loop?
//!
//! Innovations e(k) of the fitted model are what could not be known before row k. An input that was decided beforehand
//! knows nothing of them; one that a controller, an operator or a limit has changed does:
//!
//! ```text
//! w(k) = u(k) − Σ_{i=1..p} a_i u(k−i) − a_0            what is new in the input (least squares)
//! z(l) = Σ_k e(k) w(k+l) / √(Σ_k e(k)² w(k+l)²),       l = 1..L;  Σ_l z(l)² ~ χ²_L without feedback
//! ```
//!
//! With u itself in place of w, anything of the input that the model leaves in e would come back by the input's own
//! correlation; and neither that nor a delay in the loop puts a *later* w into e. The switches of an excitation outweigh
//! by far what a controller adds to it, so the sums are taken twice, over all rows and (regression included) without those
//! of a large w, and once more over all rows up to a second ahead, more coarsely; the clearest counts, its odds multiplied, the
//! [dwells](super::dwells) of a switching input among them. A controller that is faster than the log answers in the row of the
//! motion, before which no input can have acted that is new there: l = 0 is a test of its own, but where the rows are averages,
//! in which the input acts. Outputs that were interpolated between uneven stamps hold what came up to a row later: there the inputs
//! from two rows on count. Where nothing is new between the switches, there is an excitation and nothing else; where
//! something is, averages rule nothing out. What is new in a few places alone, as a ramp at the start and a step, is not asked: a
//! model that lacks something errs alike all along a ramp. Dwells that follow the motion as far as the input made it, and no further, decide
//! nothing.
//!
//! Sources: Haugh, JASA 71, 1976; White's (1980) variance, for errors of uneven size.

use super::dwells::{Dwells, Told, dwells};
use super::{DataCheck, Gravity};
use crate::dataset::{Place, Run};
use crate::estimate::digits;
use crate::likelihood::fit::Fit;
use crate::likelihood::free_run::{simulate, starting_points};
use crate::likelihood::problem::{Problem, Unpacked};
use crate::model::pitch::Output;
use crate::optim::least_squares::least_squares;
use crate::recording::{NoteKind, Recording, WHOLE};
use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Memory of the input's own prediction, s.
const MEMORY_S: f64 = 0.8;
const MOST_TAPS: usize = 40;
/// What is new beyond this many standard deviations (by the median) is a switch.
const SWITCH: f64 = 4.0;
/// Regressions in which switches are left out.
const TRIMMED: usize = 2;
/// News, relative to the input's size, that is the rounding of the numbers.
const ROUNDING: f64 = 1e-4;
/// Later inputs that are looked at, s: each of the next ones, and one in a few up to where a person reacts.
const LATER_S: [f64; 2] = [0.1, 1.0];
/// Most later inputs that are looked at.
const MOST_LATER: usize = 10;
/// Odds of finding feedback by chance in one recording.
const ODDS: f64 = 1e-3;
/// Least share of what is new in the input that the innovations must explain: below it, the bias is small.
const LEAST_SHARE: f64 = 0.005;
/// Share of overridden samples from which the summary says so.
const OVERRIDDEN: f64 = 0.5;
/// Fewest samples that are tested.
const FEWEST: usize = 200;
/// Stretches that a section is cut into, and how many of them at least the news must come from.
const STRETCHES: usize = 20;
const FEWEST_STRETCHES: f64 = 5.0;
/// Name of the check.
pub const FEEDBACK: &str = "feedback";

/// What is known of each section's loop.
#[derive(Default)]
pub struct Loops {
    tests: Vec<(String, Test)>,
    /// Sections whose dwells were asked, and the odds that they follow the motion by chance.
    dwells: Vec<(String, f64)>,
    /// Sections that are closed on purpose.
    closed: Vec<String>,
    /// Sections that the supervisor entered, and the share of their samples that it decided.
    overridden: Vec<(String, f64)>,
    /// That share of all sections that claim to be open loop.
    share: f64,
    /// Logged samples that were averaged into a row.
    averaged: usize,
    /// Whether anything is new in the input of some section between its switches.
    new_between: bool,
}

impl Loops {
    /// Tests the sections that claim to be open loop, the rows of the supervisor left out.
    pub fn new(recordings: &[Recording], problem: &Problem<'_>, fit: &Fit) -> Self {
        let averaged = problem.data.thinned;
        let mut loops = Self { averaged, ..Self::default() };
        let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
        let Some(innovations) = innovations(problem, &unpacked) else { return loops };
        let places = problem.data.places();
        let starts = starting_points(problem, &unpacked, &places);
        let rates: Vec<Vec<f64>> = problem.data.runs.iter().map(Run::rate_or_slope).collect();
        let angles: Vec<Vec<f64>> = problem.data.runs.iter().map(Run::angle_or_sum).collect();
        let (mut entered, mut rows) = (0usize, 0usize);
        for (i, place) in places.into_iter().enumerate() {
            if closed_by_design(recordings, problem, &place) {
                loops.closed.push(place.label);
                continue;
            }
            let run = &problem.data.runs[place.run];
            let supervised = &run.supervised[place.rows.clone()];
            let count = supervised.iter().filter(|s| **s).count();
            if count > 0 {
                loops.overridden.push((place.label.clone(), count as f64 / place.rows.len() as f64));
            }
            entered += count;
            rows += place.rows.len();
            let u = &run.u[place.rows.clone()];
            let motion: Vec<Output> =
                place.rows.clone().map(|k| [rates[place.run][k], angles[place.run][k]]).collect();
            let one = std::slice::from_ref(&place);
            let start = starts.as_ref().map(|starts| &starts[i..=i]);
            let simulated = start.and_then(|start| simulate(problem, &unpacked, one, start)?.pop());
            let dwells = dwells(u, &motion, supervised, simulated.as_deref());
            loops.dwells.extend(dwells.iter().map(|dwells| (place.label.clone(), dwells.by_motion)));
            let e = &innovations[place.run][place.rows.clone()];
            let notes = recordings.get(run.recording).map_or(&[][..], |recording| &recording.notes);
            let interpolated = notes.iter().any(|note| note.kind == NoteKind::Resampled);
            let section = Section { u, e, supervised, step: run.step, averaged, interpolated, dwells };
            if let Some((test, new_between)) = section.test() {
                loops.new_between |= new_between;
                loops.tests.push((place.label, test));
            }
        }
        loops.share = entered as f64 / rows.max(1) as f64;
        loops
    }

    /// Odds below which a section is not open loop.
    fn limit(&self) -> f64 {
        ODDS / self.tests.len().max(1) as f64
    }

    fn is_closed(&self, test: &Test) -> bool {
        test.p_value < self.limit() && test.share > LEAST_SHARE
    }

    /// Whether any section was found to be open loop.
    pub fn any_open(&self) -> bool {
        self.tests.iter().any(|(_, test)| !self.is_closed(test))
    }

    /// Whether a section that claims to be open loop was found not to be. Where the supervisor overrides the excitation it says
    /// so, row by row.
    pub fn any_closed_unsaid(&self) -> bool {
        self.tests.iter().any(|(_, test)| self.is_closed(test))
    }

    /// Whether some section is closed, by design or as found, and none was found to be open loop.
    pub fn all_closed(&self) -> bool {
        let asked = !self.closed.is_empty() || !self.tests.is_empty();
        asked && !self.any_open()
    }

    /// In words.
    pub fn check(&self) -> DataCheck {
        let mut found: Vec<_> = self.tests.iter().filter(|(_, test)| self.is_closed(test)).collect();
        // of a section that a gap cuts the clearest piece is told
        found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.p_value.total_cmp(&b.1.p_value)));
        found.dedup_by(|a, b| a.0 == b.0);
        let mut parts: Vec<String> = found
            .iter()
            .map(|(label, test)| {
                format!("{} is not open loop: {} (p = {:.0e})", called(label), test.told(), test.p_value)
            })
            .collect();
        let heavy = !parts.is_empty() || self.share > OVERRIDDEN;
        if !self.overridden.is_empty() {
            let described: Vec<String> = self
                .overridden
                .iter()
                .map(|(label, share)| format!("{:.1} % of {label}", 100.0 * share))
                .collect();
            parts.push(format!(
                "the supervisor overrode the excitation in {}: the input answers to the motion there",
                described.join(", ")
            ));
        }
        if !parts.is_empty() {
            let gravity = if heavy { Gravity::Headline } else { Gravity::Told };
            let words =
                format!("{} (free runs are biased by it, one-step predictions are not)", parts.join("; "));
            return DataCheck::found(FEEDBACK, gravity, words);
        }
        let by_design = match self.closed.as_slice() {
            [] => String::new(),
            labels => format!("; a closed loop by design: {}", labels.join(", ")),
        };
        let Some(least) = self.tests.iter().map(|(_, test)| test.p_value).min_by(f64::total_cmp) else {
            return DataCheck::cannot_tell(FEEDBACK, format!("no section that could be tested{by_design}"));
        };
        let mut undecided: Vec<String> =
            self.dwells.iter().filter(|(_, p)| *p < self.limit()).map(|(label, _)| called(label)).collect();
        undecided.dedup();
        if !undecided.is_empty() {
            let words = format!(
                "in {} the times between the switches follow the motion, or those before them: the motion is the input's \
                 own, and cannot tell the two apart{by_design}",
                undecided.join(", ")
            );
            return DataCheck::cannot_tell(FEEDBACK, words);
        }
        let mut labels: Vec<String> = self.tests.iter().map(|(label, _)| called(label)).collect();
        labels.dedup();
        if self.averaged > 1 && self.new_between {
            let words = format!(
                "{} samples were averaged into one, and a controller that answers within them is not seen; over longer times the \
                 motion says nothing of later inputs (least p = {}){by_design}",
                self.averaged,
                digits(least)
            );
            return DataCheck::cannot_tell(FEEDBACK, words);
        }
        let words = format!(
            "in {} the motion says nothing of later inputs (least p = {}){by_design}",
            labels.join(", "),
            digits(least)
        );
        DataCheck::ruled_out(FEEDBACK, words)
    }
}

/// A section as it is called; a recording without sections is one.
fn called(label: &str) -> String {
    if label == WHOLE { "the recording".into() } else { format!("section {label}") }
}

fn innovations(problem: &Problem<'_>, unpacked: &Unpacked) -> Option<Vec<Vec<Output>>> {
    let mut all = vec![Vec::new(); problem.data.runs.len()];
    problem.predict(unpacked, |run, e| all[run] = e.iter().map(|e| problem.pack(*e)).collect())?;
    Some(all)
}

/// Section IV, any section that is called closed, and any whose attitude reference moves.
fn closed_by_design(recordings: &[Recording], problem: &Problem<'_>, place: &Place) -> bool {
    let label = place.label.rsplit(':').next().unwrap_or("");
    let called = label.split(['#', ' ']).next() == Some("IV") || label.to_lowercase().contains("closed");
    let run = &problem.data.runs[place.run];
    let Some(recording) = recordings.get(run.recording) else { return called };
    let (from, to) = (run.time(place.rows.start), run.time(place.rows.end));
    let begin = recording.t.first().copied().unwrap_or(0.0);
    let moves = |reference: &Vec<f64>| {
        let inside = recording.t.iter().zip(reference).filter(|(t, _)| (from..to).contains(&(*t - begin)));
        let mut values = inside.map(|(_, r)| *r);
        let first = values.next();
        values.any(|r| Some(r) != first)
    };
    called || recording.theta_ref.as_ref().is_some_and(moves)
}

/// One section's input and innovations.
struct Section<'a> {
    u: &'a [f64],
    e: &'a [Output],
    supervised: &'a [bool],
    step: f64,
    averaged: usize,
    /// Whether the outputs were interpolated between the stamps.
    interpolated: bool,
    dwells: Option<Dwells>,
}

/// The outcome for one section.
struct Test {
    p_value: f64,
    /// Share of the variance of what is new in the input that the motion explains, beyond what chance gives.
    share: f64,
    kind: Kind,
}

/// What was asked.
enum Kind {
    /// The innovations against what is new in the input of the same row.
    AtOnce,
    /// The innovations against what is new in the input so many s later.
    Later(f64),
    /// What the input did not make of the motion at a switch against the time to the next.
    Dwell,
}

impl Test {
    fn told(&self) -> String {
        let share = 100.0 * self.share;
        match self.kind {
            Kind::AtOnce => {
                format!("the innovations explain {share:.1} % of what is new in the input of the same row")
            }
            Kind::Later(reach) => format!(
                "the innovations explain {share:.1} % of what is new in the input within the next {reach:.2} s"
            ),
            Kind::Dwell => format!(
                "what else moves the craft at a switch explains {share:.0} % of the time to the next that the switches before do not"
            ),
        }
    }
}

impl Section<'_> {
    /// Tests innovations against what is new in later inputs, and says whether anything is new in it between its switches; `None`
    /// where too little is there to be tested.
    fn test(&self) -> Option<(Test, bool)> {
        let taps = ((MEMORY_S / self.step) as usize).clamp(2, MOST_TAPS).min(self.u.len() / 8);
        let all: Vec<bool> = (0..self.u.len()).map(|k| k >= taps && !self.supervised[k]).collect();
        let whole = whitened(self.u, taps, &all)?;
        if typical_size(&whole, &all) < ROUNDING * typical_size(self.u, &all) {
            return None;
        }
        let channels = uncorrelated(self.e);
        let [near, far] = LATER_S.map(|reach| self.later(reach));
        let sums = |lags: &[usize], new: &[f64], counts: &[bool]| self.sums(&channels, new, counts, lags);
        let between = self.between_switches(taps, whole.clone(), &all);
        let (between, whole) = (between.as_ref(), (&whole, &all));
        let in_its_row = |(new, counts): (&Vec<f64>, &Vec<bool>)| {
            (self.averaged == 1 && !self.interpolated).then(|| sums(&[0], new, counts)).flatten()
        };
        let by_the_rest = self.dwells.as_ref().and_then(|dwells| dwells.by_the_rest.as_ref());
        let tests = [
            in_its_row(whole),
            sums(&near, whole.0, whole.1),
            sums(&far, whole.0, whole.1),
            between.and_then(|(new, counts)| in_its_row((new, counts))),
            between.and_then(|(new, counts)| sums(&near, new, counts)),
            by_the_rest.map(|&Told { p_value, share }| Test { p_value, share, kind: Kind::Dwell }),
        ];
        let tests: Vec<Test> = tests.into_iter().flatten().collect();
        let odds = tests.len() as f64;
        let clearest = tests.into_iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value))?;
        Some((Test { p_value: (odds * clearest.p_value).min(1.0), ..clearest }, between.is_some()))
    }

    /// What is new in the input between its switches, and the rows that are no switches; `None` where nothing is.
    fn between_switches(&self, taps: usize, whole: Vec<f64>, all: &[bool]) -> Option<(Vec<f64>, Vec<bool>)> {
        let (mut new, mut counts) = (whole, all.to_vec());
        for _ in 0..TRIMMED {
            let limit = SWITCH * median_size(&new, &counts);
            counts = (0..new.len()).map(|k| all[k] && new[k].abs() <= limit).collect();
            new = whitened(self.u, taps, &counts)?;
        }
        (median_size(&new, &counts) > ROUNDING * typical_size(self.u, all)).then_some((new, counts))
    }

    /// The lags of inputs up to `reach` s later.
    fn later(&self, reach: f64) -> Vec<usize> {
        let last = ((reach / self.step).round() as usize).max(3);
        (if self.interpolated { 2 } else { 1 }..=last).step_by(last.div_ceil(MOST_LATER)).collect()
    }

    /// Of innovations and what is new in the input `lags` rows later.
    fn sums(&self, channels: &[Vec<f64>], new: &[f64], counts: &[bool], lags: &[usize]) -> Option<Test> {
        if news_from(new, counts) < FEWEST_STRETCHES {
            return None;
        }
        let (mut sum, mut share, mut fewest) = (0.0, 0.0, usize::MAX);
        for &lag in lags {
            // Rows without the supervisor from the innovation to the input that is new.
            let rows: Vec<usize> = (lag..new.len())
                .filter(|&k| counts[k] && !self.supervised[k - lag..=k].contains(&true))
                .collect();
            fewest = fewest.min(rows.len());
            for e in channels {
                let pairs = || rows.iter().map(|&k| (e[k - lag], new[k]));
                let product: f64 = pairs().map(|(e, w)| e * w).sum();
                let spread: f64 = pairs().map(|(e, w)| e * e * w * w).sum();
                let powers = pairs().fold((0.0, 0.0), |(a, b), (e, w)| (a + e * e, b + w * w));
                if spread > 0.0 {
                    sum += product * product / spread;
                    share += product * product / (powers.0 * powers.1) - 1.0 / rows.len() as f64;
                }
            }
        }
        let freedom = (channels.len() * lags.len()) as f64;
        let p_value = ChiSquared::new(freedom).ok()?.sf(sum);
        let kind = match lags {
            [0] => Kind::AtOnce,
            _ => Kind::Later(lags.last().map_or(0.0, |&last| last as f64 * self.step)),
        };
        (fewest >= FEWEST).then_some(Test { p_value, share, kind })
    }
}

/// Root mean square of the rows that count.
fn typical_size(values: &[f64], counts: &[bool]) -> f64 {
    let counted = || values.iter().zip(counts).filter(|(_, c)| **c).map(|(v, _)| *v);
    (counted().map(|v| v * v).sum::<f64>() / counted().count().max(1) as f64).sqrt()
}

/// How many of the section's [`STRETCHES`] what is new comes from: (Σ E)² / Σ E² of their energies.
fn news_from(new: &[f64], counts: &[bool]) -> f64 {
    let long = new.len().div_ceil(STRETCHES).max(1);
    let energy = |(new, counts): (&[f64], &[bool])| {
        new.iter().zip(counts).filter(|(_, c)| **c).map(|(w, _)| w * w).sum::<f64>()
    };
    let (sum, squares) = new
        .chunks(long)
        .zip(counts.chunks(long))
        .map(energy)
        .fold((0.0, 0.0), |(a, b), e| (a + e, b + e * e));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// The same by the median, as it is for normal numbers.
fn median_size(values: &[f64], counts: &[bool]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().zip(counts).filter(|(_, c)| **c).map(|(v, _)| v.abs()).collect();
    let middle = sizes.len() / 2;
    sizes.sort_by(f64::total_cmp);
    1.4826 * sizes.get(middle).copied().unwrap_or(0.0)
}

/// What `taps` values before it do not tell of each value, by a regression over the rows that count.
fn whitened(u: &[f64], taps: usize, counts: &[bool]) -> Option<Vec<f64>> {
    let row = |k: usize| {
        let past = u[k - taps..k].iter().rev().copied();
        DVector::from_iterator(taps + 1, past.chain([1.0]))
    };
    let rows = (taps..u.len()).filter(|&k| counts[k]).map(|k| (row(k), u[k]));
    let weights = least_squares(taps + 1, rows)?;
    let new = |k: usize| if k < taps { 0.0 } else { u[k] - weights.dot(&row(k)) };
    Some((0..u.len()).map(new).collect())
}

/// The channels, the second less what the first tells of it; a dead channel is left out.
fn uncorrelated(innovations: &[Output]) -> Vec<Vec<f64>> {
    let product = |a: usize, b: usize| innovations.iter().map(|e| e[a] * e[b]).sum::<f64>();
    let first: Vec<f64> = innovations.iter().map(|e| e[0]).collect();
    let slope = product(0, 1) / product(0, 0).max(f64::MIN_POSITIVE);
    let second: Vec<f64> = innovations.iter().map(|e| e[1] - slope * e[0]).collect();
    [first, second].into_iter().filter(|channel| channel.iter().any(|e| *e != 0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a section says of the motion that one row later is its input, but for what is new in it.
    fn asked(u: &[f64], e: impl Fn(usize, f64) -> f64) -> Option<Test> {
        let noise = |k: usize| (0.7 * (k * k % 1009) as f64).sin();
        let e: Vec<Output> = (0..u.len()).map(|k| [e(k, noise(k)), 0.0]).collect();
        let supervised = vec![false; u.len()];
        let section = Section {
            u,
            e: &e,
            supervised: &supervised,
            step: 0.05,
            averaged: 1,
            interpolated: false,
            dwells: None,
        };
        section.test().map(|(test, _)| test)
    }

    #[test]
    fn a_ramp_along_which_a_model_errs_is_not_asked_and_feedback_is() {
        let ramp: Vec<f64> = (0..400).map(|k| if k < 200 { k.min(30) as f64 } else { 35.0 }).collect();
        assert!(asked(&ramp, |k, noise| noise + if k < 30 { 3.0 } else { 0.0 }).is_none());
        let noise = |k: usize| (0.7 * (k * k % 1013) as f64).sin();
        let moved: Vec<f64> = (0..400).map(noise).collect();
        let fed_back = asked(&moved, |k, noise| noise + if k < 399 { 2.0 * moved[k + 1] } else { 0.0 });
        assert!(fed_back.is_some_and(|test| test.p_value < ODDS));
        assert!(asked(&moved, |_, noise| noise).is_some_and(|test| test.p_value > ODDS));
    }
}
