//! Whatever the bytes: no panic, no number that is not finite, a uniform grid; and what is written reads back.

use proptest::prelude::*;
use sysid::recording::{ReadOptions, Recording, parse};

fn valid_file(seed: u32) -> String {
    let mut text = "t_s,u_rad,q_rad_s,theta_rad,section,supervised\n".to_owned();
    for k in 0..60_u32 {
        let x = f64::from(k) + f64::from(seed % 97);
        let label = ["I", "-", "IV"][(k as usize / 20) % 3];
        text += &format!(
            "{:.3},{:.4},{:.5},{:.5},{label},{}\n",
            0.02 * f64::from(k),
            0.01 * x.cos(),
            x.sin(),
            0.3 * x.cos(),
            k % 2
        );
    }
    text
}

fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    let options = ReadOptions { min_samples: 3, ..ReadOptions::default() };
    match parse("any.csv", bytes, &options) {
        Err(error) => prop_assert!(
            !error.found.is_empty()
                && !error.advice.is_empty()
                && error.to_string().lines().count() <= 3 + 20
        ),
        Ok(recording) => sound(&recording)?,
    }
    Ok(())
}

fn sound(recording: &Recording) -> Result<(), TestCaseError> {
    let outputs = [
        &recording.q,
        &recording.theta,
        &recording.qdot,
        &recording.p,
        &recording.r,
        &recording.phi,
        &recording.theta_ref,
        &recording.battery,
    ];
    for series in outputs.into_iter().flatten().chain([&recording.t, &recording.u]) {
        prop_assert_eq!(series.len(), recording.len());
        prop_assert!(series.iter().all(|v| v.is_finite()));
    }
    prop_assert_eq!(recording.supervised.len(), recording.len());
    prop_assert!(recording.step.is_finite() && recording.step > 0.0);
    let mut end = 0;
    for rows in &recording.segments {
        prop_assert!(rows.start == end && rows.end > rows.start);
        end = rows.end;
        let largest = recording.t[rows.clone()].iter().fold(0.0_f64, |m, t| m.max(t.abs()));
        for pair in recording.t[rows.clone()].windows(2) {
            prop_assert!(
                (pair[1] - pair[0] - recording.step).abs()
                    <= 1e-3 * recording.step + 4.0 * f64::EPSILON * largest
            );
        }
    }
    prop_assert_eq!(end, recording.len());
    for section in &recording.sections {
        prop_assert!(
            recording.segments.iter().any(|s| s.start <= section.rows.start && section.rows.end <= s.end)
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        check(&bytes)?;
    }

    #[test]
    fn random_csv_like_text_never_panics(body in "[0-9eE+.,;\"#\n\r -]{0,300}") {
        check(format!("t_s,u_rad,q_rad_s\n{body}").as_bytes())?;
    }

    #[test]
    fn mutated_files_never_panic(seed in 0_u32..100, edits in proptest::collection::vec((any::<u16>(), any::<u8>(), 0_u8..3), 1..6)) {
        let mut bytes = valid_file(seed).into_bytes();
        for (place, value, how) in edits {
            let place = usize::from(place) % bytes.len();
            match how {
                0 => bytes[place] = value,
                1 => bytes.insert(place, b"0123456789-.e,\n\""[usize::from(value) % 16]),
                _ => drop(bytes.remove(place)),
            }
        }
        check(&bytes)?;
    }

    #[test]
    fn any_growing_clock_gives_a_sound_grid(steps in proptest::collection::vec(prop_oneof![10 => 0.01..0.03_f64, 1 => 0.03..2.0_f64], 30..200)) {
        let mut t = 100.0;
        let rows: String = steps.iter().enumerate().map(|(k, d)| { t += d; format!("{t},{},{}\n", k % 2, (k as f64).sin()) }).collect();
        check(format!("t_s,u_rad,q_rad_s\n{rows}").as_bytes())?;
    }

    #[test]
    fn written_recordings_read_back(seed in 0_u32..100, gap in 0.2..3.0_f64, jitter in 0.0..0.009_f64) {
        let text = valid_file(seed);
        let header = text.lines().next().unwrap_or_default();
        let rows = text.lines().skip(1).enumerate().map(|(k, line)| {
            let (t, rest) = line.split_once(',').unwrap();
            let t = t.parse::<f64>().unwrap() + if k < 30 { 0.0 } else { gap } + jitter * (k as f64 * 2.3).sin();
            format!("{t},{rest}\n")
        });
        let text: String = std::iter::once(format!("{header}\n")).chain(rows).collect();
        let first = parse("a.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let mut bytes = Vec::new();
        first.write_csv(&mut bytes).unwrap();
        let mut second = parse("a.csv", &bytes, &ReadOptions::default()).unwrap();
        prop_assert!((second.step - first.step).abs() < 1e-9);
        prop_assert_eq!(&second.segments, &first.segments);
        let shift = second.t.iter().zip(&first.t).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        prop_assert!(shift < 1e-9, "{}", shift);
        (second.step, second.t, second.notes) = (first.step, first.t.clone(), first.notes.clone());
        prop_assert_eq!(second, first);
    }
}
