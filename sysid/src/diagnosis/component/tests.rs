use super::super::fixture::{asked, effects, extended, flight_with};
use super::*;
use crate::diagnosis::data_checks::fixture::GAIN;
use crate::likelihood::fit::refit;

const FRICTION: f64 = 0.1;
/// Of the test flight, N m s/rad.
const DAMPING: f64 = -0.27;

fn friction(_: usize, q: f64, _: f64) -> f64 {
    -FRICTION * (q / 0.01).tanh()
}

/// Mean square of (data − truth)/(standard error), and the largest standard error.
fn against(branch: &Branch, truth: impl Fn(f64) -> f64) -> (f64, f64) {
    let scores = branch.data.iter().map(|[x, value, error]| ((value - truth(*x)) / error).powi(2));
    let largest = branch.data.iter().map(|point| point[2]).fold(0.0, f64::max);
    (scores.sum::<f64>() / branch.data.len() as f64, largest)
}

#[test]
fn classes_find_the_friction_within_their_standard_errors() {
    asked(&flight_with(1, friction), |problem, baseline| {
        let mut fit = extended(problem, baseline, &effects(&["coulomb_friction"]));
        // What is off in the rest of the model would show here.
        fit.minimum.values[..2].copy_from_slice(&[DAMPING, GAIN]);
        let shown = components(problem, &fit);
        let [component] = shown.as_slice() else { panic!("one term") };
        let [branch] = component.branches.as_slice() else { panic!("one curve") };
        let away: Vec<[f64; 3]> = branch.data.iter().filter(|p| p[0].abs() > 0.03).copied().collect();
        let away = Branch { data: away, ..Branch::default() };
        let (score, error) = against(&away, |q| friction(0, q, 0.0));
        assert!(away.data.len() >= 6 && score < 2.5, "{} {score}", away.data.len());
        assert!(error < 0.06, "{error}");
        assert!(branch.with.iter().all(|[q, m]| q.abs() < 0.1 || (m.abs() - FRICTION).abs() < 0.03));
        assert!(branch.without.iter().all(|[_, m]| *m == 0.0));
    });
}

#[test]
fn the_points_are_the_data_and_not_the_term() {
    asked(&flight_with(1, friction), |problem, baseline| {
        let mut fit = extended(problem, baseline, &effects(&["coulomb_friction"]));
        let before = components(problem, &fit).remove(0).branches.remove(0);
        let own = fit.own_range(problem, 0).start;
        fit.minimum.values[own] *= 0.5;
        let after = components(problem, &fit).remove(0).branches.remove(0);
        let largest = |branch: &Branch| branch.with.iter().map(|[_, m]| m.abs()).fold(0.0, f64::max);
        assert!((largest(&after) / largest(&before) - 0.5).abs() < 0.1);
        let step = |branch: &Branch| {
            let mean = |side: f64| {
                let points: Vec<f64> =
                    branch.data.iter().filter(|p| side * p[0] > 0.03).map(|p| p[1]).collect();
                points.iter().sum::<f64>() / points.len() as f64
            };
            mean(-1.0) - mean(1.0)
        };
        assert!((step(&after) / step(&before) - 1.0).abs() < 0.1, "{} {}", step(&before), step(&after));
    });
}

#[test]
fn a_constant_moment_is_no_part_of_a_spring() {
    let pulled = |_: usize, _: f64, angle: f64| 0.5 - 3.0 * angle;
    asked(&flight_with(1, pulled), |problem, baseline| {
        let fit = extended(problem, baseline, &effects(&["gravity_stiffness"]));
        let branch = components(problem, &fit).remove(0).branches.remove(0);
        let mean = |of: &dyn Fn(&[f64; 3]) -> f64| {
            branch.data.iter().map(of).sum::<f64>() / branch.data.len() as f64
        };
        let (angle, moment) = (mean(&|point| point[0]), mean(&|point| point[1]));
        let product = mean(&|point| (point[0] - angle) * (point[1] - moment));
        let slope = product / mean(&|point| (point[0] - angle).powi(2));
        assert!((slope + 3.0).abs() < 0.6, "{slope}");
        let drawn = branch.with.iter().map(|point| point[1]).sum::<f64>() / branch.with.len() as f64;
        assert!((moment - drawn).abs() < 0.1, "{moment} beside {drawn}");
    });
}

#[test]
fn a_lag_rises_after_a_step_and_a_window_opens_and_closes() {
    let window = |k: usize, _: f64, _: f64| if (800..1200).contains(&k) { 1.0 } else { 0.0 };
    asked(&flight_with(1, window), |problem, baseline| {
        let start = [&baseline.minimum.values[..], &[1.0, 16.0, 24.0]].concat();
        let fit = refit(problem, &effects(&["moment_step"]), &start).unwrap();
        let branch = components(problem, &fit).remove(0).branches.remove(0);
        let (score, _) = against(&branch, |t| if (16.0..24.0).contains(&t) { 1.0 } else { 0.0 });
        let inside = branch.data.iter().filter(|p| (17.0..23.0).contains(&p[0]));
        assert!(inside.clone().count() >= 2 && inside.clone().all(|p| p[1] > 0.5), "{:?}", branch.data);
        assert!(score < 4.0, "{score}");
        let lag = extended(problem, baseline, &effects(&["servo_lag"]));
        let answer = components(problem, &lag).remove(0).branches.remove(0);
        let gain = answer.without.last().unwrap()[1];
        assert!(answer.data[0][1].abs() < 0.2 * gain, "nothing moves before the delay");
        assert!((answer.data[8][1] / gain - 1.0).abs() < 0.2, "{:?}", answer.data);
    });
}

#[test]
fn a_signal_that_never_moves_gives_numbers_all_the_same() {
    asked(&flight_with(1, friction), |problem, baseline| {
        for id in [
            "cross_feed",
            "thrust_dependence",
            "thrust_offset",
            "gravity_stiffness",
            "hysteresis",
            "linkage_backlash",
        ] {
            let mut fit = baseline.clone();
            fit.effects = effects(&[id]);
            fit.minimum.values.extend(fit.effects[0].starts(&problem.sizes).remove(0));
            for component in components(problem, &fit) {
                let numbers = component.branches.iter().flat_map(|b| {
                    let curves = b.with.iter().chain(&b.without).flatten().copied();
                    b.data.iter().flatten().copied().chain(curves).collect::<Vec<f64>>()
                });
                assert!(numbers.into_iter().all(f64::is_finite), "{id}");
            }
        }
    });
}
