//! What the input does between rows that are means of several samples: known, but a cause only where the craft answers later.

use super::search::fit_one_more;
use super::selection::Candidates;
use crate::catalogue::find;
use crate::dataset::Dataset;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::progress::Progress;

/// The data with the input between thinned rows as it was, where that is news and comes before what the rows show. `first` is the
/// baseline's fit: a lag of the rotors stands in its delay, so one is fitted beside it.
pub fn known_between(problem: &Problem<'_>, first: &Fit, progress: &Progress<'_>) -> Option<Dataset> {
    let delay = first.delay(problem);
    if !problem.data.has_news_between(delay) {
        return None;
    }
    let lag: Vec<_> = find("servo_lag").into_iter().collect();
    let lag = Candidates::new(problem, &lag).named;
    let lagging = fit_one_more(problem, first, &lag, progress);
    let likelier = lagging.iter().filter(|fit| fit.bic(problem) < first.bic(problem));
    let delays = likelier.map(|fit| fit.delay(problem));
    problem.data.with_input_between(delays.fold(delay, f64::min))
}
