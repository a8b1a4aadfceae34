//! Every candidate that was tried, and how much the data speak for it.

use super::posterior::{Selection, is_shape};
use crate::likelihood::problem::Problem;
use crate::model::effect::About;

/// A candidate.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What it is.
    pub about: About,
    /// Whether it has a name.
    pub named: bool,
    /// Whether it is in the model of the answer.
    pub chosen: bool,
    /// ln of the odds between the best model with it and the best without it; `None` where every model with it lets it vanish.
    pub log_odds: Option<f64>,
    /// Gain of the model that has it alone over the baseline, in 2 ln likelihood.
    pub alone: Option<f64>,
}

/// All candidates of `selection`, the most probable first; `place` is the model of the answer.
pub fn candidates(problem: &Problem<'_>, selection: &Selection, place: usize) -> Vec<Candidate> {
    let visited = &selection.visited;
    let divisor = visited[selection.fullest].divisor(problem);
    let posteriors: Vec<f64> = visited.iter().map(|v| v.log_posterior(problem, divisor)).collect();
    let mut all: Vec<Candidate> = Vec::new();
    for effect in visited.iter().flat_map(|v| &v.fit.effects).filter(|e| !e.is_background()) {
        let about = effect.about();
        if all.iter().any(|known| known.about.id == about.id) {
            continue;
        }
        let best = |with: bool| {
            let own = visited.iter().zip(&posteriors);
            let own = own.filter(|(v, _)| v.fit.position(about.id).is_some() == with).map(|(_, p)| *p);
            own.fold(f64::NEG_INFINITY, f64::max)
        };
        let odds = best(true) - best(false);
        let only = visited.iter().find(|v| v.fit.ids() == [about.id]);
        all.push(Candidate {
            named: !is_shape(*effect),
            chosen: visited[place].fit.position(about.id).is_some(),
            log_odds: odds.is_finite().then_some(odds),
            alone: only.map(|v| visited[selection.baseline].fit.criterion() - v.fit.criterion()),
            about,
        });
    }
    let rank = |c: &Candidate| c.log_odds.unwrap_or(f64::NEG_INFINITY);
    all.sort_by(|a, b| rank(b).total_cmp(&rank(a)).then(a.about.id.cmp(b.about.id)));
    all
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{asked, effects, flight_with, quarters, selection};
    use super::*;

    #[test]
    fn what_is_there_leads() {
        asked(&flight_with(1, |_, _, theta| -1.5 * theta.sin()), |problem, baseline| {
            let sets = [effects(&["coulomb_friction"]), effects(&["gravity_stiffness"])];
            let all = selection(problem, baseline, &quarters(problem), &sets);
            let found = candidates(problem, &all, all.named);
            assert_eq!(found[0].about.id, "gravity_stiffness");
            assert!(found[0].chosen && found[0].named && found[0].log_odds.unwrap() > 5.0);
            let gained = baseline.criterion() - all.visited[all.named].fit.criterion();
            assert!((found[0].alone.unwrap() - gained).abs() < 1e-9, "{:?}", found[0]);
            let other = found.iter().find(|c| c.about.id == "coulomb_friction").unwrap();
            assert!(!other.chosen && other.log_odds.is_none_or(|odds| odds < 0.0), "{other:?}");
        });
    }
}
