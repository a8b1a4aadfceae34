//! What the columns of a file mean: worked out, asked for, written within one turn.

use sysid::recording::{NoteKind, ReadOptions, parse};

#[test]
fn columns_are_worked_out_of_several() {
    let mut text = "t us,m1,m2,m3,m4,gyro[1],note\n".to_owned();
    for k in 0..40 {
        let x = f64::from(k);
        text += &format!("{},{},{},0.5,0.25,{},x\n", 20_000 * k, 0.01 * x, 0.02 * x, 10.0 * x.sin());
    }
    let options = ReadOptions {
        columns: ["t_s=`t us`*1e-6", "u_norm=0.25*(m1+m2-m3-m4)", "q_rad_s=-gyro[1]*pi/180"]
            .map(|map| map.parse().unwrap())
            .to_vec(),
        ..ReadOptions::default()
    };
    let recording = parse("mixed.csv", text.as_bytes(), &options).unwrap();
    assert_eq!(recording.step, 0.02);
    assert!((recording.u[10] - 0.25 * (0.1 + 0.2 - 0.75)).abs() < 1e-12, "{}", recording.u[10]);
    assert!((recording.q.as_deref().unwrap()[3] + 10_f64.to_radians() * 3_f64.sin()).abs() < 1e-12);
    let told: Vec<&str> = recording.notes.iter().map(|note| note.text.as_str()).collect();
    assert!(told.iter().any(|text| text.contains("u_norm is m1+m2-m3-m4 of the file's columns, times 0.25")));
    assert!(told.contains(&"columns not used: note"), "{told:?}");

    let bad = text.replace("0.03,0.06,0.5", "0.03,abc,0.5");
    let error = parse("mixed.csv", bad.as_bytes(), &options).unwrap_err();
    assert_eq!((error.line, error.column.as_deref()), (Some(5), Some("m2")), "{error}");
    let unknown = ReadOptions { columns: vec!["u_norm=m1-m22".parse().unwrap()], ..options };
    let error = parse("mixed.csv", text.as_bytes(), &unknown).unwrap_err().to_string();
    assert!(
        error.contains("u_norm=m1-m22: the file has no column \"m22\"\n  expected: one of m2, "),
        "{error}"
    );
}

#[test]
fn a_roll_rate_that_is_asked_for_as_the_rate_has_no_roll_beside_it() {
    let text: String =
        (0..200).map(|k| format!("{},0.0{},{}\n", 0.02 * f64::from(k), k % 3, 0.01 * f64::from(k))).collect();
    let options = ReadOptions { columns: vec!["q_rad_s=p_rad_s".parse().unwrap()], ..ReadOptions::default() };
    let recording = parse("roll.csv", format!("t_s,u_rad,p_rad_s\n{text}").as_bytes(), &options).unwrap();
    assert!(recording.q.is_some() && recording.p.is_none());
}

#[test]
fn a_heading_within_one_turn_is_made_continuous_and_told() {
    let heading = |k: usize| 23.0 * (0.01 * k as f64).sin();
    let row = |k: usize| {
        let written =
            (heading(k) + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        format!("{},{},{}\n", 0.02 * k as f64, if (k / 25).is_multiple_of(2) { 0.01 } else { -0.01 }, written)
    };
    let text = format!("t_s,u_rad,theta_rad\n{}", (0..800).map(row).collect::<String>());
    let recording = parse("heading.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
    let theta = recording.theta.as_ref().unwrap();
    assert!(theta.iter().enumerate().all(|(k, theta)| (theta - heading(k)).abs() < 1e-9));
    let told = |kind: NoteKind| recording.notes.iter().filter(move |note| note.kind == kind);
    assert!(told(NoteKind::Converted).any(|note| note.text.starts_with("theta_rad jumps by a full turn")));
    assert_eq!(told(NoteKind::Unit).count(), 0, "what was written in turns is in radians");
}
