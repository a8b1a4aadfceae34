//! One side of a comparison: the fit, and each quantity with its deviation.
//!
//! The input goes in less its mean ū, so that the constant moment M₀' of the fit is small and not bound up with ∂M/∂u:
//!
//! ```text
//! M = ∂M/∂u (u − ū) + M₀' + ...      trim command  u₀ = ū − M₀'/(∂M/∂u)      constant moment  M₀ = M₀' − ∂M/∂u ū
//! ```
//!
//! A quantity f of the unknowns has the variance gᵀ C g, g its gradient, with C of the information and of the blocks, and
//!
//! ```text
//! (G−1)/G Σ_g (f_g − f̄)²,   f_g without the g-th of G spans of equal length (Tukey's jackknife; G−1 degrees of freedom)
//! ```
//!
//! The largest is taken: what drifts slowly within a recording, as trim does in wind, shows between the spans alone. For the
//! response to the input there is a fourth, the standard error of the mean of parts fitted afresh (see [`super::parts`]).

use super::Quantity;
use super::parts::{Response, responses};
use super::statistics::Measured;
use crate::catalogue::extra_delay::ExtraDelay;
use crate::dataset::{Dataset, Place, Run, pieces};
use crate::error::Error;
use crate::estimate::Estimate;
use crate::likelihood::blow_up::no_likelihood;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{Fit, fit_baseline, refit_with, settled};
use crate::likelihood::problem::Problem;
use crate::model::baseline::Baseline;
use crate::model::effect::Effect;
use crate::model::file::ModelFile;
use crate::model::pitch::Term;
use crate::recording::{InputUnit, Recording};

/// Spans of the jackknife: as many as are this long, s, twice the blocks, within these bounds.
const SPAN_S: f64 = 6.0;
const SPANS: [usize; 2] = [8, 24];
/// Size of a usual change of trim, as a share of full command.
const USUAL_TRIM: f64 = 0.05;
/// Sizes of usual changes, as shares of the quantity itself.
const USUAL_EFFECTIVENESS: f64 = 0.2;
const USUAL_DAMPING: f64 = 0.5;
const USUAL_LAG: f64 = 0.5;
const USUAL_BACKGROUND: f64 = 0.5;
/// Size of usual friction, as a share of the control moment's standard deviation.
const USUAL_FRICTION: f64 = 0.2;

/// What one side says of a quantity.
#[derive(Clone, Debug)]
pub struct Found {
    /// Which.
    pub quantity: Quantity,
    /// Name of the estimate.
    pub name: &'static str,
    /// Its unit.
    pub unit: String,
    /// Value and deviation.
    pub measured: Measured,
    /// Size of a usual change.
    pub usual: f64,
}

/// A fitted side.
pub struct Side {
    /// Every quantity.
    pub quantities: Vec<Found>,
    /// All unknowns of the fit.
    pub parameters: Vec<Estimate>,
    /// Seconds of data.
    pub seconds: f64,
}

/// The data less the mean of the input, what they are to be fitted with, and ū.
///
/// # Errors
/// Recordings that do not go together.
pub fn posed(recordings: &[Recording], model: Option<&ModelFile>) -> Result<(Dataset, Baseline, f64), Error> {
    let mut data = Dataset::new(recordings)?;
    let count = data.samples().max(1) as f64;
    let mean = data.runs.iter().flat_map(|run| &run.u).sum::<f64>() / count;
    data.runs.iter_mut().for_each(|run| run.lower_input(mean));
    let mut baseline = Baseline { delay_free: true, ..Baseline::new(model, &data)? };
    // the delay is asked again, and the model's further one is part of it
    let further = |term: &mut Term| term.effect.about().id == ExtraDelay.about().id;
    let further: f64 = baseline.terms.extract_if(.., further).map(|term| term.values[0]).sum();
    baseline.plant.delay += further;
    Ok((data, baseline, mean))
}

impl Side {
    /// Fits `recordings`, starting from `model`, with dry friction where that is asked for; `notes` are added to what is noticed.
    ///
    /// # Errors
    /// Recordings that do not go together, or no finite likelihood.
    pub fn new(
        recordings: &[Recording],
        model: Option<&ModelFile>,
        friction: bool,
        notes: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let (data, baseline, mean) = posed(recordings, model)?;
        notes.extend(data.notes(recordings));
        let problem = &Problem::new(&data, &baseline, &[]);
        let refuse = || no_likelihood(problem);
        let fit = fitted(problem, friction).ok_or_else(refuse)?;
        let spans = spans(problem.data);
        let information = Information::new(problem, &fit, &spans).ok_or_else(refuse)?;
        let coordinates = problem.coordinates(&fit.effects);
        let (values, deviations) = (&fit.minimum.values, information.deviations(&fit.minimum.values));
        let parameters = coordinates.iter().zip(values).zip(deviations);
        let parameters =
            parameters.map(|((c, &value), d)| Estimate::new(&c.name, &c.unit, value, d, c.bounds)).collect();
        let seconds = problem.data.runs.iter().map(|run| run.len() as f64 * run.step).sum();
        Ok(Self {
            quantities: quantities(
                problem,
                &fit,
                (&information, &spans),
                &responses(recordings, model),
                mean,
                friction,
            ),
            parameters,
            seconds,
        })
    }

    /// ∂M/∂u.
    pub fn gain(&self) -> Measured {
        let found = self.quantities.iter().find(|found| found.quantity == Quantity::Effectiveness);
        found.map_or(Measured { value: 0.0, deviation: f64::INFINITY, freedom: f64::INFINITY }, |found| {
            found.measured
        })
    }

    /// Whether the craft answers to the input at all: the 95 % interval of ∂M/∂u does not hold zero.
    pub fn responds(&self) -> bool {
        let [low, high] = self.gain().estimate("dM_du", "").ci95;
        low > 0.0 || high < 0.0
    }
}

/// The baseline with a constant moment, a lag and, where asked, friction.
pub fn fitted(problem: &Problem<'_>, friction: bool) -> Option<Fit> {
    let plain = fit_baseline(problem)?;
    let wanted = ["trim_offset", "servo_lag"].into_iter().chain(friction.then_some("coulomb_friction"));
    let effects = problem.baseline.missing(wanted);
    let most = effects.iter().map(|effect| effect.starts(&problem.sizes).len()).max().unwrap_or(1);
    // the range of a lag ends above zero: a servo without one is another model
    let prompt: Vec<&'static dyn Effect> =
        effects.iter().copied().filter(|effect| effect.about().id != "servo_lag").collect();
    let fits = (0..most)
        .filter_map(|start| refit_with(problem, &plain, &effects, start))
        .chain(refit_with(problem, &plain, &prompt, 0));
    let best = fits.min_by(|a, b| a.criterion().total_cmp(&b.criterion()))?;
    Some(settled(problem, best))
}

/// Equal spans of all rows, in order.
fn spans(data: &Dataset) -> Vec<Vec<Place>> {
    let all = data.samples();
    let seconds: f64 = data.runs.iter().map(|run| run.len() as f64 * run.step).sum();
    let count = ((seconds / SPAN_S) as usize).clamp(SPANS[0], SPANS[1]);
    let span = |k: usize| {
        let place = |(run, rows)| Place { label: format!("span {}", k + 1), run, rows };
        pieces(data.runs.iter().map(Run::len), k * all / count..(k + 1) * all / count).map(place).collect()
    };
    (0..count).map(span).collect()
}

/// Place of the first parameter of the effect called `id`, added or the baseline's own.
fn place(problem: &Problem<'_>, fit: &Fit, id: &str) -> Option<usize> {
    let mut at = problem.known_range().start;
    for term in &problem.baseline.terms {
        if term.effect.about().id == id {
            return Some(at);
        }
        at += term.values.len();
    }
    fit.range_of(problem, id).map(|range| range.start)
}

/// Places of ∂M/∂q, ∂M/∂u and the delay among the unknowns.
const DAMPING: usize = 0;
const GAIN: usize = 1;
const DELAY: usize = 2;

impl Response {
    /// That of a fit.
    pub fn of(problem: &Problem<'_>, fit: &Fit) -> Self {
        let values = &fit.minimum.values;
        let lag = place(problem, fit, "servo_lag").map_or(0.0, |lag| values[lag]);
        Self { gain: values[GAIN], damping: values[DAMPING], late: values[DELAY] + lag }
    }
}

fn quantities(
    problem: &Problem<'_>,
    fit: &Fit,
    (information, spans): (&Information, &[Vec<Place>]),
    parts: &[Response],
    mean: f64,
    friction: bool,
) -> Vec<Found> {
    let (values, sizes) = (&fit.minimum.values, &problem.sizes);
    let moment = if problem.baseline.plant.inertia == 1.0 { "rad/s²" } else { "N m" };
    let per = |unit: &str| if unit == "1" { moment.to_owned() } else { format!("{moment}/{unit}") };
    let input = problem.data.input_unit;
    let measured = |of: &dyn Fn(&[f64]) -> f64| measured((information, spans.len()), values, of);
    let mut all = Vec::new();
    let mut add = |quantity, name, unit: &str, measured: Measured, usual: f64| {
        all.push(Found { quantity, name, unit: unit.to_owned(), measured, usual });
    };
    if let Some(m0) = place(problem, fit, "trim_offset") {
        let command = |v: &[f64]| mean - v[m0] / v[GAIN];
        let constant = |v: &[f64]| v[m0] - v[GAIN] * mean;
        let full = match input {
            InputUnit::Normalised => Some(1.0),
            InputUnit::Percent => Some(100.0),
            _ => None,
        };
        match full {
            Some(full) => {
                let usual = USUAL_TRIM * full;
                add(Quantity::Trim, "trim_command", input.symbol(), measured(&command), usual);
            }
            None => {
                let usual = values[GAIN].abs() * sizes.u;
                add(Quantity::Trim, "trim_moment", moment, measured(&constant), usual);
            }
        }
    }
    let by_parts = |of: fn(&Response) -> f64| parts.iter().map(of).collect::<Vec<f64>>();
    let gain = measured(&|v| v[GAIN]).or_spread(&by_parts(|part| part.gain));
    add(Quantity::Effectiveness, "dM_du", &per(input.symbol()), gain, USUAL_EFFECTIVENESS * gain.value.abs());
    let damping = measured(&|v| v[DAMPING]).or_spread(&by_parts(|part| part.damping));
    let unit = if moment == "N m" { "N m s/rad" } else { "1/s" };
    add(Quantity::Damping, "dM_dq", unit, damping, USUAL_DAMPING * damping.value.abs());
    let lag = place(problem, fit, "servo_lag");
    let late = measured(&|v| v[DELAY] + lag.map_or(0.0, |lag| v[lag]));
    let late = late.or_spread(&by_parts(|part| part.late));
    add(Quantity::LagAndDelay, "lag_and_delay", "s", late, USUAL_LAG * late.value.max(sizes.step));
    if let Some(mc) = place(problem, fit, "coulomb_friction").filter(|_| friction) {
        add(
            Quantity::Friction,
            "Mc",
            moment,
            measured(&|v| v[mc]),
            USUAL_FRICTION * values[GAIN].abs() * sizes.u,
        );
    }
    if let Some(background) = background(problem, fit, spans) {
        add(Quantity::Background, "background", moment, background, USUAL_BACKGROUND * background.value);
    }
    all
}

/// A quantity with the largest of its deviations.
fn measured(
    (information, spans): (&Information, usize),
    values: &[f64],
    of: &dyn Fn(&[f64]) -> f64,
) -> Measured {
    let value = of(values);
    let gradient: Vec<f64> = (0..values.len())
        .map(|i| {
            let step = 1e-5 * values[i].abs().max(1e-6);
            let at = |h: f64| {
                let mut moved = values.to_vec();
                moved[i] += h;
                of(&moved)
            };
            (at(step) - at(-step)) / (2.0 * step)
        })
        .collect();
    let known = information.deviation_along(values, &gradient);
    let left: Vec<f64> = (0..spans).map(|span| of(&information.without(span, values, |_| false))).collect();
    let mean = left.iter().sum::<f64>() / spans as f64;
    let spread = left.iter().map(|f| (f - mean).powi(2)).sum::<f64>();
    let jackknife = ((spans - 1) as f64 / spans as f64 * spread).sqrt();
    if !known.is_finite() || jackknife <= known {
        Measured { value, deviation: known, freedom: f64::INFINITY }
    } else {
        Measured { value, deviation: jackknife, freedom: (spans - 1) as f64 }
    }
}

/// Standard deviation of the background moment, with the spread of its logarithm between the spans.
fn background(problem: &Problem<'_>, fit: &Fit, spans: &[Vec<Place>]) -> Option<Measured> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let mut moments: Vec<Vec<f64>> = problem.data.runs.iter().map(|run| vec![0.0; run.len()]).collect();
    let visit = |run: usize, k: usize, point: &crate::model::pitch::Point| {
        moments[run][k] = unpacked.disturbance.moment(&point.x);
    };
    problem.track(&unpacked, visit, &mut |_, _| {})?;
    let power = |places: &[Place]| {
        let rows = places.iter().flat_map(|p| p.rows.clone().map(move |k| (p.run, k)));
        let counted =
            rows.filter(|&(run, k)| problem.counted[run][k]).map(|(run, k)| moments[run][k].powi(2));
        let (sum, count) = counted.fold((0.0, 0_usize), |(sum, count), m| (sum + m, count + 1));
        (count > 0 && sum > 0.0).then(|| sum / count as f64)
    };
    let logs: Vec<f64> = spans.iter().filter_map(|span| Some(0.5 * power(span)?.ln())).collect();
    let count = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / count;
    let spread = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>();
    let value = power(&spans.concat())?.sqrt();
    let deviation = value * (spread / (count * (count - 1.0))).sqrt();
    (count > 2.0).then_some(Measured { value, deviation, freedom: count - 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_that_may_as_well_be_zero_is_no_response() {
        let side = |value: f64, deviation: f64| {
            let measured = Measured { value, deviation, freedom: f64::INFINITY };
            let gain = Found {
                quantity: Quantity::Effectiveness,
                name: "dM_du",
                unit: "N m/unit".into(),
                measured,
                usual: 1.0,
            };
            Side { quantities: vec![gain], parameters: Vec::new(), seconds: 60.0 }
        };
        assert!(side(383.0, 100.0).responds() && side(-383.0, 100.0).responds());
        assert!(!side(383.0, 760.0).responds() && !side(383.0, f64::INFINITY).responds());
    }
}
