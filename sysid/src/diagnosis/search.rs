//! Maximum likelihood for one set of effects: the innovations form with coloured disturbance, from several starts.

use super::change_point::best_moment;
use crate::likelihood::fit::{Fit, SKETCH, fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use crate::optim::chord::{Chord, Descent};
use crate::optim::levenberg_marquardt::{Effort, minimize};
use crate::progress::{Counted, Progress};
use rayon::prelude::*;

/// Strength that stands for "near output error".
const LOW_GAIN: f64 = 0.03;
/// Candidates whose sketch ends this far above the best in BIC are not fitted to the end.
const HOPELESS: f64 = 60.0;
/// A better moment to begin at is looked for where BIC lies at most this far above the best: it gains less than that.
const NEAR_MOMENT: f64 = 30.0;
/// Steps that a start is followed, and those of them that every start is.
const CHORD_STEPS: usize = 8;
const FIRST_STEPS: usize = 3;
/// A candidate that has settled with less gain in BIC than this is not needed, whatever else is.
const NEEDLESS: f64 = -4.0;
/// Further below `before` a candidate has not settled: its own parameters could as well vanish.
const UNSETTLED: f64 = -30.0;
/// A descent along the chord may end at this share of the best one's gain and come near it all the same.
const CLOSE: f64 = 0.7;
/// A descent may gain what its last step gained this many times more.
const STEPS_TO_COME: f64 = 4.0;
/// and a sketch this many times more. (With as many as a fit to the end takes, a hover in a loop is led to the controller's inverse.)
const STEPS_TO_END: f64 = 6.0;
/// Two descents of a candidate whose gains differ by less than this have come to the same place.
const SAME_PLACE: f64 = 1.0;
/// A candidate that promises less than this share of the best by its score is not tried,
const WORTH_A_STEP: f64 = 0.1;
/// the same where the noise model is not the data's own, and every score is high,
const WORTH_FROM_AFAR: f64 = 0.3;
/// but for the first few.
const ALWAYS_STEPPED: usize = 8;
/// A candidate whose score comes to this share of the best is followed although the chord does not lead it down.
const LIKELY: f64 = 0.5;
/// A start that gains less than this share of the best one's by its first steps is not followed,
const PROMISING: f64 = 0.1;
/// but for the first few.
const ALWAYS_FOLLOWED: usize = 6;
/// Prospects that are fitted whatever they look like: the baseline is fitted again from where they end.
const ALWAYS_FITTED: usize = 3;
/// From a start that the chord does not lead away from, the noise model has far to go.
const LONG_SKETCH: Effort = Effort { iterations: 15, tolerance: 0.5 };
/// `before` with each of `candidates` in turn, best first. Their starts are followed a few steps, from the optimum of
/// `before` and from near output error (where the disturbance model does not swallow an effect before it is seen), at first
/// from the user's values too; those that are worth it are fitted, and those of them that come near the best are fitted to the end.
pub fn fit_one_more(
    problem: &Problem<'_>,
    before: &Fit,
    candidates: &[&'static dyn Effect],
    progress: &Progress<'_>,
) -> Vec<Fit> {
    let prospects = worth_fitting(prospects(problem, before, candidates));
    let counted = Counted::new(progress, "", prospects.len());
    let sketches: Vec<Fit> = prospects
        .par_iter()
        .filter_map(|prospect| {
            let effort = if prospect.settled() { SKETCH } else { LONG_SKETCH };
            let sketch = fit(problem, &prospect.effects, &prospect.values, effort);
            counted.one();
            sketch
        })
        .collect();
    let mut best: Vec<Fit> = Vec::new();
    for fit in sketches {
        match best.iter_mut().find(|other| other.ids() == fit.ids()) {
            Some(other) if other.criterion() <= fit.criterion() => {}
            Some(other) => *other = fit,
            None => best.push(fit),
        }
    }
    let mut fits = to_the_end(problem, before, best);
    let lowest = fits.iter().map(|fit| fit.bic(problem)).fold(before.bic(problem), f64::min);
    let near = |fit: &Fit| fit.bic(problem) < lowest + NEAR_MOMENT;
    fits = fits.into_iter().map(|fit| if near(&fit) { best_moment(problem, fit) } else { fit }).collect();
    fits.sort_by(|a, b| a.bic(problem).total_cmp(&b.bic(problem)));
    fits
}

/// Those of `sketches` that come near the best, fitted to the end. One that ends at a bound is no candidate, and those that it has
/// outbid come after it.
fn to_the_end(problem: &Problem<'_>, before: &Fit, mut sketches: Vec<Fit>) -> Vec<Fit> {
    let within = |fit: &Fit| is_within(problem, fit);
    let mut fits: Vec<Fit> = Vec::new();
    loop {
        let is_fitted = |sketch: &Fit| fits.iter().any(|fit: &Fit| fit.ids() == sketch.ids());
        let mut near = near_the_best(problem, before, &sketches);
        near.retain(|sketch| !is_fitted(sketch));
        let refitted = |sketch: &&Fit| refit(problem, &sketch.effects, &sketch.minimum.values).filter(within);
        let ended: Vec<Fit> = near.par_iter().filter_map(refitted).collect();
        let tried: Vec<_> = near.iter().map(|sketch| sketch.ids()).collect();
        let all_stand = ended.len() == tried.len();
        fits.extend(ended);
        if all_stand {
            return fits;
        }
        let is_out =
            |sketch: &Fit| tried.contains(&sketch.ids()) && fits.iter().all(|fit| fit.ids() != sketch.ids());
        sketches.retain(|sketch| !is_out(sketch));
    }
}

/// Whether the candidate, the last of the effects, has not ended at a bound.
fn is_within(problem: &Problem<'_>, fit: &Fit) -> bool {
    !fit.at_bound(problem, fit.effects.len() - 1)
}

/// Those of `sketches` that may come to lie near the best of them.
fn near_the_best<'f>(problem: &Problem<'_>, before: &Fit, sketches: &'f [Fit]) -> Vec<&'f Fit> {
    // A sketch at a bound often lies lowest and is no candidate in the end: it must not outbid the others.
    let lowest = sketches
        .iter()
        .filter(|f| is_within(problem, f))
        .map(|f| f.bic(problem))
        .fold(f64::INFINITY, f64::min);
    let of_use = before.bic(problem) - NEEDLESS;
    let needed = if lowest.is_finite() { of_use.max(lowest + SAME_PLACE) } else { of_use };
    let class = |fit: &Fit| fit.effects.last().and_then(|effect| effect.class());
    let leading = sketches.iter().find(|fit| fit.bic(problem) == lowest).and_then(class);
    // Of those that do nearly the same, a few steps do not say which does it best.
    let alike = before.bic(problem) - CLOSE * (before.bic(problem) - lowest);
    let near = |fit: &&Fit| {
        let same_class = leading.is_some() && class(fit) == leading;
        let far = if same_class { alike.max(lowest + HOPELESS) } else { lowest + HOPELESS };
        // One that still falls has not been drawn to the end.
        fit.bic(problem) - STEPS_TO_END * fit.minimum.drop < needed.min(far)
    };
    sketches.iter().filter(near).collect()
}

/// A candidate beside `before`, a few steps from one of its starts.
pub struct Prospect {
    /// The effects of `before` and the candidate.
    pub effects: Vec<&'static dyn Effect>,
    /// Where the steps have led.
    pub values: Vec<f64>,
    /// BIC of `before` less BIC there.
    gain: f64,
    /// By how much the last step raised the gain.
    rise: f64,
    /// Score of its start, as a share of the best one's from there.
    share: f64,
}

impl Prospect {
    fn new(problem: &Problem<'_>, before: &Fit, effects: Vec<&'static dyn Effect>, end: Descent) -> Self {
        let own = end.values.len() - before.minimum.values.len();
        let penalty = own as f64 * (problem.count() as f64).ln();
        Self {
            effects,
            values: end.values,
            gain: before.criterion() - end.criterion - penalty,
            rise: end.drop,
            share: 0.0,
        }
    }

    fn settled(&self) -> bool {
        self.gain > UNSETTLED
    }

    fn id(&self) -> &'static str {
        self.effects.last().map_or("", |effect| effect.about().id)
    }
}

/// Those of `candidates` that after one step from their best start are worth their parameters.
pub fn worth_a_fit(
    problem: &Problem<'_>,
    before: &Fit,
    candidates: &[&'static dyn Effect],
) -> Vec<&'static dyn Effect> {
    let gaining = screen(problem, before, candidates).into_iter().filter(|prospect| prospect.gain > 0.0);
    gaining.filter_map(|prospect| prospect.effects.last().copied()).collect()
}

/// `before` with each of `candidates` after one step from its best start, best BIC first.
pub fn screen(problem: &Problem<'_>, before: &Fit, candidates: &[&'static dyn Effect]) -> Vec<Prospect> {
    let optimum = &before.minimum.values;
    let Some(chord) = chord(problem, before, optimum) else { return Vec::new() };
    let mut all = best_starts(problem, before, candidates, optimum, &chord, WORTH_A_STEP);
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}

/// The candidates a few steps from the optimum of `before`, from near output error, and from the user's model.
fn prospects(problem: &Problem<'_>, before: &Fit, candidates: &[&'static dyn Effect]) -> Vec<Prospect> {
    let optimum = &before.minimum.values;
    let mut all = Vec::new();
    if let Some(chord) = chord(problem, before, optimum) {
        let starts = best_starts(problem, before, candidates, optimum, &chord, WORTH_A_STEP);
        all.extend(followed(problem, before, starts, &chord));
    }
    for mut low in [near_output_error(problem, before), users_model(problem, before)].into_iter().flatten() {
        let Some(at_low) = chord(problem, before, &low) else { continue };
        let mut starts = best_starts(problem, before, candidates, &low, &at_low, WORTH_FROM_AFAR);
        let noise = problem.noise_range();
        for values in starts.iter_mut().map(|start| &mut start.values).chain([&mut low]) {
            values[noise.clone()].copy_from_slice(&optimum[noise.clone()]);
        }
        if let Some(chord) = chord(problem, before, &low) {
            all.extend(followed(problem, before, starts, &chord));
        }
    }
    all
}

/// All prospects a few steps further along `chord`, those that promise more than others to the end.
fn followed(problem: &Problem<'_>, before: &Fit, starts: Vec<Prospect>, chord: &Chord) -> Vec<Prospect> {
    let begun = further(problem, before, starts, chord, FIRST_STEPS);
    further(problem, before, promising(begun), chord, CHORD_STEPS - FIRST_STEPS)
}

/// Those that have come to a tenth of the best one's gain, those whose scores are high, and the first few at least: others do
/// not come near.
fn promising(mut starts: Vec<Prospect>) -> Vec<Prospect> {
    starts.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let floor = PROMISING * starts.first().map_or(0.0, |best| best.gain.max(0.0));
    let mut place = 0..;
    starts.retain(|start| {
        place.next().is_some_and(|i| i < ALWAYS_FOLLOWED) || start.gain >= floor || start.share >= LIKELY
    });
    starts
}

/// Those prospects that may come to lie near the best, or to be needed at all: others have settled too far below. One
/// that has not settled is kept where its score was high, unless the candidate is of use from another start; one that comes to
/// the same place twice is kept once.
fn worth_fitting(mut all: Vec<Prospect>) -> Vec<Prospect> {
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let best = all.first().map_or(0.0, |prospect| prospect.gain);
    let floor = (CLOSE * best - HOPELESS).max(NEEDLESS);
    let mut kept: Vec<Prospect> = Vec::new();
    for prospect in all {
        let known = kept.iter().rfind(|other| other.id() == prospect.id());
        let again = known.is_some_and(|other| other.gain - prospect.gain < SAME_PLACE);
        let may_rise = prospect.gain + STEPS_TO_COME * prospect.rise > floor;
        let settled = prospect.settled() || known.is_some_and(|other| other.gain > NEEDLESS);
        if kept.len() < ALWAYS_FITTED || (!again && (may_rise || !settled && prospect.share >= LIKELY)) {
            kept.push(prospect);
        }
    }
    kept
}

/// The candidates that promise most, each from its best start, after one step from `values` of the unknowns of `before`, where
/// `chord` was taken.
fn best_starts(
    problem: &Problem<'_>,
    before: &Fit,
    candidates: &[&'static dyn Effect],
    values: &[f64],
    chord: &Chord,
    least_share: f64,
) -> Vec<Prospect> {
    let left = problem.residual_moment(&before.effects, &before.minimum.values);
    let best_start = |&candidate: &&'static dyn Effect| {
        let effects = [&before.effects[..], &[candidate]].concat();
        let residuals = problem.prediction_errors(&effects);
        let coordinates = problem.coordinates(&effects);
        let promised = |own: Vec<f64>| {
            let start = [values, &own].concat();
            let promise = chord.promise(&residuals, problem.channels(), &coordinates, &start)?;
            Some((promise, start))
        };
        let starts = candidate.starts_from(&problem.sizes, &left).into_iter().filter_map(promised);
        let (promise, start) = starts.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((promise, effects.clone(), start))
    };
    let mut all: Vec<_> = candidates.par_iter().filter_map(best_start).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = all.first().map_or(0.0, |best| best.0).max(f64::MIN_POSITIVE);
    // Members of a class are hardly told apart by their starts.
    let class = |effects: &[&'static dyn Effect]| effects.last().and_then(|effect| effect.class());
    let leading = all.first().and_then(|(_, effects, _)| class(effects));
    let mut place = 0..;
    all.retain(|(promise, effects, _)| {
        place.next().is_some_and(|i| i < ALWAYS_STEPPED)
            || *promise >= least_share * most
            || leading.is_some() && class(effects) == leading
    });
    all.into_par_iter()
        .filter_map(|(promise, effects, start)| {
            let end = descend(problem, chord, &effects, &start, 1)?;
            Some(Prospect { share: promise / most, ..Prospect::new(problem, before, effects, end) })
        })
        .collect()
}

/// The prospects a few steps further along `chord`. One that does not settle has followed a Jacobian that no longer holds,
/// and stays where it began.
fn further(
    problem: &Problem<'_>,
    before: &Fit,
    from: Vec<Prospect>,
    chord: &Chord,
    steps: usize,
) -> Vec<Prospect> {
    from.into_par_iter()
        .filter_map(|Prospect { effects, values, share, .. }| {
            let end = descend(problem, chord, &effects, &values, steps)?;
            let mut prospect = Prospect { share, ..Prospect::new(problem, before, effects, end) };
            if !prospect.settled() {
                prospect.values = values;
            }
            Some(prospect)
        })
        .collect()
}

fn chord(problem: &Problem<'_>, before: &Fit, values: &[f64]) -> Option<Chord> {
    let residuals = problem.prediction_errors(&before.effects);
    Chord::new(&residuals, problem.channels(), &problem.coordinates(&before.effects), values)
}

fn descend(
    problem: &Problem<'_>,
    chord: &Chord,
    effects: &[&'static dyn Effect],
    start: &[f64],
    steps: usize,
) -> Option<Descent> {
    let residuals = problem.prediction_errors(effects);
    chord.descend(&residuals, problem.channels(), &problem.coordinates(effects), start, steps)
}

/// Values of `before`'s unknowns with the noise model held near output error, the mount held as the user's model has
/// it (a mount bent out of its place hides lags and delays), and the rest fitted again.
fn near_output_error(problem: &Problem<'_>, before: &Fit) -> Option<Vec<f64>> {
    let mut start = before.minimum.values.clone();
    let mut coordinates = problem.coordinates(&before.effects);
    let (noise, mount) = (problem.noise_range(), problem.mount_range());
    start[noise.clone()].copy_from_slice(&problem.noise_start(LOW_GAIN));
    start[mount.clone()].copy_from_slice(&problem.plant_start()[mount.clone()]);
    for i in noise.chain(mount) {
        coordinates[i].bounds = [start[i]; 2];
    }
    let residuals = problem.prediction_errors(&before.effects);
    minimize(&residuals, problem.channels(), &coordinates, &start, SKETCH).map(|m| m.values)
}

/// The values of the user's model near output error, where `before` has no physics yet: what is missing has bent the plant
/// at the optimum, and a large effect may lie beyond a ridge from there.
fn users_model(problem: &Problem<'_>, before: &Fit) -> Option<Vec<f64>> {
    if !before.effects.iter().all(|effect| effect.is_background()) {
        return None;
    }
    let mut values = before.minimum.values.clone();
    values[..problem.plant_unknowns()].copy_from_slice(&problem.plant_start());
    values[problem.noise_range()].copy_from_slice(&problem.noise_start(LOW_GAIN));
    Some(values)
}
