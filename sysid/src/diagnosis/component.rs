//! What the data say of a term with that term taken out of the model: component plus residual.
//!
//! The model without the term, all else as it was fitted, leaves the innovations
//!
//! ```text
//! e = H m + ε
//! ```
//!
//! m the moment that the term stands for, H the predictor's response to a moment, ε white (Kailath, 1968). With
//! m = Σ β_j f_j, f_j = 1 in the j-th class of a signal, the β_j are found by generalised least squares: no shape is assumed
//! of m, and the estimate is no filtered one, so that a step stays a step (partial residuals: Ezekiel, 1924; Larsen and
//! McCleary, Technometrics 14, 1972). Beside them stands what the term itself makes of the same rows.

mod bins;
mod regression;
mod step_response;

use super::adequacy::features::whiten;
use super::adequacy::left::{white, whitening};
use crate::dataset::Run;
use crate::likelihood::evidence::BLOCK_S;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::{Problem, Unpacked};
use crate::model::effect::{About, Picture, Signal};
use crate::model::innovation_filter::InnovationFilter;
use crate::model::pitch::{Output, Part, Point};
use crate::model::plant::{Q, STATES, THETA};
use bins::{FINE, class, edges, first_edges, resolved};
use regression::Regression;

/// What the data say of one term.
#[derive(Clone, Debug)]
pub struct Component {
    /// The term.
    pub about: About,
    /// What is drawn over what.
    pub picture: Picture,
    /// Unit of the input.
    pub input_unit: &'static str,
    /// Whether it is told as what is left beside the names, and not as what is missing.
    pub left: bool,
    /// The curves: two where the directions of the motion are told apart (rising, falling), else one.
    pub branches: Vec<Branch>,
}

/// One curve.
#[derive(Clone, Debug, Default)]
pub struct Branch {
    /// By class of the signal: its mean, what the data say there, and the standard error of that.
    pub data: Vec<[f64; 3]>,
    /// What the model has there.
    pub with: Vec<[f64; 2]>,
    /// What it has there without the term.
    pub without: Vec<[f64; 2]>,
}

/// What is known of one row before the next is measured.
struct Row {
    signal: f64,
    branch: usize,
    /// What multiplies the coefficient of the class: 1, the command or the rate.
    weight: f64,
    /// What the term adds there.
    part: f64,
}

/// One run with the term taken out.
struct Stretch<'a> {
    run: &'a Run,
    counted: &'a [bool],
    filter: InnovationFilter,
    /// Innovations without the term.
    errors: Vec<Output>,
    rows: Vec<Row>,
}

/// Every term of `fit` that can be drawn; none of those without which the model diverges, or that the data do not tell.
pub fn components(problem: &Problem<'_>, fit: &Fit) -> Vec<Component> {
    (0..fit.effects.len()).filter_map(|index| component(problem, fit, index)).collect()
}

/// What the data say of the `index`-th term of `fit`.
fn component(problem: &Problem<'_>, fit: &Fit, index: usize) -> Option<Component> {
    let effect = fit.effects[index];
    let picture = effect.picture()?;
    let with = problem.unpack(&fit.effects, &fit.minimum.values);
    let stretches = stretches(problem, &with, problem.baseline.terms.len() + index, picture)?;
    let whitening = whitening(&fit.minimum.residuals);
    let plant = &with.plant;
    let branches = match picture {
        Picture::StepResponse => vec![step_response::branch(&stretches, plant, &whitening)?],
        Picture::Gain(_) => by_class(&stretches, picture, &whitening, plant.dm_du)?,
        Picture::Damping(_) => by_class(&stretches, picture, &whitening, plant.dm_dq)?,
        _ => by_class(&stretches, picture, &whitening, 0.0)?,
    };
    let input_unit = problem.data.input_unit.symbol();
    Some(Component { about: effect.about(), picture, input_unit, left: false, branches })
}

/// Every run by the model `with` the term and by the model without it; `index` is the term's place among all terms.
fn stretches<'a>(
    problem: &'a Problem<'_>,
    with: &Unpacked,
    index: usize,
    picture: Picture,
) -> Option<Vec<Stretch<'a>>> {
    let mut terms = with.terms.clone();
    let id = terms.remove(index).effect.about().id;
    let without = Unpacked { terms, ..*with };
    let of_run = |(run, counted): (&'a Run, &'a Vec<bool>)| {
        let (full, less) = (problem.model(with, run.step)?, problem.model(&without, run.step)?);
        let (gains, fewer) = (full.gain(&with.disturbance, run)?, less.gain(&with.disturbance, run)?);
        let filter = less.innovation_filter(&fewer, run);
        let errors = less.innovations(run, &fewer, run.len(), |_, _| {})?;
        let mut rows: Vec<Row> = Vec::with_capacity(run.len());
        let driven = [&full.driven(run), &less.driven(run)];
        full.innovations(run, &gains, run.len(), |k, point| {
            if let Some(part) = full.part(&less, id, point, driven, k) {
                let moved = part.next.x[THETA] - point.x[THETA];
                let falls = picture == Picture::Loop && moved < 0.0;
                let command = filter.command(run, k);
                rows.push(row(picture, run, k, (point, &part), command, usize::from(falls)));
            }
        })?;
        let sound =
            rows.len() == run.len() && rows.iter().all(|r| r.part.is_finite() && r.signal.is_finite());
        sound.then_some(Stretch { run, counted, filter, errors, rows })
    };
    problem.data.runs.iter().zip(&problem.counted).map(of_run).collect()
}

fn row(
    picture: Picture,
    run: &Run,
    k: usize,
    (point, part): (&Point, &Part),
    command: f64,
    branch: usize,
) -> Row {
    // A moment acts between two rows, an addition to the measurement shows at the second.
    let at_the_end = matches!(picture, Picture::Measured(_));
    let of_state = |i: usize| {
        if at_the_end { part.next.x[i] } else { 0.5 * (point.x[i] + part.next.x[i]) }
    };
    let beside = |column: &Option<Vec<f64>>| {
        let row = if at_the_end { k + 1 } else { k };
        column.as_ref().and_then(|c| c.get(row).or(c.last())).copied().unwrap_or(0.0)
    };
    let signal = match picture {
        Picture::StepResponse => 0.0,
        Picture::Loop => of_state(THETA),
        Picture::Moment(signal)
        | Picture::Gain(signal)
        | Picture::Damping(signal)
        | Picture::Measured(signal) => match signal {
            Signal::Rate => of_state(Q),
            Signal::Angle => of_state(THETA),
            Signal::Command => command,
            Signal::Time => run.time(k) + 0.5 * run.step,
            Signal::RollRate => beside(&run.beside.roll_rate),
            Signal::RollCommand => beside(&run.beside.roll_command),
            Signal::Thrust => beside(&run.beside.thrust),
            Signal::Voltage => beside(&run.beside.voltage),
        },
    };
    let weight = match picture {
        Picture::Gain(_) => command,
        Picture::Damping(_) => of_state(Q),
        _ => 1.0,
    };
    Row { signal, branch, weight, part: if at_the_end { part.measured } else { part.moment } }
}

/// The rows of which the next one counts.
fn counted_rows<'s>(stretches: &'s [Stretch<'_>]) -> impl Iterator<Item = &'s Row> {
    stretches
        .iter()
        .flat_map(|s| s.rows.iter().zip(s.counted.iter().skip(1)).filter(|(_, c)| **c).map(|(r, _)| r))
}

/// Coefficients by class of the signal, beside the term's own; `before` is what the model has without the term.
fn by_class(
    stretches: &[Stretch<'_>],
    picture: Picture,
    whitening: &[f64; 3],
    before: f64,
) -> Option<Vec<Branch>> {
    let count = if picture == Picture::Loop { 2 } else { 1 };
    let mut classes: Vec<(usize, Vec<f64>)> = Vec::new();
    let mut branches = vec![Branch::default(); count];
    let mut size: f64 = 0.0;
    for (index, branch) in branches.iter_mut().enumerate() {
        let rows: Vec<&Row> = counted_rows(stretches).filter(|row| row.branch == index).collect();
        let values: Vec<f64> = rows.iter().map(|row| row.signal).collect();
        let fine = means(&rows, &edges(&values, FINE));
        size = fine.iter().map(|[_, part]| part.abs()).fold(size, f64::max);
        branch.with = fine.iter().map(|[x, part]| [*x, part + before]).collect();
        let ends = [fine.first(), fine.last()].into_iter().flatten();
        branch.without = ends.map(|[x, _]| [*x, before]).collect();
        classes.push((index, first_edges(&values)));
    }
    // Classes of all branches in one row, those without any value left out.
    let place = |row: &Row| {
        let others: usize = classes[..row.branch].iter().map(|(_, edges)| edges.len() + 1).sum();
        others + class(&classes[row.branch].1, row.signal)
    };
    let all: usize = classes.iter().map(|(_, edges)| edges.len() + 1).sum();
    let (mut power, mut rows) = (vec![0.0; all], vec![0.0; all]);
    let (mut sums, mut parts) = (vec![0.0; all], vec![0.0; all]);
    for row in counted_rows(stretches) {
        let class = place(row);
        power[class] += row.weight * row.weight;
        rows[class] += 1.0;
        sums[class] += row.signal;
        parts[class] += row.part;
    }
    let branch_of: Vec<usize> = classes.iter().flat_map(|(i, edges)| vec![*i; edges.len() + 1]).collect();
    let kept: Vec<usize> = (0..all).filter(|&class| power[class] > 0.0).collect();
    let column: Vec<Option<usize>> = (0..all).map(|class| kept.iter().position(|k| *k == class)).collect();
    let entry = matches!(picture, Picture::Measured(_));
    let sums_of = regress(stretches, kept.len(), whitening, entry, &|stretch, k, f| {
        let row = &stretch.rows[k];
        if let Some(column) = column[place(row)] {
            f[column] = row.weight;
        }
    });
    let kept_branch: Vec<usize> = kept.iter().map(|&class| branch_of[class]).collect();
    let (into, mut solution) = resolved(&sums_of, &kept_branch, size)?;
    let mut level = 0.0;
    // A constant moment is another term's, or the background's, and of an input far from zero a large one: a moment of rate or angle is
    // drawn at the level that the term has.
    if matches!(picture, Picture::Moment(Signal::Rate | Signal::Angle)) {
        let every: f64 = kept.iter().map(|&j| rows[j]).sum();
        let mut weights = vec![0.0; solution.values.len()];
        kept.iter().zip(&into).for_each(|(&j, &class)| weights[class] += rows[j] / every);
        solution = solution.about_the_mean(&weights);
        level = kept.iter().map(|&j| parts[j]).sum::<f64>() / every;
    }
    for (class, (value, error)) in solution.values.iter().zip(&solution.standard_errors).enumerate() {
        let own: Vec<usize> = (0..kept.len()).filter(|&j| into[j] == class).collect();
        let total = |of: &[f64]| own.iter().map(|&j| of[kept[j]]).sum::<f64>();
        let x = total(&sums) / total(&rows);
        branches[kept_branch[own[0]]].data.push([x, before + level + value, *error]);
    }
    Some(branches)
}

/// By class: the mean of the signal, and what the term adds per unit of the weight.
fn means(rows: &[&Row], edges: &[f64]) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 4]; edges.len() + 1];
    for row in rows {
        let [count, signal, product, square] = &mut sums[class(edges, row.signal)];
        *count += 1.0;
        *signal += row.signal;
        *product += row.weight * row.part;
        *square += row.weight * row.weight;
    }
    let full = sums.into_iter().filter(|[.., square]| *square > 0.0);
    full.map(|[count, signal, product, square]| [signal / count, product / square]).collect()
}

/// The innovations on `count` features that `fill` makes of a row; they act from there to the next as a moment, or on the
/// next row's `measured` rate.
fn regress(
    stretches: &[Stretch<'_>],
    count: usize,
    whitening: &[f64; 3],
    measured: bool,
    fill: &dyn Fn(&Stretch<'_>, usize, &mut [f64]),
) -> Regression {
    let mut sums = Regression::new(count);
    let mut f = vec![0.0; count];
    let mut shown = vec![vec![0.0; count]; 2];
    let channels = if whitening[2] > 0.0 { 2 } else { 1 };
    for (index, stretch) in stretches.iter().enumerate() {
        let Stretch { run, counted, filter, errors, .. } = stretch;
        let drive = if measured { filter.per_addition[0].scale(-1.0) } else { filter.per_moment };
        let only_angle = run.rate.is_none();
        let mut x = vec![vec![0.0; count]; STATES];
        let mut next = x.clone();
        for k in 1..run.len() {
            f.fill(0.0);
            fill(stretch, k - 1, &mut f);
            if !measured {
                filter.advance(run.is_measured(k - 1), (&drive, &f), &mut x, &mut next);
            }
            if counted[k] {
                for (shown, &state) in shown.iter_mut().zip(&filter.measured) {
                    shown.copy_from_slice(&x[state]);
                }
                if measured {
                    shown[0].iter_mut().zip(&f).for_each(|(z, f)| *z += f);
                }
                whiten(whitening, &mut shown);
                let e = errors[k];
                let e = white(whitening, &if only_angle { [e[1], 0.0] } else { e });
                let block = index << 32 | (k as f64 * run.step / BLOCK_S) as usize;
                for (z, e) in shown.iter().zip(e).take(channels) {
                    sums.add(block, z, e);
                }
            }
            if measured {
                if !run.is_measured(k) {
                    f.fill(0.0);
                }
                filter.advance(run.is_measured(k), (&drive, &f), &mut x, &mut next);
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests;
