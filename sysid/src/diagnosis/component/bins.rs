//! Classes of a signal: as fine as the data resolve.

use super::regression::{Regression, Solution};

/// Classes of one branch at first.
const FIRST: usize = 24;
/// Classes of one branch that stay, however uncertain.
const LEAST: usize = 8;
/// Places at which a term's own curve is drawn.
pub const FINE: usize = 120;
/// Classes are joined until their standard error is below this share of the term's largest moment.
const RESOLVED: f64 = 0.12;
/// Values beyond this share of all at either end are in the class at that end.
const TAIL: f64 = 0.002;

/// Edges of at most `count` classes, half by number and half by width: fine where the values lie, and reaching to the ends.
pub fn edges(values: &[f64], count: usize) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    if n == 0 {
        return Vec::new();
    }
    let tail = (TAIL * n as f64) as usize;
    let (low, high) = (sorted[tail], sorted[n - 1 - tail]);
    let width = (high - low).max(f64::MIN_POSITIVE);
    let mut edges: Vec<f64> = Vec::with_capacity(count);
    for (k, value) in sorted.iter().enumerate() {
        let place = 0.5 * (k as f64 / n as f64 + ((value - low) / width).clamp(0.0, 1.0));
        let full = place * count as f64 >= (edges.len() + 1) as f64;
        if full && *value > sorted[0] && edges.len() + 1 < count {
            edges.push(*value);
        }
    }
    edges.dedup();
    edges
}

/// The class of `value`.
pub fn class(edges: &[f64], value: f64) -> usize {
    edges.partition_point(|edge| *edge <= value)
}

/// Edges of the classes at first.
pub fn first_edges(values: &[f64]) -> Vec<f64> {
    edges(values, FIRST)
}

/// Joins neighbouring classes of one branch (`branch` says of each class which) until the data resolve them against a term
/// of the size `size`. Answers the class that each has become part of, and the coefficients.
pub fn resolved(regression: &Regression, branch: &[usize], size: f64) -> Option<(Vec<usize>, Solution)> {
    let mut into: Vec<usize> = (0..branch.len()).collect();
    loop {
        let count = into.last()? + 1;
        let solution = regression.merged(&into).solve();
        let of = |class: usize| into.iter().position(|i| *i == class).map(|j| branch[j]);
        let members = |class: usize| (0..count).filter(|&c| of(c) == of(class)).count();
        let error = |class: usize| solution.as_ref().map_or(f64::INFINITY, |s| s.standard_errors[class]);
        let worst = (0..count)
            .filter(|&c| members(c) > LEAST && error(c) > RESOLVED * size)
            .max_by(|a, b| error(*a).total_cmp(&error(*b)));
        let Some(worst) = worst else { return Some((into, solution?)) };
        let beside = [worst.checked_sub(1), Some(worst + 1)].into_iter().flatten();
        let neighbour = beside
            .filter(|&c| c < count && of(c) == of(worst))
            .max_by(|a, b| error(*a).total_cmp(&error(*b)))?;
        let gone = worst.max(neighbour);
        into.iter_mut().filter(|i| **i >= gone).for_each(|i| *i -= 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_fine_where_values_lie_and_reach_to_the_ends() {
        let values: Vec<f64> = (0..10_000).map(|k| (f64::from(k) / 5000.0 - 1.0).powi(5)).collect();
        let found = edges(&values, 24);
        assert!(found.is_sorted() && found.len() == 23, "{}", found.len());
        let near = found.iter().filter(|edge| edge.abs() < 0.05).count();
        assert!((6..16).contains(&near), "{near}");
        assert!(found[0] < -0.7 && found[22] > 0.7);
        assert_eq!((class(&found, -9.0), class(&found, 9.0)), (0, 23));
    }

    #[test]
    fn two_values_are_two_classes_and_one_is_one() {
        let two: Vec<f64> = (0..100).map(|k| f64::from(k % 2)).collect();
        assert_eq!(edges(&two, 24), [1.0]);
        assert!(edges(&[3.0; 50], 24).len() <= 1 && edges(&[], 24).is_empty());
    }

    #[test]
    fn uncertain_classes_are_joined_within_their_branch() {
        let mut sums = Regression::new(20);
        for k in 0..16_000 {
            let mut z = [0.0; 20];
            // the first classes are seldom
            let class = if k % 100 == 0 { k / 100 % 4 } else { 4 + k % 16 };
            z[class] = 1.0;
            sums.add(k / 1000, &z, f64::from((k * 7919 % 1009) as u32) / 291.0 - 1.73);
        }
        let branch: Vec<usize> = (0..20).map(|class| class / 10).collect();
        let (into, solution) = resolved(&sums, &branch, 1.0).unwrap();
        assert!(into.is_sorted() && into[9] < into[10]);
        assert_eq!(solution.values.len(), into[19] + 1);
        assert!(into[3] < 3 && into[19] - into[10] == 9, "{into:?}");
        assert_eq!(resolved(&sums, &branch, 1e3).unwrap().0[19], 19);
        assert_eq!(resolved(&sums, &branch, 1e-9).unwrap().0[19], 15);
    }
}
