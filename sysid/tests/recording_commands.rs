//! Commands in fewer rows than the motion, or in rows of their own.

use sysid::recording::{InputHold, ReadOptions, parse};

#[test]
fn a_command_that_was_logged_less_often_is_held_from_each_of_its_rows_to_the_next() {
    let mut text = "t_s,u_norm,q_rad_s\n".to_owned();
    for k in 0..200 {
        let u = if k % 4 == 1 && k < 160 { format!("{}", k / 4) } else { String::new() };
        text += &format!("{:.2},{u},{}\n", 0.01 * f64::from(k), f64::from(k).sin());
    }
    let read = parse("a.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(read.u[..9], [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0], "from the first row that has it");
    assert!(
        (read.t[read.len() - 1] - 1.97).abs() < 1e-9,
        "ten times its usual distance, no longer: {:?}",
        read.t.last()
    );
    let note = read.notes.iter().find(|note| note.text.contains("held from each to the next"));
    assert!(note.is_some_and(|note| note.text.contains("40 of the 200 rows")), "{:?}", read.notes);
    let measured = ReadOptions { input_hold: InputHold::Interpolated, ..ReadOptions::default() };
    let read = parse("a.csv", text.as_bytes(), &measured).unwrap();
    assert!((read.u[2] - 0.5).abs() < 1e-9, "along a straight line: {:?}", &read.u[..5]);
}

#[test]
fn a_command_in_rows_of_its_own_is_held_too_and_a_dropout_is_a_gap() {
    let (mut joined, mut dropped) = ("t_s,u_norm,q_rad_s\n".to_owned(), "t_s,u_norm,q_rad_s\n".to_owned());
    for k in 0..200 {
        let (t, rate) = (0.02 * f64::from(k), f64::from(k).sin());
        joined += &format!("{t:.3},{k},\n{:.3},,{rate}\n", t + 0.003);
        let u = if (60..120).contains(&k) { String::new() } else { k.to_string() };
        dropped += &format!("{t:.3},{u},{rate}\n");
    }
    let read = parse("a.csv", joined.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!((read.len(), read.u[7], read.segments.len()), (200, 7.0, 1));
    let read = parse("a.csv", dropped.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(read.segments.len(), 2, "{:?}", read.notes);
}
