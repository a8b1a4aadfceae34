//! Lines that a serial link, a board that starts again or a full card has garbled, and stray time stamps.

use sysid::recording::{NoteKind, ReadOptions, Recording, parse};

fn notes(recording: &Recording, kind: NoteKind) -> Vec<&str> {
    recording.notes.iter().filter(|n| n.kind == kind).map(|n| n.text.as_str()).collect()
}

/// 400 rows at 50 Hz, some lines of the file (counted from 1) replaced.
fn garbled(replaced: &[(usize, &[u8])]) -> Vec<u8> {
    let row = |k: u32| format!("{},0.0{},0.{}", 0.02 * f64::from(k), 1 + k % 2, 100 + k % 7);
    let mut lines = vec![b"t_s,u_rad,q_rad_s".to_vec()];
    lines.extend((0..400).map(|k| row(k).into_bytes()));
    replaced.iter().for_each(|(line, text)| lines[line - 1] = text.to_vec());
    lines.join(&b'\n')
}

#[test]
fn a_few_garbled_lines_are_left_out_and_told() {
    let lines: [(usize, &[u8]); 3] =
        [(50, b"t_s,u_rad,q_rad_s"), (100, b"1.96,0.0\xff\x801,0.1"), (300, &[0; 300])];
    let options = ReadOptions::default();
    let recording = parse("good.csv", &garbled(&lines), &options).unwrap();
    let missing = notes(&recording, NoteKind::Missing);
    let told = "3 lines of 400 garbled, what should stand there taken as missing: line 50: the header again; line 100, \
                column u_rad: found \"0.0\u{fffd}\u{fffd}1\"; line 300: 1 field";
    assert_eq!(missing[0], told);
    assert!(missing[1].contains("left out as a gap (line 100)"), "{missing:?}");
    let whole = parse("good.csv", &garbled(&[]), &options).unwrap();
    assert_eq!((recording.t.first(), recording.t.len()), (whole.t.first(), whole.t.len()));
}

#[test]
fn a_row_out_of_order_in_time_is_left_out_and_told() {
    let options = ReadOptions::default();
    let read = |lines: &[(usize, &[u8])]| parse("good.csv", &garbled(lines), &options);
    let told = |lines: &[(usize, &[u8])]| {
        let recording = read(lines).unwrap();
        let note = recording.notes.iter().find(|note| note.text.contains("out of order")).unwrap().clone();
        (recording.t.len(), note.time_s.unwrap(), note.text)
    };
    let (rows, time, text) = told(&[(100, b"19.6,0.01,0.1")]);
    assert_eq!((rows, text.as_str()), (400, "1 row out of order in time: left out as a gap (line 100)"));
    assert!((time[0] - 1.94).abs() < 1e-9 && (time[1] - 1.98).abs() < 1e-9, "{time:?}");
    let (rows, time, _) = told(&[(2, b"1e6,0.01,0.1")]);
    assert!(rows == 399 && time[0] <= time[1] && time[1] < 0.1, "{time:?}");
    let five: Vec<(usize, &[u8])> = (0..5).map(|k| (50 * (k + 1), &b"70,0.01,0.1"[..])).collect();
    assert!(read(&five).unwrap_err().found.contains("backwards"));
}

#[test]
fn a_garbled_line_takes_its_time_where_rows_are_counted() {
    let options = ReadOptions { columns: vec!["t_s=row*0.02".parse().unwrap()], ..ReadOptions::default() };
    let read = |lines: &[(usize, &[u8])]| parse("good.csv", &garbled(lines), &options).unwrap();
    let (whole, short, header) =
        (read(&[]), read(&[(100, b"1.96,0.0")]), read(&[(100, b"t_s,u_rad,q_rad_s")]));
    assert_eq!((short.t.last(), short.t.len()), (whole.t.last(), whole.t.len()), "a gap of one row");
    assert_eq!(header.t.len(), whole.t.len() - 1);
}

#[test]
fn a_garbled_name_of_a_section_is_that_of_the_row_before() {
    let row = |k: u32| format!("{},0.0{},0.{},A\n", 0.02 * f64::from(k), 1 + k % 2, 100 + k % 7);
    let rows: String = (0..400).map(row).collect();
    let mut bytes = format!("t_s,u_rad,q_rad_s,section\n{rows}").into_bytes();
    let place = bytes.len() / 2;
    let name = place + bytes[place..].iter().position(|&b| b == b'A').unwrap();
    bytes[name] = 0xff;
    let recording = parse("good.csv", &bytes, &ReadOptions::default()).unwrap();
    assert_eq!(recording.sections.iter().map(|s| s.label.as_str()).collect::<Vec<_>>(), ["A"]);
    assert!(
        recording.notes.iter().any(|note| note.text.contains("column section: found")),
        "{:?}",
        recording.notes
    );
}

#[test]
fn many_garbled_lines_are_refused() {
    let five: Vec<(usize, &[u8])> = (0..5).map(|k| (50 * (k + 1), &b"reset"[..])).collect();
    let error = parse("bad.csv", &garbled(&five), &ReadOptions::default()).unwrap_err().to_string();
    assert!(
        error.starts_with("bad.csv, line 50: 1 field") && error.contains("also: line 250: 1 field"),
        "{error}"
    );
    let bytes: Vec<(usize, &[u8])> = (0..5).map(|k| (50 * (k + 1), &b"0,0.1,\0"[..])).collect();
    let error = parse("bad.csv", &garbled(&bytes), &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("a binary file (zero byte at offset"), "{error}");
}

#[test]
fn a_few_rows_with_the_stamp_of_another_are_spread_and_many_are_refused() {
    let options = ReadOptions::default();
    let whole = parse("good.csv", &garbled(&[]), &options).unwrap();
    // rows at 2 s, and at 4 s and 4.02 s, stamped as the row after them
    let lines: [(usize, &[u8]); 3] =
        [(102, b"2.02,0.02,0.9"), (202, b"4.04,0.01,0.8"), (203, b"4.04,0.02,0.7")];
    let recording = parse("good.csv", &garbled(&lines), &options).unwrap();
    assert_eq!((recording.len(), recording.segments.len()), (400, 1));
    assert!(recording.t.iter().zip(&whole.t).all(|(a, b)| (a - b).abs() < 1e-6));
    let told = notes(&recording, NoteKind::Snapped);
    assert!(told[0].starts_with("3 rows with the stamp of the row before"), "{told:?}");
    // a repetition among them is one all the same
    let again: [(usize, &[u8]); 3] =
        [(202, b"4.04,0.01,0.104"), (203, b"4.04,0.01,0.104"), (204, b"4.04,0.02,0.106")];
    let recording = parse("good.csv", &garbled(&again), &options).unwrap();
    assert_eq!(notes(&recording, NoteKind::Duplicate).len(), 1);
    assert!(notes(&recording, NoteKind::Snapped)[0].starts_with("1 row with the stamp"));
    // after a gap they are the last of it
    let late: Vec<(usize, Vec<u8>)> = (202..402)
        .map(|line| (line, format!("{},0.02,0.{}", 12.0 + 0.02 * line as f64, line % 7).into_bytes()))
        .collect();
    let mut late: Vec<(usize, &[u8])> = late.iter().map(|(line, text)| (*line, text.as_slice())).collect();
    let first = format!("{},0.01,0.4", 12.0 + 0.02 * 203.0);
    late[0].1 = first.as_bytes();
    let recording = parse("good.csv", &garbled(&late), &options).unwrap();
    assert_eq!(recording.segments.len(), 2);
    assert!((recording.t[200] - 16.04).abs() < 1e-6, "{}", recording.t[200]);
    let many: Vec<(usize, Vec<u8>)> = (10..15)
        .map(|k| (2 * k, format!("{},0.02,0.{}", 0.02 * (2 * k - 1) as f64, 100 + k).into_bytes()))
        .collect();
    let many: Vec<(usize, &[u8])> = many.iter().map(|(line, text)| (*line, text.as_slice())).collect();
    let refused = parse("bad.csv", &garbled(&many), &options).unwrap_err().to_string();
    assert!(refused.contains("time stands still"), "{refused}");
}
