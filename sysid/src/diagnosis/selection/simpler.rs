//! What a name says beyond its special case has to be material too: friction that yields by a sixth of an encoder's count before it
//! slides is dry friction, however clear the evidence where the sensors are good.

use super::Search;
use crate::diagnosis::materiality::{closed, is_immaterial, vaf_ahead};
use crate::likelihood::fit::Fit;
use crate::model::effect::Effect;
use std::cell::LazyCell;

impl Search<'_, '_> {
    /// The model at `place` with special cases of its names in their places, where these close as much of the motion that `baseline`
    /// leaves, and with all that stands beside them asked again.
    pub fn simplest(&mut self, mut place: usize, baseline: usize) -> usize {
        let (problem, sections) = (self.problem, self.problem.data.places());
        let ahead = |fit: &Fit| vaf_ahead(problem, fit, &sections);
        let before = ahead(&self.visited[baseline].fit);
        let found = place;
        while let Some(simpler) = self.simpler(place, &|fit| closed(before, ahead(fit))) {
            place = simpler;
        }
        if place != found {
            self.visit_without(place);
        }
        place
    }

    fn simpler(&self, place: usize, closed: &impl Fn(&Fit) -> f64) -> Option<usize> {
        let fit = &self.visited[place].fit;
        let simpler_than = |general: &'static dyn Effect| {
            (0..self.visited.len()).filter(move |&i| is_simpler(&self.visited[i].fit, fit, general))
        };
        let all = LazyCell::new(|| closed(fit));
        fit.effects.iter().find_map(|&general| {
            simpler_than(general).find(|&i| is_immaterial(general, *all, closed(&self.visited[i].fit)))
        })
    }
}

/// Whether `other` has special cases of `general`, and else nothing but what `fit` has beside it.
fn is_simpler(other: &Fit, fit: &Fit, general: &dyn Effect) -> bool {
    let id = general.about().id;
    let has = |fit: &Fit, effect: &dyn Effect| fit.position(effect.about().id).is_some();
    let mut kept = fit.effects.iter().filter(|effect| effect.about().id != id);
    let mut new = other.effects.iter().filter(|effect| !has(fit, **effect));
    !has(other, general)
        && kept.all(|effect| has(other, *effect))
        && new.all(|effect| general.generalises(*effect))
        && other.effects.iter().any(|effect| general.generalises(*effect))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::fixture::{asked, effects, extended, flight_with};
    use crate::diagnosis::selection::Candidates;
    use std::cell::Cell;

    /// Ids of what is left of friction of 0.1 N m that yields by `yields` rad before it slides, told as a hysteresis.
    fn left_of(yields: f64) -> Vec<&'static str> {
        let (z, before) = (Cell::new(0.0), Cell::new(0.0));
        let moment = |_, rate: f64, angle: f64| {
            let turned = angle - before.replace(angle);
            let end = turned.signum();
            z.set(end + (z.get() - end) * (-turned.abs() / yields).exp());
            -0.1 * z.get() * (rate.abs() / 1e-3).tanh()
        };
        asked(&flight_with(1, moment), |problem, plain| {
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
    fn friction_that_yields_by_less_than_shows_is_dry_friction() {
        assert_eq!(left_of(1e-4), ["coulomb_friction"]);
        assert_eq!(left_of(0.05), ["hysteresis"]);
    }
}
