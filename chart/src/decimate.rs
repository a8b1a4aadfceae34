//! Curves with fewer points that look the same.

/// Rows of `y` that draw the same picture in about `target` points: the least and the greatest of each stretch, in order of
/// time, with the first and the last row. Values that are no number are left out.
pub fn min_max_rows(y: &[f64], target: usize) -> Vec<usize> {
    let stretches = (target / 2).max(1);
    let length = y.len().div_ceil(stretches).max(1);
    let mut rows = Vec::with_capacity(2 * stretches + 2);
    if length <= 2 {
        rows.extend(0..y.len());
    } else {
        for (i, stretch) in y.chunks(length).enumerate() {
            let by_value = |a: &usize, b: &usize| stretch[*a].total_cmp(&stretch[*b]);
            let finite = || (0..stretch.len()).filter(|&k| stretch[k].is_finite());
            let ends = [finite().min_by(by_value), finite().max_by(by_value)];
            let mut ends: Vec<usize> = ends.into_iter().flatten().map(|k| i * length + k).collect();
            ends.sort_unstable();
            rows.extend(ends);
        }
        rows.extend([0, y.len() - 1]);
        rows.sort_unstable();
        rows.dedup();
    }
    rows.retain(|&k| y[k].is_finite());
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_curves_stay_as_they_are() {
        assert_eq!(min_max_rows(&[1.0, 2.0, 3.0], 100), [0, 1, 2]);
        assert!(min_max_rows(&[], 100).is_empty());
    }

    #[test]
    fn long_curves_keep_every_peak_and_their_ends() {
        let mut y: Vec<f64> = (0..100_000).map(|k| (k as f64 * 0.01).sin()).collect();
        y[77_777] = 9.0;
        y[5] = -9.0;
        let rows = min_max_rows(&y, 2000);
        assert!(rows.len() <= 2002, "{}", rows.len());
        assert!(rows.is_sorted() && rows.contains(&77_777) && rows.contains(&5));
        assert_eq!((rows[0], rows[rows.len() - 1]), (0, 99_999));
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let y: Vec<f64> = (0..1000).map(|k| if k % 2 == 0 { f64::NAN } else { k as f64 }).collect();
        let rows = min_max_rows(&y, 100);
        assert!(!rows.is_empty() && rows.iter().all(|&k| y[k].is_finite()));
        assert!(min_max_rows(&[f64::NAN; 100], 10).is_empty());
    }
}
