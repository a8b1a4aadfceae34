//! What leaving an effect out costs, and the size for a given cost.
//!
//! Cost, in points of VAF: fly the aircraft; simulate the pitch rate along the recorded input, each section
//! from its true initial state, without noise and background (a) with the true model, effects included, and
//! (b) with the plain plant of eq. 9, true but for ∂M/∂q and ∂M/∂u, which are fitted to sections I and II by
//! least squares. The cost is the mean over the held-out sections III and IV of VAF(a) − VAF(b). A gust counts
//! as known in (a): it is what the plain plant misses.

use estimator_core::Section;
use rand::RngExt;
use rand::seq::SliceRandom;

use crate::aircraft::Aircraft;
use crate::effects::{Entry, Setting};
use crate::error::Error;
use crate::flight::{Flight, fly, fly_whole};
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::seeds::{Stream, generator};

const FITTED: [Section; 2] = [Section::I, Section::II];
const HELD_OUT: [Section; 2] = [Section::III, Section::IV];

/// Pitch rate of `plant` with `effects` along the input of `flight`, each section from its true initial state,
/// rad/s.
#[must_use]
pub fn simulate(plant: Plant, effects: &[Setting], seed: u64, flight: &Flight) -> Vec<f64> {
    simulate_rows(plant, effects, seed, flight, flight.rows.len())
}

fn simulate_rows(plant: Plant, effects: &[Setting], seed: u64, flight: &Flight, count: usize) -> Vec<f64> {
    let mut aircraft = Aircraft::new(plant, effects, None, seed);
    let mut last = Section::Between;
    // a model that knows of the skew knows what was really sent
    let skewed = aircraft.logged_at(1.0) != 1.0;
    let rows = flight.rows.iter().zip(&flight.states).zip(&flight.sent).take(count);
    rows.map(|((row, state), sent)| {
        if row.section != last {
            last = row.section;
            aircraft.set_state(*state);
        }
        let mut reading = aircraft.read();
        aircraft.limit(&mut reading);
        aircraft.advance(f64::from(if skewed { *sent } else { row.u_rad }));
        reading.q
    })
    .collect()
}

/// VAF = 100 max(0, 1 − var(y − ŷ) / var(y)) of one section, %; 0 for a section that is not there.
#[must_use]
pub fn vaf(flight: &Flight, simulated: &[f64], section: Section) -> f64 {
    let residuals = centred_residuals(flight, simulated, section);
    let measured = centred_residuals(flight, &vec![0.0; simulated.len()], section);
    let power = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let whole = power(&measured);
    if whole > 0.0 { 100.0 * (1.0 - power(&residuals) / whole).max(0.0) } else { 0.0 }
}

/// y − ŷ without its mean.
fn centred_residuals(flight: &Flight, simulated: &[f64], section: Section) -> Vec<f64> {
    let pairs = flight.rows.iter().zip(simulated).filter(|(row, _)| row.section == section);
    let mut residuals: Vec<f64> = pairs.map(|(row, q)| f64::from(row.q_rad_s) - q).collect();
    let mean = residuals.iter().sum::<f64>() / residuals.len().max(1) as f64;
    residuals.iter_mut().for_each(|r| *r -= mean);
    residuals
}

/// The plain plant with the ∂M/∂q and ∂M/∂u that fit sections I and II best: Gauss–Newton with step halving.
#[must_use]
pub fn refit(flight: &Flight, plant: Plant) -> Plant {
    let needed = flight.rows.iter().rposition(|row| FITTED.contains(&row.section)).map_or(0, |last| last + 1);
    let residuals = |plant: Plant| -> Vec<f64> {
        let simulated = simulate_rows(plant, &[], 0, flight, needed);
        FITTED.iter().flat_map(|&section| centred_residuals(flight, &simulated, section)).collect()
    };
    let power = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let moved = |p: Plant, [a, b]: [f64; 2]| Plant { dm_dq: p.dm_dq + a, dm_du: p.dm_du + b, ..p };
    let mut best = plant;
    let mut r = residuals(best);
    for _ in 0..8 {
        let steps = [1e-4 * plant.dm_dq.abs().max(1e-3), 1e-4 * plant.dm_du.abs().max(1e-3)];
        let slope = |step: [f64; 2], h: f64| -> Vec<f64> {
            residuals(moved(best, step)).iter().zip(&r).map(|(after, before)| (after - before) / h).collect()
        };
        let [jq, ju] = [slope([steps[0], 0.0], steps[0]), slope([0.0, steps[1]], steps[1])];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (qq, uu, qu) = (dot(&jq, &jq), dot(&ju, &ju), dot(&jq, &ju));
        let determinant = qq * uu - qu * qu;
        if determinant <= 1e-12 * qq * uu {
            break;
        }
        let (gq, gu) = (dot(&jq, &r), dot(&ju, &r));
        let newton = [(-uu * gq + qu * gu) / determinant, (qu * gq - qq * gu) / determinant];
        let better = [1.0, 0.5, 0.25, 0.125].iter().find_map(|share| {
            let trial = moved(best, newton.map(|d| share * d));
            let trial_residuals = residuals(trial);
            (power(&trial_residuals) < power(&r)).then_some((trial, trial_residuals))
        });
        let Some((trial, trial_residuals)) = better else { break };
        let gained = 1.0 - power(&trial_residuals) / power(&r);
        (best, r) = (trial, trial_residuals);
        if gained < 1e-5 {
            break;
        }
    }
    best
}

/// Points of VAF on the held-out sections that a model without the effects of `scenario` loses.
///
/// # Errors
/// As [`fly`].
pub fn cost_of_leaving_out(scenario: &Scenario) -> Result<f64, Error> {
    Ok(cost_in(scenario, &fly(scenario)?))
}

/// The same for a test that was flown already.
#[must_use]
pub fn cost_in(scenario: &Scenario, flight: &Flight) -> f64 {
    let with = simulate(scenario.plant, &scenario.effects, scenario.seed, flight);
    let without = simulate(refit(flight, scenario.plant), &[], scenario.seed, flight);
    let lost = HELD_OUT.map(|section| vaf(flight, &with, section) - vaf(flight, &without, section));
    lost.iter().sum::<f64>() / lost.len() as f64
}

/// `effect` at the size, within its usual range and with its sign, whose omission from `scenario` costs
/// `target` points, and the cost that was reached. Some effects cost more the smaller they are. Effects that the scenario has already are replaced.
///
/// # Errors
/// As [`fly`]; the target lies outside what the usual range can cost.
pub fn size_for_loss(scenario: &Scenario, effect: &Setting, target: f64) -> Result<(Setting, f64), Error> {
    let cost = |size: f64| {
        let setting = effect.resized(size);
        let mut flown = scenario.clone();
        flown.conceal(vec![setting.clone()]);
        cost_of_leaving_out(&flown).map(|cost| (setting, cost))
    };
    let entry = effect.entry();
    let [mut small, mut large] = entry.parameters[0].range;
    let (mut at_small, mut at_large) = (cost(small)?, cost(large)?);
    if at_small.1 > at_large.1 {
        (small, large, at_small, at_large) = (large, small, at_large, at_small);
    }
    if target < at_small.1 || target > at_large.1 {
        return Err(Error::Unreachable { id: entry.id, low: at_small.1, high: at_large.1, target });
    }
    let distance = |(_, cost): &(Setting, f64)| (cost - target).abs();
    let mut best = if distance(&at_small) < distance(&at_large) { at_small } else { at_large };
    // the cost is not quite monotone: another size trips the supervisor at other times
    for _ in 0..10 {
        let middle = (small * large).sqrt();
        let tried = cost(middle)?;
        if tried.1 < target {
            small = middle;
        } else {
            large = middle;
        }
        if distance(&tried) < distance(&best) {
            best = tried;
        }
        if distance(&best) < 0.05 * target {
            break;
        }
    }
    Ok(best)
}

/// `effect` at the size, among some within its usual range and with its sign, at which the test ends as it
/// should and whose omission costs nearest to `target` points; with that cost, or none where every size breaks
/// the test off. For effects whose cost is uneven in their size, or cannot reach the target.
///
/// # Errors
/// As [`fly`].
pub fn nearest_for_loss(
    scenario: &Scenario,
    effect: &Setting,
    target: f64,
) -> Result<Option<(Setting, f64)>, Error> {
    const COARSE: u32 = 5;
    const FINE: u32 = 3;
    let [small, large] = effect.entry().parameters[0].range;
    let mut tried: Vec<(f64, f64)> = Vec::new();
    let mut best: Option<(f64, f64)> = None;
    let distance = |(_, cost): (f64, f64)| (cost - target).abs();
    for step in 0..COARSE + FINE {
        let size = if step < COARSE {
            small * (large / small).powf(f64::from(step) / f64::from(COARSE - 1))
        } else {
            // between two sizes that cost less and more
            tried.sort_by(|a, b| a.0.total_cmp(&b.0));
            let around = tried.windows(2).find(|pair| (pair[0].1 < target) != (pair[1].1 < target));
            let Some(&[(below, _), (above, _)]) = around else { break };
            (below * above).sqrt()
        };
        let mut flown = scenario.clone();
        flown.conceal(vec![effect.resized(size)]);
        let Some(flight) = fly_whole(&flown)? else { continue };
        let cost = cost_in(&flown, &flight);
        tried.push((size, cost));
        if best.is_none_or(|known| distance((size, cost)) < distance(known)) {
            best = Some((size, cost));
        }
        if best.is_some_and(|known| distance(known) < 0.15 * target) {
            break;
        }
    }
    Ok(best.map(|(size, cost)| (effect.resized(size), cost)))
}

/// How much an effect is to cost.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Strength {
    /// 3 to 7 points.
    Moderate,
    /// 8 to 15 points.
    Strong,
}

impl Strength {
    /// From and to, points of VAF on held-out sections.
    #[must_use]
    pub const fn points(self) -> (f64, f64) {
        match self {
            Self::Moderate => (3.0, 7.0),
            Self::Strong => (8.0, 15.0),
        }
    }
}

/// One of the effects `ids` for `scenario`, drawn by its seed: which, with which sign, further parameters
/// (log-uniform in their range), and how many points it costs. An effect that cannot cost that much gives way
/// to the next.
///
/// # Errors
/// As [`fly`]; an unknown id; no effect reaches the strength.
pub fn draw_effect(scenario: &Scenario, ids: &[&str], strength: Strength) -> Result<(Setting, f64), Error> {
    let mut generator = generator(scenario.seed, Stream::Choice);
    let mut entries: Vec<&'static Entry> = ids.iter().map(|id| Entry::find(id)).collect::<Result<_, _>>()?;
    entries.shuffle(&mut generator);
    let (low, high) = strength.points();
    let target = generator.random_range(low..high);
    for entry in entries {
        let mut draw = |[low, high]: [f64; 2]| low * (high / low).powf(generator.random());
        let mut values: Vec<f64> = entry.parameters.iter().map(|p| draw(p.range)).collect();
        if entry.parameters[0].signed && generator.random_bool(0.5) {
            values[0] = -values[0];
        }
        match size_for_loss(scenario, &entry.setting(values), target) {
            Err(Error::Unreachable { .. }) => {}
            done => return done,
        }
    }
    Err(Error::NoneReaches { target })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Background;

    #[test]
    fn the_refit_finds_the_true_plant_when_nothing_is_concealed() {
        let plant = Plant::drawn(5);
        let background = Background::Clean;
        let scenario = Scenario { plant, background, ..Scenario::campaign(4, 0.015, 5).unwrap() };
        let flight = fly(&scenario).unwrap();
        let start = Plant { dm_dq: -0.27, dm_du: 23.0, ..plant };
        let found = refit(&flight, start);
        assert!((found.dm_dq / plant.dm_dq - 1.0).abs() < 0.05, "{found:?} {plant:?}");
        assert!((found.dm_du / plant.dm_du - 1.0).abs() < 0.03, "{found:?} {plant:?}");
    }

    #[test]
    fn concealing_nothing_costs_nothing() {
        let scenario = Scenario { background: Background::Clean, ..Scenario::campaign(4, 0.015, 2).unwrap() };
        assert!(cost_of_leaving_out(&scenario).unwrap().abs() < 0.5);
    }
}
