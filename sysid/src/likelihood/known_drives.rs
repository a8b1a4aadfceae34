//! What drives the motion, kept: of the columns of a Jacobian only those of the delay and of the blades' terms change it.

use crate::dataset::Run;
use crate::model::pitch::{Drive, PitchModel};
use std::sync::{Arc, Mutex, PoisonError};

/// As many are kept of a run: a Jacobian's common one, and that of the column at hand.
const KEPT: usize = 2;

/// The drives asked for last, of models with the same kinds of terms.
#[derive(Default)]
pub struct KnownDrives(Mutex<Vec<Known>>);

struct Known {
    run: usize,
    driven_by: Vec<f64>,
    drives: Arc<Vec<Drive>>,
}

impl KnownDrives {
    /// The drives of `model` over the first `rows` of `run`, the `index`-th of the data.
    pub fn of(&self, model: &PitchModel<'_>, index: usize, run: &Run, rows: usize) -> Arc<Vec<Drive>> {
        let driven_by = model.driven_by();
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut kept = kept();
            if let Some(place) = kept.iter().position(|k| k.run == index && k.driven_by == driven_by) {
                let known = kept.remove(place);
                let drives = known.drives.clone();
                kept.push(known);
                return drives;
            }
        }
        let drives = Arc::new(model.drives(run, rows));
        let mut kept = kept();
        if kept.iter().filter(|known| known.run == index).count() == KEPT
            && let Some(oldest) = kept.iter().position(|known| known.run == index)
        {
            kept.remove(oldest);
        }
        kept.push(Known { run: index, driven_by, drives: drives.clone() });
        drives
    }
}

#[cfg(test)]
mod tests {
    use crate::catalogue::find;
    use crate::diagnosis::data_checks::fixture::{GAIN, fitted, flight, model};

    #[test]
    fn what_is_kept_changes_no_bit() {
        fitted(&flight(3, 0.0).recording(), &model(GAIN, 0.06), |_, problem, fit| {
            let effects = ["servo_lag", "coulomb_friction"].map(|id| find(id).unwrap());
            let kept = problem.prediction_errors(&effects);
            let start = [&fit.minimum.values[..], &[0.04, 0.1]].concat();
            for moved in (0..start.len()).chain((0..start.len()).rev()) {
                let mut values = start.clone();
                values[moved] *= 1.01;
                assert_eq!(kept(&values), problem.errors_of(&problem.unpack(&effects, &values)), "{moved}");
            }
        });
    }
}
