//! Against linear regressions, where every promise has a closed form.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// y = X β + e, the errors repeated `repeated` times, in blocks of so many rows and `PARTS` parts.
struct Regression {
    columns: Vec<Vec<f64>>,
    y: Vec<f64>,
    repeated: usize,
}

const ROWS: usize = 1200;
const PARTS: usize = 3;
const BETA: [f64; 2] = [0.7, -0.3];

fn regression(parameters: usize, repeated: usize) -> Regression {
    let mut random = Pcg64::seed_from_u64(3);
    let mut draw = || (0..12).map(|_| random.random::<f64>() - 0.5).sum::<f64>();
    let mut columns = vec![Vec::new(); parameters];
    let mut y = Vec::new();
    for _ in 0..ROWS {
        let x = [draw(), 0.5 * draw()];
        let value = (0..parameters).map(|i| BETA[i] * (x[i] + if i > 0 { 0.4 * x[0] } else { 0.0 }));
        let row = value.sum::<f64>() + draw();
        for _ in 0..repeated {
            for (i, column) in columns.iter_mut().enumerate() {
                column.push(x[i] + if i > 0 { 0.4 * x[0] } else { 0.0 });
            }
            y.push(row);
        }
    }
    Regression { columns, y, repeated }
}

impl Regression {
    fn part(&self, row: usize) -> usize {
        row * PARTS / self.y.len()
    }

    /// Least squares over the rows that `count`.
    fn solved(&self, count: impl Fn(usize) -> bool) -> Vec<f64> {
        let rows: Vec<usize> = (0..self.y.len()).filter(|&k| count(k)).collect();
        let x = DMatrix::from_fn(rows.len(), self.columns.len(), |k, i| self.columns[i][rows[k]]);
        let y = DVector::from_iterator(rows.len(), rows.iter().map(|&k| self.y[k]));
        x.svd(true, true).solve(&y, 1e-12).unwrap().iter().copied().collect()
    }

    fn errors(&self, beta: &[f64]) -> Vec<f64> {
        let fitted = |k: usize| self.columns.iter().zip(beta).map(|(c, b)| c[k] * b).sum::<f64>();
        (0..self.y.len()).map(|k| self.y[k] - fitted(k)).collect()
    }

    /// In blocks of one set of repeated rows each.
    fn information(&self, beta: &[f64]) -> Information {
        let errors: Vec<[f64; 2]> = self.errors(beta).into_iter().map(|e| [e, 0.0]).collect();
        let slopes: Vec<Vec<[f64; 2]>> =
            self.columns.iter().map(|c| c.iter().map(|x| [-x, 0.0]).collect()).collect();
        let rows = (0..self.y.len()).map(|k| Row { block: (0, k / self.repeated), part: Some(self.part(k)) });
        let coordinates = beta.iter().map(|_| linear([-5.0, 5.0])).collect();
        Information::of_rows(coordinates, beta, &slopes, &errors, rows, PARTS).unwrap()
    }
}

fn linear(bounds: [f64; 2]) -> Coordinate {
    Coordinate { name: "b".into(), unit: "1".into(), bounds, log: false, unit_step: 1.0, prior: None }
}

/// ∫ f over `range` (Simpson).
fn integral(range: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 4000;
    let h = (range[1] - range[0]) / STEPS as f64;
    let weight = |i: usize| match i {
        0 | STEPS => 1.0,
        _ if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=STEPS).map(|i| weight(i) * f(range[0] + i as f64 * h)).sum::<f64>() * h / 3.0
}

#[test]
fn the_evidence_of_a_linear_problem_is_the_exact_one() {
    let one = regression(1, 1);
    let best = one.solved(|_| true);
    let squares = |beta: &[f64]| one.errors(beta).iter().map(|e| e * e).sum::<f64>();
    let least = squares(&best);
    let variance = least / ROWS as f64;
    for divisor in [1.0, 2.5] {
        let likelihood = |b: f64| (-0.5 * (squares(&[b]) - least) / variance / divisor).exp();
        let exact = (integral([best[0] - 0.5, best[0] + 0.5], likelihood) / 10.0).ln();
        let laplace = one.information(&best).occam([0].into_iter(), divisor).unwrap();
        assert!((laplace - exact).abs() < 1e-6, "{laplace} {exact}");
    }
}

#[test]
fn the_evidence_of_one_of_two_is_that_of_its_profile() {
    let two = regression(2, 1);
    let best = two.solved(|_| true);
    let least: f64 = two.errors(&best).iter().map(|e| e * e).sum();
    let variance = least / ROWS as f64;
    let first = &two.columns[0];
    let power: f64 = first.iter().map(|x| x * x).sum();
    let profile = |b: f64| {
        let rest = two.errors(&[0.0, b]);
        let own = first.iter().zip(&rest).map(|(x, e)| x * e).sum::<f64>() / power;
        let square: f64 = two.errors(&[own, b]).iter().map(|e| e * e).sum();
        (-0.5 * (square - least) / variance).exp()
    };
    let exact = (integral([best[1] - 0.8, best[1] + 0.8], profile) / 10.0).ln();
    let laplace = two.information(&best).occam([1].into_iter(), 1.0).unwrap();
    assert!((laplace - exact).abs() < 1e-6, "{laplace} {exact}");
    assert!(two.information(&best).occam([0, 1].into_iter(), 1.0).unwrap() < laplace - 1.0);
}

#[test]
fn the_divisor_is_one_for_independent_scores_and_the_number_of_repetitions_for_repeated_ones() {
    for parameters in [1, 2] {
        for repeated in [1, 4, 9] {
            let some = regression(parameters, repeated);
            let best = some.solved(|_| true);
            let divisor = some.information(&best).divisor(0..parameters);
            // Between what chance may add to the repetitions and what is taken off for it.
            let expected = repeated as f64;
            assert!((0.85 * expected..1.1 * expected).contains(&divisor), "{repeated}: {divisor}");
            assert!(repeated > 1 || divisor == 1.0, "{divisor}");
        }
    }
}

#[test]
fn deviations_are_those_of_the_regression_and_of_its_repetitions() {
    for repeated in [1, 4] {
        let some = regression(1, repeated);
        let best = some.solved(|_| true);
        let errors = some.errors(&best);
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        let power: f64 = some.columns[0].iter().map(|x| x * x).sum();
        let once = (variance / power).sqrt() * (repeated as f64).sqrt();
        let found = some.information(&best).deviations(&best)[0];
        assert!((found / once - 1.0).abs() < 0.06, "{repeated}: {found} {once}");
    }
}

#[test]
fn without_a_part_the_linear_problem_is_solved_as_if_it_had_never_been_there() {
    let two = regression(2, 1);
    let best = two.solved(|_| true);
    let information = two.information(&best);
    for part in 0..PARTS {
        let (turned, again) =
            (information.without(part, &best, |_| false), two.solved(|k| two.part(k) != part));
        for i in 0..2 {
            assert!((turned[i] - again[i]).abs() < 1e-8, "{part}: {turned:?} {again:?}");
            assert!((again[i] - best[i]).abs() > 1e-4, "the part must matter");
        }
    }
}

#[test]
fn what_is_held_stays_and_the_others_are_solved_beside_it() {
    let two = regression(2, 1);
    let best = two.solved(|_| true);
    let turned = two.information(&best).without(1, &best, |i| i == 0);
    let rows = || (0..ROWS).filter(|&k| two.part(k) != 1);
    let errors = two.errors(&[best[0], 0.0]);
    let power: f64 = rows().map(|k| two.columns[1][k].powi(2)).sum();
    let own = rows().map(|k| two.columns[1][k] * errors[k]).sum::<f64>() / power;
    assert!(turned[0] == best[0] && (turned[1] - own).abs() < 1e-8, "{turned:?} {own}");
}

#[test]
fn an_interval_holds_zero_up_to_its_edge_where_either_sign_is_possible() {
    let one = regression(1, 1);
    let mut information = one.information(&one.solved(|_| true));
    let edge = 1.96 * information.deviations(&[0.0])[0];
    for sign in [-1.0, 1.0] {
        assert!(information.holds_zero([0].into_iter(), &[sign * edge * 0.999]));
        assert!(!information.holds_zero([0].into_iter(), &[sign * edge * 1.001]));
    }
    information.coordinates[0] = linear([0.0, 5.0]);
    assert!(!information.holds_zero([0].into_iter(), &[0.5 * edge]), "a size has one sign");
    assert!(!information.holds_zero(std::iter::empty(), &[0.0]));
}

#[test]
fn what_stands_at_a_bound_or_does_nothing_does_not_move_and_is_no_candidate() {
    let two = regression(2, 1);
    let best = two.solved(|_| true);
    let errors: Vec<[f64; 2]> = two.errors(&best).into_iter().map(|e| [e, 0.0]).collect();
    let column = |i: usize| -> Vec<[f64; 2]> { two.columns[i].iter().map(|x| [-x, 0.0]).collect() };
    let rows = || (0..ROWS).map(|k| Row { block: (0, k), part: None });
    let of = |bounds: [f64; 2], slopes: [Vec<[f64; 2]>; 2]| {
        let coordinates = vec![linear([-5.0, 5.0]), linear(bounds)];
        Information::of_rows(coordinates, &best, &slopes, &errors, rows(), 0).unwrap()
    };
    let idle = vec![[0.0; 2]; ROWS];
    for fixed in [of([best[1], 5.0], [column(0), column(1)]), of([-5.0, 5.0], [column(0), idle])] {
        assert!(fixed.moves(0) && !fixed.moves(1));
        assert!(fixed.occam([1].into_iter(), 1.0).is_none() && fixed.occam([0].into_iter(), 1.0).is_some());
        assert_eq!(fixed.divisor([1].into_iter()), 1.0);
        assert!(fixed.deviations(&best)[1].is_infinite());
    }
}

#[test]
fn two_channels_are_weighed_with_their_covariance_and_a_prior_adds_its_own() {
    let two = regression(2, 1);
    let best = two.solved(|_| true);
    // The second channel repeats the first beside noise of its own: the weight must not count it twice.
    let own: Vec<f64> = two.columns[1].iter().rev().copied().collect();
    let errors: Vec<[f64; 2]> = two.errors(&best).iter().zip(&own).map(|(e, n)| [*e, e + 0.5 * n]).collect();
    let slopes: Vec<Vec<[f64; 2]>> =
        two.columns.iter().map(|c| c.iter().map(|x| [-x, -x]).collect()).collect();
    let mut covariance = Matrix2::zeros();
    for e in &errors {
        covariance += nalgebra::Vector2::from(*e) * nalgebra::RowVector2::from(*e) / ROWS as f64;
    }
    let weight = covariance.try_inverse().unwrap();
    let per_square = weight.sum();
    let mut prior = linear([-5.0, 5.0]);
    prior.prior = Some((0.0, 0.02));
    let coordinates = vec![linear([-5.0, 5.0]), prior];
    let rows = (0..ROWS).map(|k| Row { block: (0, k), part: None });
    let information = Information::of_rows(coordinates, &best, &slopes, &errors, rows, 0).unwrap();
    let x = |i: usize, j: usize| two.columns[i].iter().zip(&two.columns[j]).map(|(a, b)| a * b).sum::<f64>();
    let expected = Matrix2::new(x(0, 0), x(0, 1), x(0, 1), x(1, 1)) * per_square
        + Matrix2::new(0.0, 0.0, 0.0, 1.0 / (0.02 * 0.02));
    let inverse = expected.try_inverse().unwrap();
    for (i, j) in [(0, 0), (0, 1), (1, 1)] {
        assert!((information.hessian[(i, j)] / expected[(i, j)] - 1.0).abs() < 1e-9);
        assert!((information.covariance[(i, j)] / inverse[(i, j)] - 1.0).abs() < 1e-9);
    }
}
