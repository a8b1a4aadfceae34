//! Flights with physics that the test flight's model lacks, and selections made by hand over them.

use super::data_checks::fixture::{Flight, GAIN, STEP, fitted, flight, model, normal};
use super::parts::Part;
use super::posterior::{Selection, Visited};
use crate::catalogue::find;
use crate::dataset::Place;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{Fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use rand::SeedableRng;
use rand_pcg::Pcg64;

const DELAY: f64 = 0.06;
/// ln of the odds of one term more, about those of a name of the whole catalogue.
const LOG_PRIOR: f64 = -4.3;

/// The test flight with a further moment in N m, of the row, the rate and the angle.
pub fn flight_with(seed: u64, moment: impl Fn(usize, f64, f64) -> f64) -> Flight {
    flown_by(seed, flight(seed, 0.0).u, moment)
}

/// The test flight's input, this much weaker but in its last quarter.
pub fn weaker_at_first(share: f64) -> Vec<f64> {
    let u = flight(1, 0.0).u;
    let last = u.len() / 4 * 3;
    u.iter().enumerate().map(|(k, u)| if k < last { share * u } else { *u }).collect()
}

/// The same with another input.
pub fn flown_by(seed: u64, u: Vec<f64>, moment: impl Fn(usize, f64, f64) -> f64) -> Flight {
    let plant = model(GAIN, DELAY).plant;
    let (damping, inertia) = (plant.dm_dq.unwrap(), plant.inertia_kg_m2);
    let mut flown = Flight { u, ..flight(seed, 0.0) };
    let mut random = Pcg64::seed_from_u64(seed + 1000);
    let (mut rate, mut angle, mut coloured) = (0.0, 0.0, 0.0);
    for k in 0..flown.u.len() {
        flown.q[k] = rate + 0.01 * normal(&mut random);
        flown.theta[k] = angle + 0.003 * normal(&mut random);
        coloured = 0.9 * coloured + 0.06 * normal(&mut random);
        let delayed = if k >= 3 { flown.u[k - 3] } else { 0.0 };
        let all = damping * rate + GAIN * delayed + coloured + moment(k, rate, angle);
        let next = rate + STEP * all / inertia;
        angle += 0.5 * STEP * (rate + next);
        rate = next;
    }
    flown
}

/// The test flight by an actuator that follows its command with a lag, s.
pub fn lagging(seed: u64, lag: f64) -> Flight {
    let Flight { u, .. } = flight(seed, 0.0);
    let passed = -(-STEP / lag).exp_m1();
    let mut followed = vec![0.0; u.len()];
    for k in 1..u.len() {
        followed[k] = followed[k - 1] + passed * (u[k - 1] - followed[k - 1]);
    }
    // over a step it acts with its mean
    let mean = |k: usize| u[k] + (followed[k] - u[k]) * passed * lag / STEP;
    let missing: Vec<f64> = (0..u.len()).map(|k| mean(k) - u[k]).collect();
    flown_by(seed, u, |k, _, _| if k >= 3 { GAIN * missing[k - 3] } else { 0.0 })
}

/// Fits the right plant without the further moment, and hands problem and fit to `ask`.
pub fn asked<T>(flight: &Flight, ask: impl FnOnce(&Problem<'_>, &Fit) -> T) -> T {
    fitted(&flight.recording(), &model(GAIN, DELAY), |_, problem, fit| ask(problem, fit))
}

/// The flight in four parts of the same length.
pub fn quarters(problem: &Problem<'_>) -> Vec<Part> {
    let rows = problem.data.runs[0].len() / 4;
    ["a", "b", "c", "d"]
        .into_iter()
        .enumerate()
        .map(|(i, label)| {
            let place = Place { label: label.into(), run: 0, rows: i * rows..(i + 1) * rows };
            Part { label: label.into(), places: vec![place] }
        })
        .collect()
}

pub fn effects(ids: &[&str]) -> Vec<&'static dyn Effect> {
    ids.iter().map(|id| find(id).unwrap()).collect()
}

/// `baseline` with these effects, from the best of their starts.
pub fn extended(problem: &Problem<'_>, baseline: &Fit, effects: &[&'static dyn Effect]) -> Fit {
    let starts: Vec<Vec<Vec<f64>>> = effects.iter().map(|effect| effect.starts(&problem.sizes)).collect();
    let most = starts.iter().map(Vec::len).max().unwrap();
    let fits = (0..most).filter_map(|i| {
        let own = starts.iter().flat_map(|all| all[i.min(all.len() - 1)].clone());
        let start: Vec<f64> = baseline.minimum.values.iter().copied().chain(own).collect();
        refit(problem, effects, &start)
    });
    fits.min_by(|a, b| a.criterion().total_cmp(&b.criterion())).unwrap()
}

/// The baseline, then it with each of these `sets` of effects. The last one is the answer's.
pub fn selection(
    problem: &Problem<'_>,
    baseline: &Fit,
    parts: &[Part],
    sets: &[Vec<&'static dyn Effect>],
) -> Selection {
    let places: Vec<Vec<Place>> = parts.iter().map(|part| part.places.clone()).collect();
    let all = [vec![baseline.clone()], sets.iter().map(|set| extended(problem, baseline, set)).collect()];
    let visited: Vec<Visited> = all
        .into_iter()
        .flatten()
        .map(|fit| Visited {
            information: Information::new(problem, &fit, &places).unwrap(),
            log_prior: LOG_PRIOR * fit.effects.len() as f64,
            fit,
        })
        .collect();
    let last = visited.len() - 1;
    Selection { visited, baseline: 0, named: last, extended: last, fullest: last }
}
