//! What a name says beyond its special case has to be material too: friction that yields by a sixth of an encoder's count before it
//! slides is dry friction, however clear the evidence where the sensors are good.

use super::Search;
use crate::diagnosis::levels::LONGEST_HORIZON_S;
use crate::diagnosis::materiality::{closed, says_the_same, vaf_ahead};
use crate::diagnosis::rotation::all_but_the_same;
use crate::likelihood::fit::Fit;
use crate::model::effect::Effect;
use std::cell::LazyCell;

impl Search<'_, '_> {
    /// The model at `place` with special cases of its names in their places, where these close as much of the motion that `baseline`
    /// leaves, and with all that stands beside them asked again.
    pub fn simplest(&mut self, mut place: usize, baseline: usize) -> usize {
        let (problem, sections) = (self.problem, self.problem.data.places());
        let ahead = |fit: &Fit| vaf_ahead(problem, fit, &sections, LONGEST_HORIZON_S);
        // most models have no name with a special case that was visited
        let before = LazyCell::new(|| ahead(&self.visited[baseline].fit));
        let found = place;
        while let Some(simpler) = self.simpler(place, &|fit| closed(*before, ahead(fit))) {
            place = simpler;
        }
        if place != found {
            self.visit_without(place);
            self.visit_instead(place, all_but_the_same);
        }
        place
    }

    fn simpler(&self, place: usize, closed: &impl Fn(&Fit) -> f64) -> Option<usize> {
        let fit = &self.visited[place].fit;
        let simpler_than = |general: &'static dyn Effect| {
            (0..self.visited.len())
                .filter(move |&i| is_simpler(&self.visited[i].fit.effects, &fit.effects, general))
        };
        let all = LazyCell::new(|| closed(fit));
        fit.effects.iter().find_map(|&general| {
            simpler_than(general).find(|&i| says_the_same(general, *all, closed(&self.visited[i].fit)))
        })
    }
}

/// Whether `other` has special cases of `general`, and else nothing but what `all` have beside it.
fn is_simpler(other: &[&'static dyn Effect], all: &[&'static dyn Effect], general: &dyn Effect) -> bool {
    let has = |of: &[&'static dyn Effect], effect: &dyn Effect| {
        of.iter().any(|known| known.about().id == effect.about().id)
    };
    let mut kept = all.iter().filter(|effect| effect.about().id != general.about().id);
    let mut new = other.iter().filter(|effect| !has(all, **effect));
    !has(other, general)
        && kept.all(|effect| has(other, *effect))
        && new.all(|effect| general.generalises(*effect))
        && other.iter().any(|effect| general.generalises(*effect))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::{GAIN, STEP, flight, model, normal};
    use crate::diagnosis::fixture::{asked, effects, extended};
    use crate::diagnosis::selection::Candidates;
    use rand::SeedableRng as _;
    use rand_pcg::Pcg64;

    /// Steps of the simulation in one of the log.
    const FINE: u32 = 100;

    /// Ids of what is left of friction of 0.1 N m that yields by `yields` rad before it slides, told as a hysteresis, in calm air.
    fn left_of(yields: f64) -> Vec<&'static str> {
        let plant = model(GAIN, 0.06).plant;
        let mut calm = flight(1, 0.0);
        let mut random = Pcg64::seed_from_u64(1);
        let (mut rate, mut angle, mut z) = (0.0_f64, 0.0, 0.0);
        for k in 0..calm.u.len() {
            calm.q[k] = rate + 3e-3 * normal(&mut random);
            calm.theta[k] = angle + 3e-4 * normal(&mut random);
            let u = if k >= 3 { calm.u[k - 3] } else { 0.0 };
            for _ in 0..FINE {
                let step = STEP / f64::from(FINE);
                z = rate.signum() + (z - rate.signum()) * (-rate.abs() * step / yields).exp();
                let all = plant.dm_dq.unwrap() * rate + GAIN * u - 0.1 * z;
                rate += step * all / plant.inertia_kg_m2;
                angle += step * rate;
            }
        }
        asked(&calm, |problem, plain| {
            let catalogue = effects(&["coulomb_friction", "hysteresis"]);
            let candidates = Candidates::new(problem, &catalogue);
            let mut search = Search {
                problem,
                candidates,
                parts: &[],
                visited: Vec::new(),
                rounds: Vec::new(),
                progress: &|_| (),
                doing: String::new(),
            };
            let baseline = search.visit(plain.clone()).unwrap();
            let found = catalogue
                .iter()
                .map(|effect| search.visit(extended(problem, plain, &[*effect])).unwrap())
                .max()
                .unwrap();
            let left = search.simplest(found, baseline);
            search.visited[left].names()
        })
    }

    #[test]
    fn simpler_is_a_special_case_beside_the_same_rest() {
        let general = effects(&["hysteresis"])[0];
        let all = ["hysteresis", "servo_lag"];
        let simpler = |other: &[&str]| is_simpler(&effects(other), &effects(&all), general);
        assert!(simpler(&["coulomb_friction", "servo_lag"]));
        assert!(!simpler(&["coulomb_friction", "hysteresis", "servo_lag"]), "the general term stays");
        assert!(!simpler(&["coulomb_friction"]), "the rest is gone");
        assert!(!simpler(&["coulomb_friction", "servo_lag", "quadratic_drag"]), "something is new");
        assert!(!simpler(&["servo_lag"]), "no special case");
        assert!(is_simpler(
            &effects(&["coulomb_friction"]),
            &effects(&["hysteresis", "coulomb_friction"]),
            general
        ));
    }

    #[test]
    fn friction_that_yields_by_less_than_shows_is_dry_friction() {
        assert_eq!(left_of(1e-5), ["coulomb_friction"]);
        assert_eq!(left_of(0.05), ["hysteresis"]);
    }
}
