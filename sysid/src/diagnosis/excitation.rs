//! Whether the data can answer at all: long enough, moved by the input, above the noise.

use super::estimates::estimates;
use super::levels::{HORIZONS_S, LONGEST_HORIZON_S, SEEN, SEEN_AT_ALL, SHORTEST_S, WIDEST_GAIN_INTERVAL};
use super::materiality::vaf_ahead;
use super::past_alone::vaf_of_the_past_alone;
use super::posterior::is_shape;
use crate::dataset::{Dataset, Run};
use crate::estimate::Estimate;
use crate::identify::fir::ceiling_vaf;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::Fit;
use crate::likelihood::horizon::horizon_vaf;
use crate::likelihood::problem::Problem;

/// Share of the output, per cent, that an FIR model must explain for the input to count as seen.
const EXPLAINED_BY_ANY: f64 = 40.0;
/// Data shorter than this are told as short, s: of springs and frictions that a hundred show, three of four are missed in 3 s.
const SHORT_S: f64 = 10.0;
/// Between two gaps less than this tells nothing of how the motion goes on, s.
const STRETCH_S: f64 = 1.0;
/// Memory of that model, s.
const FIR_MEMORY_S: f64 = 1.0;

/// Length of all sections in stretches that are long enough where there are gaps, s.
fn seconds(data: &Dataset) -> f64 {
    let whole = data.runs.len() == 1;
    let places = data.places().into_iter().filter(|place| whole || is_stretch(&data.runs[place.run]));
    let lengths = places.map(|place| place.rows.len() as f64 * data.runs[place.run].step);
    // the sum of nothing is −0.0, which would be told
    lengths.fold(0.0, |all, seconds| all + seconds)
}

fn is_stretch(run: &Run) -> bool {
    run.len() as f64 * run.step >= STRETCH_S
}

/// That the data are short, where they are: what is told is told of what is strong.
pub fn is_short(data: &Dataset) -> Option<String> {
    let seconds = seconds(data);
    (seconds < SHORT_S).then(|| {
        format!(
            "{seconds:.1} s of excitation are short: what is weak does not show in them (a hundred are good)"
        )
    })
}

/// Why the data are too little before anything is fitted: too short, or a motion that never changes.
pub fn too_little(problem: &Problem<'_>) -> Option<String> {
    let seconds = seconds(problem.data);
    if seconds < SHORTEST_S {
        let runs = &problem.data.runs;
        let gaps = runs.len() > 1 && !runs.iter().all(is_stretch);
        let between = if gaps { " in stretches of a second and more between the gaps" } else { "" };
        return Some(format!(
            "The data cannot tell: {seconds:.1} s of excitation{between} are too short, at least {SHORTEST_S} s are needed (a hundred \
             are good)."
        ));
    }
    let still = |signal: &Option<Vec<f64>>| {
        signal.iter().flatten().all(|y| Some(y) == signal.iter().flatten().next())
    };
    let dead = problem.data.runs.iter().all(|run| still(&run.rate) && still(&run.angle));
    dead.then(|| "The data cannot tell: no measured motion changes.".into())
}

/// Why the data are too weak: the input is not seen ([`input_unseen`]), and nothing of the motion follows from what it was before, as
/// after a step or a release.
pub fn too_weak(problem: &Problem<'_>, baseline: &Fit, information: &Information) -> Option<String> {
    if !problem.data.input_changes() {
        return at_rest(problem, baseline);
    }
    input_unseen(problem, baseline, information).filter(|_| follows_from_before(problem) < EXPLAINED_BY_ANY)
}

/// Why the input is not seen: its effect is not known well enough to ask what is missing from it, and an unstructured model makes
/// no more of it either.
pub fn input_unseen(problem: &Problem<'_>, baseline: &Fit, information: &Information) -> Option<String> {
    let reason = gain_unknown(problem, baseline, information, false)?;
    let places = problem.data.places();
    let reached = places.iter().filter_map(|place| {
        let run = &problem.data.runs[place.run];
        let readings = place.rows.len() / run.measured_every();
        let taps = ((FIR_MEMORY_S / run.step) as usize).min(readings / 10).clamp(1, 60);
        ceiling_vaf(&run.u[place.rows.clone()], problem.data.judged(place), taps).ok()
    });
    if reached.fold(0.0, f64::max) > EXPLAINED_BY_ANY {
        return None;
    }
    Some(reason)
}

/// Whether a model tells half of the motion at the longest horizon: after a step or a release, whatever the input's gain is.
pub fn tells_a_second(problem: &Problem<'_>, fit: &Fit) -> bool {
    vaf_ahead(problem, fit, &problem.data.places(), LONGEST_HORIZON_S).is_some_and(|vaf| vaf >= SEEN)
}

/// Why the data are too weak for a model of a loop that was `closed`, where an unstructured model of the input copies what the
/// controller does: the gain of the model is not known.
pub fn gain_unknown(
    problem: &Problem<'_>,
    fit: &Fit,
    information: &Information,
    closed: bool,
) -> Option<String> {
    let all = estimates(problem, fit, Some(information));
    let gain = all.iter().find(|e| e.name == "dM_du")?;
    let half = 0.5 * (gain.ci95[1] - gain.ci95[0]);
    let relative = half / gain.value.abs();
    // what is known of a term whatever the gain is
    let known = |i: usize| {
        let own: Vec<String> = all[fit.own_range(problem, i)].iter().map(Estimate::to_string).collect();
        let first = all.get(fit.own_range(problem, i).start);
        let is_known = first.is_some_and(|first| first.ci95[0] * first.ci95[1] > 0.0);
        if is_known { format!(" ({})", own.join(", ")) } else { String::new() }
    };
    let names = fit.effects.iter().enumerate().filter(|(_, e)| !e.is_background() && !is_shape(**e));
    let names: Vec<String> = names.map(|(i, e)| e.about().sentence.to_owned() + &known(i)).collect();
    let beside = match names.is_empty() {
        true => String::new(),
        false => format!(" once it is asked whether {}", names.join(", and whether ")),
    };
    let [why, remedy] = match closed {
        true => [
            "the loop is closed, and beside what the controller answers the input moves too little",
            "Put in a signal of your own behind the controller, or make a longer test",
        ],
        false => ["the excitation is too weak against the noise", "Use a larger amplitude or a longer test"],
    };
    (relative > WIDEST_GAIN_INTERVAL).then(|| {
        format!(
            "The data cannot tell: {why}, dM/du is known only to ±{:.0} %{beside}. {remedy}.",
            100.0 * relative
        )
    })
}

/// Why the data are too weak for any model: not even the richest predicts anything of the motion from what it was and from the
/// input, at any horizon ([`most_ahead`]). What then is significant is made of the air.
pub fn nothing_follows(most: f64) -> Option<String> {
    (most < SEEN_AT_ALL).then(|| {
        format!(
            "The data cannot tell: the motion does not follow from the input (VAF {most:.1} % at most of predictions {} to {} s ahead, \
             whatever the model). Excite the vehicle: use a larger amplitude.",
            HORIZONS_S[0], LONGEST_HORIZON_S
        )
    })
}

/// Why the data are too weak for any model: the motion is the input itself, in the same row or the one before, and no model predicts it
/// as well at any horizon ([`most_ahead`]). The input is then what an inner loop is told, which is quicker than the rows, or it is
/// made of the motion.
pub fn is_the_input(problem: &Problem<'_>, most: f64) -> Option<String> {
    let (alike, vaf) = most_alike(problem)?;
    (most < vaf).then(|| {
        format!(
            "The data cannot tell: the motion is the input itself ({alike} tells {vaf:.1} % of it), and no model does as well (VAF \
             {most:.1} % at most of predictions {} to {} s ahead). The input is what a loop inside is told, which follows it within a row, \
             or it is made of the motion. Give what moves the vehicle as the input (a motor's command, current, torque), or log faster.",
            HORIZONS_S[0], LONGEST_HORIZON_S
        )
    })
}

/// VAF, per cent, of a model's predictions at its best horizon; `None` where it diverges.
pub fn most_ahead(problem: &Problem<'_>, fit: &Fit) -> Option<f64> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let ahead = horizon_vaf(problem, &unpacked, &problem.data.places(), &HORIZONS_S)?;
    Some(ahead.iter().flatten().fold(0.0, |most, (vaf, _)| vaf.max(most)))
}

/// What a line is drawn through, of an input in a row.
type Line = fn(&[f64], usize) -> f64;

/// The line through the input, or its slope, that tells most of the motion, with its VAF, per cent: the square of their correlation.
fn most_alike(problem: &Problem<'_>) -> Option<(&'static str, f64)> {
    let level = |u: &[f64], k: usize| u[k];
    let before = |u: &[f64], k: usize| u[k.saturating_sub(1)];
    let slope = |u: &[f64], k: usize| u[(k + 1).min(u.len() - 1)] - u[k.saturating_sub(1)];
    let lines: [(&str, Line); 3] =
        [("a + b u", level), ("a + b u of the row before", before), ("a + b du/dt", slope)];
    let told = lines.map(|(name, of)| {
        let places = problem.data.places();
        let pairs = places.iter().flat_map(|place| {
            let u = &problem.data.runs[place.run].u[place.rows.clone()];
            problem.data.judged(place).iter().enumerate().map(move |(k, y)| [of(u, k), *y])
        });
        (name, 100.0 * correlation(&pairs.collect::<Vec<[f64; 2]>>()).powi(2))
    });
    told.into_iter().filter(|(_, vaf)| vaf.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Σ (x − x̄)(y − ȳ) / √(Σ (x − x̄)² Σ (y − ȳ)²); no number where one of them stands still.
fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let n = pairs.len() as f64;
    let mean = [0, 1].map(|i| pairs.iter().map(|pair| pair[i]).sum::<f64>() / n);
    let product =
        |i: usize, j: usize| pairs.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j])).sum::<f64>();
    product(0, 1) / (product(0, 0) * product(1, 1)).sqrt()
}

/// VAF, per cent, of predictions at the longest horizon from the past of the motion: of a swing, which the baseline, that has no
/// spring, does not predict.
fn follows_from_before(problem: &Problem<'_>) -> f64 {
    let places = problem.data.places();
    vaf_of_the_past_alone(problem, &places, &places, LONGEST_HORIZON_S)
}

fn at_rest(problem: &Problem<'_>, baseline: &Fit) -> Option<String> {
    let ahead = vaf_ahead(problem, baseline, &problem.data.places(), LONGEST_HORIZON_S).unwrap_or(0.0);
    let ahead = ahead.max(follows_from_before(problem));
    (ahead < EXPLAINED_BY_ANY).then(|| {
        format!(
            "The data cannot tell: the input never changes, and the motion is no swing or decay either that follows from what it was \
             before (VAF {ahead:.0} % of predictions 1 s ahead). Excite the vehicle."
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::data_checks::fixture::{STEP, flight, normal, read};
    use super::super::fixture::{asked, effects, flown_by, quarters};
    use super::*;
    use crate::likelihood::fit::fit_afresh;
    use crate::model::baseline::Baseline;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn noise_alone_says_nothing_whatever_the_model() {
        let mut still = flight(1, 0.0);
        let mut random = Pcg64::seed_from_u64(5);
        still.q.iter_mut().for_each(|q| *q = 0.01 * normal(&mut random));
        still.theta.iter_mut().for_each(|theta| *theta = 0.003 * normal(&mut random));
        let said = asked(&still, |problem, fit| nothing_follows(most_ahead(problem, fit)?));
        assert!(said.is_some_and(|reason| reason.contains("does not follow from the input")));
    }

    #[test]
    fn a_weak_input_in_air_is_no_such_case() {
        let u = flight(1, 0.0).u.iter().map(|u| 0.3 * u).collect();
        assert_eq!(
            asked(&flown_by(1, u, |_, _, _| 0.0), |problem, fit| nothing_follows(most_ahead(problem, fit)?)),
            None
        );
    }

    #[test]
    fn what_is_known_of_a_term_without_the_gain_is_told() {
        let u = flight(1, 0.0).u.iter().map(|u| 0.01 * u).collect();
        // let go: a swing that the air does not make
        let pushed = |k: usize| if k < 20 { 6.0 } else { 0.0 };
        let swinging = flown_by(1, u, |k, rate, angle| pushed(k) + 0.2 * rate - 2.0 * angle.sin());
        let reason = asked(&swinging, |problem, _| {
            let places: Vec<_> = quarters(problem).into_iter().map(|part| part.places).collect();
            let with = fit_afresh(problem, &effects(&["gravity_stiffness"]), &[1.0])?;
            gain_unknown(problem, &with, &Information::new(problem, &with, &places)?, true)
        });
        let reason = reason.unwrap();
        assert!(reason.contains("gravity acts as a spring (G = "), "{reason}");
    }

    #[test]
    fn what_lies_between_gaps_counts_where_it_is_a_second_long() {
        let text = |every: usize| {
            let mut text = String::from("t_s,u_rad,q_rad_s\n");
            for k in (0..600).filter(|k| k % every > 20) {
                let u = if k / 25 % 2 == 0 { 0.01 } else { -0.01 };
                text.push_str(&format!("{:.2},{u},{:.4}\n", STEP * k as f64, (0.1 * k as f64).sin()));
            }
            text
        };
        let said = |every: usize| {
            let recordings = [read(&text(every))];
            let data = Dataset::new(&recordings).unwrap();
            too_little(&Problem::new(&data, &Baseline::new(None, &data).unwrap(), &[]))
        };
        assert!(
            said(60).unwrap().contains("0.0 s of excitation in stretches of a second and more"),
            "{:?}",
            said(60)
        );
        assert_eq!(said(200), None);
    }

    #[test]
    fn a_motion_that_is_its_demand_tells_nothing_of_the_vehicle() {
        let mut servo = flight(1, 0.0);
        let mut random = Pcg64::seed_from_u64(5);
        // a planner's ramps between targets that come at any time
        let (mut demand, mut target) = (0.0_f64, 0.0);
        for k in 0..servo.u.len() {
            if random.random::<f64>() < 0.03 {
                target = random.random_range(-1.0..1.0);
            }
            let step = (target - demand).clamp(-0.04, 0.04);
            demand += step;
            servo.u[k] = demand;
            servo.theta[k] = demand + 1e-3 * normal(&mut random);
            servo.q[k] = step / STEP + 0.02 * normal(&mut random);
        }
        let itself = |problem: &Problem<'_>, fit: &Fit| is_the_input(problem, most_ahead(problem, fit)?);
        let said = asked(&servo, itself).unwrap();
        assert!(said.contains("a + b du/dt tells "), "{said}");
        assert_eq!(asked(&flight(1, 0.0), itself), None);
    }
}
