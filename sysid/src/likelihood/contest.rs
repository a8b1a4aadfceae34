//! Two rivals on the same data: each beside the plant, which is fitted again with either.

use super::blow_up::no_likelihood;
use super::fit::{Fit, fit_baseline, refit_with};
use super::problem::Problem;
use crate::catalogue::find;
use crate::dataset::Dataset;
use crate::error::{Error, ErrorKind};
use crate::model::baseline::Baseline;
use crate::model::effect::Effect;
use crate::model::file::ModelFile;
use crate::recording::Recording;

/// What became of a contest.
#[derive(Clone, Debug)]
pub struct Contest {
    /// 2 ln of the odds of the first against the second, by the difference of their Bayesian information criteria.
    pub evidence: f64,
    /// The parameters with which each comes nearest to the data, in the order of the rivals.
    pub parameters: [Vec<(String, f64)>; 2],
}

/// Fits the plant of `model` with either of the two effects `rivals` to `recordings`, from every start that the effect has.
///
/// # Errors
/// No effect of that name, recordings that do not go together, no finite likelihood.
pub fn contest(recordings: &[Recording], model: &ModelFile, rivals: [&str; 2]) -> Result<Contest, Error> {
    let data = Dataset::new(recordings)?;
    let mut baseline = Baseline { delay_free: true, ..Baseline::from_model(model, &data)? };
    baseline.terms.retain(|term| !rivals.contains(&term.effect.about().id));
    let problem = Problem::new(&data, &baseline, &[]);
    let plain = fit_baseline(&problem).ok_or_else(|| no_likelihood(&problem))?;
    let [first, second] = rivals.map(|id| -> Result<Fit, Error> {
        let effect = find(id).ok_or_else(|| {
            let found = format!("no effect \"{id}\" that could be told from another");
            Error::new(ErrorKind::Model, found, "use an id of the catalogue (docs/catalogue.md)")
        })?;
        best(&problem, &plain, effect).ok_or_else(|| no_likelihood(&problem))
    });
    let fits = [first?, second?];
    let [a, b] = fits.each_ref().map(|fit| fit.bic(&problem));
    let parameters = fits.map(|fit| {
        let names = fit.effects[0].parameters(&problem.sizes).into_iter().map(|p| p.name.to_owned());
        names.zip(fit.minimum.values[fit.own_range(&problem, 0)].iter().copied()).collect()
    });
    Ok(Contest { evidence: b - a, parameters })
}

fn best(problem: &Problem<'_>, plain: &Fit, effect: &'static dyn Effect) -> Option<Fit> {
    let starts = 0..effect.starts(&problem.sizes).len();
    let fits = starts.filter_map(|start| refit_with(problem, plain, &[effect], start));
    fits.min_by(|a, b| a.criterion().total_cmp(&b.criterion()))
}
