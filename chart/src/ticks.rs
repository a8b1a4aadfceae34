//! Ranges of axes and what stands at their ticks.

use std::ops::Range;

/// The range of some values with a margin of 6 % on either side, of the value where there is but one; around 0 where there is nothing
/// to see.
pub fn padded(values: impl IntoIterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .into_iter()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return -1.0..1.0;
    }
    let margin = match high.abs() {
        0.0 if low == high => 1.0,
        of if low == high => 0.06 * of,
        of => (0.06 * (high - low)).max(1e-9 * (1.0 + of)),
    };
    low - margin..high + margin
}

/// Round values inside `range`, about `count` of them and at least two: multiples of 1, 2 or 5 times a power of ten.
pub fn linear(range: &Range<f64>, count: usize) -> Vec<f64> {
    let least = (range.end - range.start) / count as f64;
    let power = 10_f64.powf(least.log10().floor());
    let by = |step: f64| -> Vec<f64> {
        let [first, last] = [(range.start / step).ceil(), (range.end / step).floor()];
        (0..=(last - first).max(-1.0) as usize)
            .map(|k| (first + k as f64) * step)
            .filter(|v| *v <= range.end)
            .collect()
    };
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let Some(coarse) = steps.into_iter().position(|step| step >= least) else { return Vec::new() };
    let all = by(steps[coarse]);
    if all.len() < 2 {
        by(steps.get(coarse.wrapping_sub(1)).map_or(0.5 * power, |finer| *finer))
    } else {
        all
    }
}

/// Logarithms of 1, 2 and 5, or 1 and 3, times the powers of ten inside `range`, which is of logarithms to the base 10; the powers alone
/// where these would be more than `count`, and round values where they are fewer than two.
pub fn logarithmic(range: &Range<f64>, count: usize) -> Vec<f64> {
    let decades = range.start.floor() as i32..=range.end.ceil() as i32;
    let at = |factors: &'static [f64]| -> Vec<f64> {
        let all = decades.clone().flat_map(|d| factors.iter().map(move |f| f64::from(d) + f.log10()));
        all.filter(|v| range.contains(v)).collect()
    };
    let powers = at(&[1.0]);
    let finer = [at(&[1.0, 2.0, 5.0]), at(&[1.0, 3.0])];
    match finer.into_iter().find(|all| (2..=count.max(3)).contains(&all.len())) {
        Some(all) => all,
        None if powers.len() > 1 => powers,
        None => linear(&(10_f64.powf(range.start)..10_f64.powf(range.end)), count)
            .iter()
            .map(|v| v.log10())
            .collect(),
    }
}

/// A tick as people write it: true minus sign, no needless zeros.
pub fn written(value: f64) -> String {
    let size = value.abs();
    let shown = if (1e-12..1e-4).contains(&size) || size >= 1e7 {
        format!("{value:.1e}").replace(".0e", "e")
    } else {
        format!("{}", (value * 1e6).round() / 1e6 + 0.0)
    };
    shown.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_plain() {
        assert_eq!(written(-0.5), "−0.5");
        assert_eq!(written(0.1 + 0.2), "0.3");
        assert_eq!(written(-0.0), "0");
        assert_eq!(written(2.5e-8), "2.5e−8");
        assert_eq!(written(1e-6), "1e−6");
        assert_eq!(written(2e-4), "0.0002");
    }

    #[test]
    fn ranges_never_collapse() {
        let range = padded([2.0, 2.0]);
        assert!(range.start < 2.0 && range.end > 2.0);
        assert_eq!(padded([f64::NAN]), -1.0..1.0);
        assert_eq!(padded([0.0, 0.0]), -1.0..1.0);
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(linear(&(0.0..10.0), 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        let found: Vec<String> = linear(&(-0.13..0.11), 5).into_iter().map(written).collect();
        assert_eq!(found, ["−0.1", "−0.05", "0", "0.05", "0.1"]);
        assert_eq!(logarithmic(&(0.0..1.5), 9).len(), 5, "1, 2, 5, 10, 20");
        assert_eq!(logarithmic(&(-3.5..3.5), 9).len(), 7);
        assert!(linear(&(1.0..1.0), 5).len() < 2);
        assert_eq!(linear(&(-0.09..0.18), 2), [0.0, 0.1]);
        assert!(linear(&(-0.19..0.18), 2).len() > 2, "not 0 alone");
        let wide: Vec<f64> =
            logarithmic(&(0.3..1.98), 4).into_iter().map(|v| 10_f64.powf(v).round()).collect();
        assert_eq!(wide, [3.0, 10.0, 30.0], "evenly spread");
        let near: Vec<f64> =
            logarithmic(&(0.82..1.17), 3).into_iter().map(|v| 10_f64.powf(v).round()).collect();
        assert_eq!(near, [8.0, 10.0, 12.0, 14.0], "no power but 10 lies there");
    }
}
