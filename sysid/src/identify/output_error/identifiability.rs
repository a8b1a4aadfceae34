//! What these data can tell of the grey box, and what not: relative Cramér–Rao bounds with J unknown, with J known, and
//! of the ratios.
//!
//! ```text
//! J free: σ(ln k), σ(ln c), σ(ln J)      k = J ω²,  c = 2 ζ ω J
//! ratios: (∂M/∂q)/(I+J),  (∂M/∂u)/(I+J),  k/J_r = ω² (1 + J/I),  c/J_r = 2 ζ ω (1 + J/I),   1/J_r = 1/J + 1/I
//! ```
//!
//! J acts on the measured rate through I + J, which ∂M/∂q and ∂M/∂u make up for, and through the mode of both masses
//! against each other, which k and c make up for: only the ratios show. With J ≪ I, J_r is J.

use super::intervals::inverse;
use super::{Options, best, no_fit, problem};
use crate::error::Error;
use crate::identify::fir::Piece;
use crate::model::plant::Plant;
use crate::model::sampled::Parameter::{self, Delay, DmDq, DmDu, MountDamping, MountInertia, MountMode};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// An error beyond this share of the value leaves it undetermined.
const UNDETERMINED: f64 = 0.5;

/// One quantity's relative standard deviations, in per cent; infinite where the information is singular.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Identifiable {
    /// The quantity.
    pub name: String,
    /// With the mount's inertia J unknown.
    pub j_unknown_percent: f64,
    /// With J known.
    pub j_known_percent: f64,
}

/// What these data can tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Identifiability {
    /// ∂M/∂q, ∂M/∂u, k, c, J and the ratios.
    pub quantities: Vec<Identifiable>,
    /// In words.
    pub statement: String,
}

/// The bounds at the best fit, the mount free however `options` has it; `None` without a mount.
///
/// # Errors
/// As [`super::fit`].
pub fn identifiability(
    pieces: &[Piece],
    start: &Plant,
    options: &Options,
) -> Result<Option<Identifiability>, Error> {
    let problem = problem(pieces, start, options)?;
    let (at, _, ar, _) = best(&problem, options).ok_or_else(no_fit)?;
    let plant = problem.plant(&at.theta);
    let Some(mount) = plant.mount else { return Ok(None) };
    let mut all = vec![DmDq, DmDu];
    if options.free_delay {
        all.push(Delay);
    }
    all.extend([MountMode, MountDamping, MountInertia]);
    let free = super::Problem {
        sections: problem.sections.clone(),
        start: plant,
        coordinates: all
            .iter()
            .map(|p| super::Coordinate { parameter: *p, bounds: [f64::NEG_INFINITY, f64::INFINITY] })
            .collect(),
        ..problem
    };
    let at = free.at(&free.theta(&plant), &at.x0, &ar).ok_or_else(no_fit)?;
    let variance = at.squares / at.rows as f64;
    let n = all.len();
    let unknown = inverse(&at.hessian).map(|m| m * variance);
    let known = inverse(&at.hessian.view((0, 0), (n - 1, n - 1)).into_owned()).map(|m| m * variance);
    let percent = |weights: &[(Parameter, f64)]| {
        let weight = DVector::from_fn(n, |i, _| {
            weights.iter().filter(|(p, _)| *p == all[i]).map(|(_, w)| w).sum::<f64>()
        });
        let of = |m: &Option<DMatrix<f64>>| {
            m.as_ref().map_or(f64::INFINITY, |m| {
                let w = weight.rows(0, m.nrows());
                100.0 * (w.transpose() * m * w)[0].max(0.0).sqrt()
            })
        };
        [of(&unknown), of(&known)]
    };
    // d ln(x/(I+J)) = dx/x − J/(I+J) d ln J
    let share = mount.inertia / (plant.inertia + mount.inertia);
    let (dq, du) = (1.0 / plant.dm_dq, 1.0 / plant.dm_du);
    let quantities: Vec<Identifiable> = [
        ("∂M/∂q", vec![(DmDq, dq)]),
        ("∂M/∂u", vec![(DmDu, du)]),
        ("k", vec![(MountMode, 2.0), (MountInertia, 1.0)]),
        ("c", vec![(MountMode, 1.0), (MountDamping, 1.0), (MountInertia, 1.0)]),
        ("J", vec![(MountInertia, 1.0)]),
        ("k/J_r", vec![(MountMode, 2.0), (MountInertia, share)]),
        ("c/J_r", vec![(MountMode, 1.0), (MountDamping, 1.0), (MountInertia, share)]),
        ("(∂M/∂q)/(I+J)", vec![(DmDq, dq), (MountInertia, -share)]),
        ("(∂M/∂u)/(I+J)", vec![(DmDu, du), (MountInertia, -share)]),
    ]
    .into_iter()
    .map(|(name, weights)| {
        let [j_unknown_percent, j_known_percent] = percent(&weights);
        Identifiable { name: name.into(), j_unknown_percent, j_known_percent }
    })
    .collect();
    let statement = statement(&quantities);
    Ok(Some(Identifiability { quantities, statement }))
}

fn statement(quantities: &[Identifiable]) -> String {
    let list = |tells: bool, of: &dyn Fn(&Identifiable) -> f64, names: &[&str]| {
        quantities
            .iter()
            .filter(|q| names.contains(&q.name.as_str()) && (of(q) <= 100.0 * UNDETERMINED) == tells)
            .map(|q| {
                if of(q) < 100.0 {
                    format!("{} (± {:.2} %)", q.name, of(q))
                } else {
                    format!("{} (± more than 100 %)", q.name)
                }
            })
            .collect::<Vec<_>>()
            .join(", ")
    };
    const PARAMETERS: [&str; 5] = ["∂M/∂q", "∂M/∂u", "k", "c", "J"];
    const RATIOS: [&str; 4] = ["k/J_r", "c/J_r", "(∂M/∂q)/(I+J)", "(∂M/∂u)/(I+J)"];
    let unknown = |q: &Identifiable| q.j_unknown_percent;
    let mut text = String::from("one standard deviation, from the Cramér–Rao bound");
    let lists = [
        ("not told by these data where J is unknown", list(false, &unknown, &PARAMETERS)),
        ("told all the same", list(true, &unknown, &PARAMETERS)),
        ("told as ratios", list(true, &unknown, &RATIOS)),
        ("not even as ratios", list(false, &unknown, &RATIOS)),
        ("with J held", list(true, &|q| q.j_known_percent, &PARAMETERS[..4])),
    ];
    for (what, names) in lists.into_iter().filter(|(_, names)| !names.is_empty()) {
        text.push_str(&format!("; {what}: {names}"));
    }
    text
}
