//! Recordings as spreadsheets and bench programs write them: other separators, decimal commas, no time.

use std::fmt::Write;

use sysid::recording::{Column, ReadOptions, Recording, from_columns, parse};

/// A square wave and what turns after it, in rows of 20 ms: time, input, rate.
fn rows() -> Vec<[f64; 3]> {
    (0..40)
        .map(|k| [0.02 * f64::from(k), if k % 10 < 5 { 0.01 } else { -0.01 }, (0.3 * f64::from(k)).sin()])
        .collect()
}

fn text(header: [&str; 3], separator: char, comma: bool) -> String {
    let mut text = format!("{}\n", header.join(&separator.to_string()));
    for [t, u, q] in rows() {
        let row = format!("{t:.2}{separator}{u:.2}{separator}{q:.6}");
        writeln!(text, "{}", if comma { row.replace('.', ",") } else { row }).unwrap();
    }
    text
}

fn told(recording: &Recording) -> Vec<&str> {
    recording.notes.iter().map(|note| note.text.as_str()).collect()
}

#[test]
fn semicolons_and_tabs_separate_and_leave_the_comma_to_decimals() {
    let header = ["t_s", "u_rad", "q_rad_s"];
    let of = |separator, comma| {
        parse("a.csv", text(header, separator, comma).as_bytes(), &ReadOptions::default()).unwrap()
    };
    let plain = of(',', false);
    assert_eq!(told(&plain), Vec::<&str>::new());
    for (separator, name) in [(';', "semicolons"), ('\t', "tabs")] {
        for comma in [false, true] {
            let other = of(separator, comma);
            assert_eq!((&other.t, &other.u, &other.q), (&plain.t, &plain.u, &plain.q), "{name} {comma}");
            let note = format!("columns separated by {name}: a comma in a number is a decimal one");
            assert_eq!(told(&other), [note]);
        }
    }
}

#[test]
fn names_with_a_comma_between_semicolons_are_names() {
    let header = ["time, s", "u_rad", "rate, deg/s"];
    let columns = ["t_s=`time, s`", "q_deg_s=`rate, deg/s`"].map(|map| map.parse().unwrap()).to_vec();
    let options = ReadOptions { columns, ..ReadOptions::default() };
    let recording = parse("a.csv", text(header, ';', true).as_bytes(), &options).unwrap();
    assert!((recording.q.as_ref().unwrap()[7] - 2.1_f64.sin().to_radians()).abs() < 1e-6);
}

#[test]
fn a_first_row_of_numbers_with_decimal_commas_is_no_header() {
    let error = parse("a.csv", b"0,00;0,01;0,1\n0,02;0,01;0,2\n", &ReadOptions::default()).unwrap_err();
    assert!(error.found.contains("a row of numbers"), "{error}");
}

#[test]
fn rows_are_counted_where_no_time_was_logged() {
    let with = |map: &str| ReadOptions { columns: vec![map.parse().unwrap()], ..ReadOptions::default() };
    let logged = text(["n", "u_rad", "q_rad_s"], ',', false);
    let error = parse("a.csv", logged.as_bytes(), &ReadOptions::default()).unwrap_err();
    assert!(error.advice.contains("'t_s=row*0.01' counts rows"), "{error}");
    let recording = parse("a.csv", logged.as_bytes(), &with("t_s=row*0.02")).unwrap();
    assert_eq!((recording.step, recording.len(), recording.t[39]), (0.02, 40, 0.78));
    // a column of this name is what is meant
    let named = logged.replace("n,u_rad", "row,u_rad");
    assert_eq!(parse("a.csv", named.as_bytes(), &with("t_s=row")).unwrap().step, 0.02);

    let column = |place: usize| Column::Numbers(rows().iter().map(|row| row[place]).collect());
    let columns = vec![("u_rad".to_owned(), column(1)), ("q_rad_s".to_owned(), column(2))];
    let recording = from_columns("table", columns, &with("t_s=row*0.02")).unwrap();
    assert_eq!((recording.step, recording.t[39]), (0.02, 0.78));
}
