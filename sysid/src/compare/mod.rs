//! What changed on a craft between two recordings of it.
//!
//! On either side the grey box is fitted by maximum likelihood in innovations form, which feedback does not bend, with a
//! constant moment and a first-order lag of the servo beside plant, delay and coloured background. Each quantity is then a
//! function of the unknowns, with a deviation that is the largest of that of the information, that of the scores of
//! blocks of 3 s, and that of a jackknife over spans of the recording (see [`side`]), and for the response to the input of a fourth,
//! between parts fitted afresh (see [`parts`]). The difference is judged as
//! [`statistics`] says, all quantities of one comparison together at one level.
//!
//! The predictor sees ∂M/∂u and ∂M/∂q relative to the inertia alone: a heavier craft looks like weaker rotors with less
//! damping, and no recording of the same loop tells the two apart.

pub mod parts;
pub mod side;
pub mod statistics;

use crate::dataset::Dataset;
use crate::error::Error;
use crate::estimate::{Estimate, per_inertia};
use crate::model::baseline::ASSUMED;
use crate::model::file::ModelFile;
use crate::progress::Progress;
use crate::recording::Recording;
use serde::Serialize;
use side::Side;
use statistics::{Difference, Verdict, judge};

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// The command that holds the craft in trim, or where the input is no share of a full command, the constant moment.
    Trim,
    /// ∂M/∂u.
    Effectiveness,
    /// ∂M/∂q.
    Damping,
    /// Delay and time constant of the servo's lag together: data seldom part them.
    LagAndDelay,
    /// Dry friction.
    Friction,
    /// Standard deviation of the background moment; the air's, not the craft's.
    Background,
}

impl Quantity {
    /// Whether it belongs to the response to the input, which a closed loop can turn into the controller's.
    fn is_response(self) -> bool {
        matches!(self, Self::Effectiveness | Self::Damping | Self::LagAndDelay)
    }
}

/// One quantity on both sides.
#[derive(Clone, Debug, Serialize)]
pub struct Change {
    /// Which.
    pub quantity: Quantity,
    /// Before.
    pub before: Estimate,
    /// After.
    pub after: Estimate,
    /// After less before.
    pub difference: Estimate,
    /// What the data say of it.
    #[serde(flatten)]
    pub judged: Difference,
}

/// The answer for one axis.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Name and version of the form of the answer.
    pub schema: &'static str,
    /// Every quantity.
    pub changes: Vec<Change>,
    /// All that was estimated before, and after.
    pub parameters: [Vec<Estimate>; 2],
    /// Seconds that were used of before and after.
    pub seconds: [f64; 2],
    /// Whether a model gave the inertia; without it moments are angular accelerations.
    pub inertia_known: bool,
    /// What was noticed about the recordings, and what was assumed.
    pub notes: Vec<String>,
}

impl Comparison {
    /// The quantities with this verdict.
    pub fn with(&self, verdict: Verdict) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(move |change| change.judged.verdict == verdict)
    }
}

/// Compares recordings of one axis of one craft; `model` starts both fits and gives the inertia, `friction` asks for dry
/// friction too. `progress` is told what is being done.
///
/// # Errors
/// Recordings that do not go together, inputs of different units, or a side without a finite likelihood.
///
/// ```
/// # use sysid::recording::{Recording, parse};
/// # let flown = |push: f64| -> Result<Recording, sysid::error::Error> {
/// #     let (mut text, mut q) = (String::from("t_s,u_N_m,q_rad_s\n"), 0.0);
/// #     for k in 0..1500 {
/// #         let u = if (k / 17 + k / 41) % 2 == 0 { 0.1 } else { -0.1 };
/// #         let noise = f64::from((k * 7919 + 13) % 1009) / 1009.0 - 0.5;
/// #         text.push_str(&format!("{:.2},{u},{}\n", 0.02 * f64::from(k), q + 0.01 * noise));
/// #         q += 0.02 * (10.0 * (u + push) - 2.0 * q);
/// #     }
/// #     parse("flight.csv", text.as_bytes(), &Default::default())
/// # };
/// use sysid::compare::{Quantity, compare, statistics::Verdict};
/// let (before, after) = (flown(0.0)?, flown(0.05)?);
/// let comparison = compare(&[before], &[after], None, false, &|_step| {})?;
/// let trim = comparison.changes.iter().find(|change| change.quantity == Quantity::Trim).unwrap();
/// assert_eq!(trim.judged.verdict, Verdict::Changed);
/// # Ok::<(), sysid::error::Error>(())
/// ```
pub fn compare(
    before: &[Recording],
    after: &[Recording],
    model: Option<&ModelFile>,
    friction: bool,
    progress: &Progress<'_>,
) -> Result<Comparison, Error> {
    let mut notes = Vec::new();
    let sides = [("before", before), ("after", after)];
    // both at once: units and channels have to agree
    Dataset::new(&[before, after].concat())?;
    let mut found = Vec::with_capacity(2);
    for (name, recordings) in sides {
        progress(format!("fitting {name}").as_str().into());
        let mut noticed = Vec::new();
        found.push(Side::new(recordings, model, friction, &mut noticed)?);
        notes.extend(noticed.into_iter().map(|note| format!("{name}: {note}")));
    }
    if model.is_none() {
        notes.push(ASSUMED.into());
    }
    let inertia_known = model.is_some_and(|model| !model.is_per_inertia());
    let [before, after] = [&found[0], &found[1]];
    let turned = before.gain().value * after.gain().value < 0.0;
    let unseen: Vec<&str> =
        found.iter().zip(sides).filter(|(side, _)| !side.responds()).map(|(_, (name, _))| name).collect();
    if !unseen.is_empty() {
        notes.push(format!(
            "{}: the interval of dM/du holds zero: what does not answer to the input has no effectiveness, damping, lag or delay to \
             compare; excite the axis, or give with --model what moves it beside the input, as diagnose --out-model writes it",
            unseen.join(" and ")
        ));
    }
    if turned {
        notes.push(
            "dM/du has another sign after than before: where the loop is closed that is the controller's answer to the motion, \
             not the craft's to the input; excite the axis in flight, and compare those stretches"
                .into(),
        );
    }
    let told = !turned && unseen.is_empty();
    let compared: Vec<(Quantity, [statistics::Measured; 2], f64)> = before
        .quantities
        .iter()
        .zip(&after.quantities)
        .map(|(b, a)| {
            let pair = if !told && b.quantity.is_response() {
                [b, a].map(|found| statistics::Measured { deviation: f64::INFINITY, ..found.measured })
            } else {
                [b.measured, a.measured]
            };
            (b.quantity, pair, 0.5 * (b.usual + a.usual))
        })
        .collect();
    let judged = judge(&compared.iter().map(|(_, pair, usual)| (*pair, *usual)).collect::<Vec<_>>());
    let changes = compared.into_iter().zip(judged).zip(&before.quantities).map(
        |(((quantity, [b, a], _), judged), q)| {
            let estimate = |value: statistics::Measured| value.estimate(q.name, &q.unit);
            Change {
                quantity,
                before: estimate(b),
                after: estimate(a),
                difference: estimate(b.to(&a)),
                judged,
            }
        },
    );
    Ok(Comparison {
        schema: "pitchid.comparison/1",
        changes: changes.collect(),
        parameters: [before, after].map(|side| of_side(side, inertia_known)),
        seconds: [before.seconds, after.seconds],
        inertia_known,
        notes,
    })
}

/// What was estimated of one side, moments per unit inertia where that is not known.
fn of_side(side: &Side, inertia_known: bool) -> Vec<Estimate> {
    let told = |parameter: &Estimate| match inertia_known {
        true => parameter.clone(),
        false => Estimate { unit: per_inertia(&parameter.unit), ..parameter.clone() },
    };
    side.parameters.iter().map(told).collect()
}
