//! Why a model has no finite likelihood: where its simulation leaves every bound, and by which value.

use super::problem::Problem;
use crate::error::{Error, ErrorKind};
use crate::legal::plain;
use crate::model::baseline::Baseline;
use crate::model::plant::Plant;

/// Strength of the background with which the model is run, as a share of [`Problem::noise_start`]'s unit.
const STRENGTH: f64 = 3.0;

/// The error where no fit of the model in `problem` has a finite likelihood.
pub fn no_likelihood(problem: &Problem<'_>) -> Error {
    let Some(place) = place(problem, problem.baseline) else {
        let help =
            "check that the axis is excited, the units of the columns, and the values of the model file";
        return Error::new(ErrorKind::Numerical, "the model has no finite likelihood on these data", help);
    };
    let (culprit, help) = match culprit(problem) {
        Some(value) => {
            (format!("; with another {value} it does not"), "correct that value in the model file")
        }
        None => (String::new(), "check the values of the model file and the units of the columns"),
    };
    Error::new(ErrorKind::Numerical, format!("the simulation of the model blows up {place}{culprit}"), help)
}

/// Where the motion of a baseline leaves every bound, in words; `None` where it does not.
fn place(problem: &Problem<'_>, baseline: &Baseline) -> Option<String> {
    let mut own = Problem::new(problem.data, baseline, &[]);
    own.sizes = problem.sizes;
    let values = [own.plant_start(), own.noise_start(STRENGTH)].concat();
    let unpacked = own.unpack(&[], &values);
    let mut last = None;
    match own.track(&unpacked, |run, row, _| last = Some((run, row)), &mut |_, _| {}) {
        Some(()) => None,
        None => Some(last.map_or("before its first step".to_owned(), |(run, row)| {
            let run = &own.data.runs[run];
            format!("at step {} ({:.2} s)", row + 1, run.time(row))
        })),
    }
}

/// The value by which it does: the first effect without which it does not, or value of the plant with that of the data instead.
fn culprit(problem: &Problem<'_>) -> Option<String> {
    let baseline = problem.baseline;
    let stays = |other: &Baseline| place(problem, other).is_none();
    for (i, term) in baseline.terms.iter().enumerate() {
        let mut without = baseline.clone();
        without.terms.remove(i);
        if stays(&without) {
            let parameters = term.effect.parameters(&problem.sizes);
            let values: Vec<String> = parameters
                .iter()
                .zip(&term.values)
                .map(|(p, value)| format!("{} = {}", p.name, plain(*value)))
                .collect();
            return Some(format!("{} ({})", term.effect.about().id, values.join(", ")));
        }
    }
    let plant = baseline.plant;
    let found = Baseline::from_data(problem.data).plant;
    let mount = plant.mount.map(|mount| {
        let told = format!("mount (k = {}, c = {}, J = {})", mount.stiffness, mount.damping, mount.inertia);
        (told, Plant { mount: None, ..plant })
    });
    let others = [
        (
            format!("dM_dq_N_m_s than {}", plain(plant.dm_dq)),
            Plant { dm_dq: found.dm_dq * plant.inertia, ..plant },
        ),
        (
            format!("dM_du_N_m than {}", plain(plant.dm_du)),
            Plant { dm_du: found.dm_du * plant.inertia, ..plant },
        ),
    ];
    let all = mount.into_iter().chain(others);
    let mut staying = all.filter(|(_, other)| stays(&Baseline { plant: *other, ..baseline.clone() }));
    staying.next().map(|(told, _)| told)
}
