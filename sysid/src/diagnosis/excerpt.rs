//! A long recording is searched in part and judged whole.
//!
//! What a search asks of the data, which of many models is worth the rest of the work, a few thousand samples say as well as
//! a hundred thousand: what has no evidence in them is no material part of the motion. They are taken in stretches from all
//! over the recording. The models that come near the best there are fitted to all data, what acts from some moment on is asked of
//! all data, and all that is told is told of them.

use super::change_point::best_moment;
use super::levels::MOST_TERMS;
use super::posterior::{Selection, Visited};
use super::search::worth_a_fit;
use super::selection::Search;
use crate::dataset::{Beside, Dataset, Place, Run, pieces};
use crate::likelihood::fit::{Fit, refit};
use crate::likelihood::problem::Problem;
use rayon::prelude::*;
use std::ops::Range;

/// Readings that a search is made on: a little more than those of a test of 100 s at 50 Hz.
const ENOUGH: usize = 6_000;
/// To search in part and to fit again costs more than to search on no more than so many.
const FEW: usize = 10_000;
/// Stretches in which they lie. Where no angle is measured, one, the one of most motion: nothing says at which angle a stretch begins,
/// and what pulls back from there would be a moment of each of them for as long as they last.
const STRETCHES: usize = 16;
/// Models are carried over whose log posterior lies no further below the best one's, and so many at the most.
const WITHIN: f64 = 10.0;
const MOST_CARRIED: usize = 8;

/// Stretches of equal length from all over the data, or one as long as all of them; `None` where the data are few.
pub fn excerpt(data: &Dataset) -> Option<Dataset> {
    let all = data.samples();
    let every = data.runs.iter().map(Run::measured_every).max().unwrap_or(1);
    let enough = every * ENOUGH;
    if all <= every * FEW {
        return None;
    }
    let stretch = |k: usize, length: usize| {
        let first = (k * all / STRETCHES).min(all - length);
        let rows = pieces(data.runs.iter().map(Run::len), first..first + length);
        rows.filter(|(_, rows)| rows.len() > 1).collect::<Vec<_>>()
    };
    let rows: Vec<(usize, Range<usize>)> = if data.has_angle {
        (0..STRETCHES).flat_map(|k| stretch(k, enough / STRETCHES)).collect()
    } else {
        let motion = |rows: &Vec<(usize, Range<usize>)>| {
            let place = |(run, rows): &(usize, Range<usize>)| Place {
                label: String::new(),
                run: *run,
                rows: rows.clone(),
            };
            data.motion(&rows.iter().map(place).collect::<Vec<_>>())
        };
        (0..STRETCHES).map(|k| stretch(k, enough)).max_by(|a, b| motion(a).total_cmp(&motion(b)))?
    };
    let runs = rows.into_iter().map(|(run, rows)| cut(&data.runs[run], rows)).collect();
    Some(Dataset { runs, ..*data })
}

/// Some rows of a run, without its sections.
fn cut(run: &Run, rows: Range<usize>) -> Run {
    let of = |signal: &Option<Vec<f64>>| signal.as_ref().map(|signal| signal[rows.clone()].to_vec());
    let beside = &run.beside;
    Run {
        start: run.time(rows.start),
        u: run.u[rows.clone()].to_vec(),
        between: run.between.as_ref().map(|mean| mean.cut(rows.clone())),
        leads: run.leads,
        command_news: of(&run.command_news),
        rate: of(&run.rate),
        angle: of(&run.angle),
        beside: Beside {
            roll_and_yaw: beside.roll_and_yaw.as_ref().map(|signal| signal[rows.clone()].to_vec()),
            roll_rate: of(&beside.roll_rate),
            roll_command: of(&beside.roll_command),
            thrust: of(&beside.thrust),
            voltage: of(&beside.voltage),
        },
        supervised: run.supervised[rows.clone()].to_vec(),
        unmeasured: run.unmeasured.get(rows.clone()).unwrap_or_default().to_vec(),
        sections: Vec::new(),
        ..*run
    }
}

/// The selection `of` an excerpt carried over to all data, which `search` has not yet visited beyond the baseline.
pub fn carried(mut search: Search<'_, '_>, excerpt: &Problem<'_>, of: &Selection) -> Option<Selection> {
    let problem = search.problem;
    let divisor = of.visited[of.extended].divisor(excerpt);
    let value = |i: usize| of.visited[i].log_posterior(excerpt, divisor);
    let mut likely: Vec<usize> = (0..of.visited.len()).collect();
    likely.sort_by(|a, b| value(*b).total_cmp(&value(*a)));
    let least = value(likely[0]) - WITHIN;
    likely.truncate(MOST_CARRIED);
    likely.retain(|i| value(*i) >= least);
    likely.extend([of.baseline, of.named, of.extended, of.fullest]);
    likely.sort_unstable();
    likely.dedup();
    let fits: Vec<Fit> = likely
        .par_iter()
        .map(|&i| &of.visited[i].fit)
        .filter_map(|fit| refit(problem, &fit.effects, &fit.minimum.values))
        .map(|fit| best_moment(problem, fit))
        .collect();
    for fit in fits {
        search.visit(fit);
    }
    let of_the_day = |v: &Visited| v.fit.effects.iter().all(|e| e.is_background());
    let told = search.best_of_all(0, of_the_day);
    search.with_third_pole(told);
    let baseline = search.best_of_all(0, of_the_day);
    // What acts from some moment on may lie between the stretches.
    let timed = search.candidates.acting_from_a_moment();
    let likeliest = search.best_named(baseline);
    let mut named = search.with_third_pole(likeliest);
    for _ in 0..MOST_TERMS {
        // a fit to all data is dear, and what is worth one shows in a step
        let promising = worth_a_fit(problem, &search.visited[named].fit, &timed);
        search.one_more(named, &promising);
        search.visit_without(named);
        search.visit_its_class(named);
        let better = search.best_named(named);
        if better == named {
            break;
        }
        named = search.settle(better);
    }
    let names = search.visited[named].names();
    let extended = search.best_of_all(named, |v| v.names() == names);
    Some(search.selection(baseline, named, extended))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::{GAIN, fitted, flight, model};

    #[test]
    fn an_excerpt_lies_all_over_the_data_each_row_where_it_was() {
        fitted(&flight(1, 0.0).recording(), &model(GAIN, 0.06), |_, problem, _| {
            assert!(excerpt(problem.data).is_none(), "{} rows are few", problem.data.samples());
            let run = &problem.data.runs[0];
            let long = Run {
                u: (0..40_000).map(f64::from).collect(),
                rate: Some((0..40_000).map(|k| 2.0 * f64::from(k)).collect()),
                angle: None,
                supervised: vec![false; 40_000],
                beside: Beside::default(),
                ..run.clone()
            };
            let all = Dataset { runs: vec![long.clone()], ..problem.data.clone() };
            let of_the_rate = excerpt(&Dataset { has_angle: false, ..all.clone() }).unwrap();
            assert_eq!((of_the_rate.runs.len(), of_the_rate.samples()), (1, ENOUGH));
            let moved =
                |k: usize| if (21_000..27_000).contains(&k) && k.is_multiple_of(2) { 1.0 } else { 0.0 };
            let once = Run { rate: Some((0..40_000).map(moved).collect()), ..long.clone() };
            let moving =
                excerpt(&Dataset { has_angle: false, runs: vec![once], ..problem.data.clone() }).unwrap();
            assert_eq!(moving.runs[0].u[0], 20_000.0, "where it moves");
            let part = excerpt(&all).unwrap();
            assert_eq!((part.runs.len(), part.samples()), (STRETCHES, ENOUGH));
            for run in &part.runs {
                let row = run.u[3] as usize;
                assert!((run.time(3) - long.time(row)).abs() < 1e-9);
                assert_eq!(run.rate.as_ref().unwrap()[3], 2.0 * run.u[3]);
            }
            assert_eq!(part.runs[STRETCHES - 1].u[0], 37_500.0, "the last sixteenth begins there");
        });
    }
}
