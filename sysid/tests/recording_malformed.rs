//! Recordings that cannot be used: each error names the place, what was found and what to do.

use std::path::Path;

use sysid::error::{Error, ErrorKind};
use sysid::recording::{ReadOptions, Recording, parse, read};

/// 30 good rows at 50 Hz below `header`, which must be `t_s` and two more columns; row `k` on line `k + 2`.
fn file(header: &str, replace: &[(usize, &str)]) -> String {
    let mut text = format!("{header}\n");
    for k in 0..30 {
        let line = match replace.iter().find(|(row, _)| *row == k) {
            Some((_, line)) => (*line).to_owned(),
            None => format!(
                "{:.2},{},{:.3}",
                0.02 * f64::from(k as u32),
                0.01 * f64::from(k as u32 % 3),
                0.1 * f64::from(k as u32).sin()
            ),
        };
        text.push_str(&line);
        text.push('\n');
    }
    text
}

const HEADER: &str = "t_s,u_rad,q_rad_s";

fn refused(text: impl AsRef<[u8]>, options: &ReadOptions) -> Error {
    parse("bad.csv", text.as_ref(), options).expect_err("this recording must be refused")
}

struct Case {
    what: &'static str,
    text: Vec<u8>,
    kind: ErrorKind,
    line: Option<usize>,
    column: Option<&'static str>,
    /// Parts of the message: what was found, and the advice.
    says: &'static [&'static str],
}

fn case(
    what: &'static str,
    text: impl Into<Vec<u8>>,
    kind: ErrorKind,
    line: Option<usize>,
    column: Option<&'static str>,
    says: &'static [&'static str],
) -> Case {
    Case { what, text: text.into(), kind, line, column, says }
}

fn with_cell(row: &str) -> String {
    file(HEADER, &[(5, row)])
}

fn stretched(factor: f64) -> String {
    let rows = (0..30).map(|k| format!("{},{},{}\n", f64::from(k) * factor, k % 2, f64::from(k).sin()));
    std::iter::once(format!("{HEADER}\n")).chain(rows).collect()
}

fn header_cases() -> Vec<Case> {
    use ErrorKind::{Column, Format, TooShort};
    vec![
        case("empty", "", Format, None, None, &["the file is empty", "logger"]),
        case("comments only", "# a\n\n# b\n", Format, None, None, &["only comments", "logger"]),
        case(
            "header only",
            "t_s,u_rad,q_rad_s\n",
            TooShort,
            None,
            None,
            &["0 samples", "at least 20", "record longer"],
        ),
        case(
            "header and one row of rate and angle",
            "t_s,u_rad,q_rad_s,theta_rad\n0,0.1,0.2,0.3\n",
            TooShort,
            None,
            None,
            &["1 sample", "at least 20"],
        ),
        case(
            "no header",
            "0,0.1,0.2\n0.02,0.1,0.3\n",
            Column,
            Some(1),
            None,
            &["row of numbers", "from the left c1 to c3", "first line with the column names"],
        ),
        case(
            "no time",
            file("time,u_rad,q_rad_s", &[]),
            Column,
            Some(1),
            None,
            &["no column t_s among time", "--column 't_s=time'"],
        ),
        case(
            "time in capitals",
            file("T_s,u_rad,q_rad_s", &[]),
            Column,
            Some(1),
            None,
            &["no column t_s", "case-sensitive", "\"T_s\""],
        ),
        case(
            "no input",
            file("t_s,u,q_rad_s", &[]),
            Column,
            Some(1),
            None,
            &["no input column", "u_pct", "--column 'u_norm=u'"],
        ),
        case(
            "two inputs",
            file("t_s,u_rad,u_V", &[]),
            Column,
            Some(1),
            None,
            &["two input columns, u_rad and u_V", "--column u_rad=u_rad"],
        ),
        case(
            "no output",
            file("t_s,u_rad,gyro", &[]),
            Column,
            Some(1),
            None,
            &["neither pitch rate nor pitch angle", "--column 'q_rad_s=gyro'"],
        ),
        case(
            "double column",
            file("t_s,u_rad,u_rad", &[]),
            Column,
            Some(1),
            Some("u_rad"),
            &["two columns of this name", "rename"],
        ),
        case(
            "comment before the header",
            "# rig 3\nt_s,u_rad,u_rad\n",
            Column,
            Some(2),
            Some("u_rad"),
            &["two columns"],
        ),
        case(
            "decimal commas between commas",
            "t_s,u_rad,q_rad_s\n0,00,0,1,0,2\n",
            Format,
            Some(2),
            None,
            &["6 fields", "semicolons or tabs"],
        ),
        case(
            "a comma and a point in one number",
            "t_s;u_rad;q_rad_s\n1.234,5;0,1;0,2\n",
            ErrorKind::Value,
            Some(2),
            Some("t_s"),
            &["\"1.234,5\""],
        ),
        case(
            "open quote",
            with_cell("0.10,\"0.01,0.1"),
            Format,
            Some(7),
            None,
            &["a quote is opened", "close the quote"],
        ),
    ]
}

fn format_cases() -> Vec<Case> {
    use ErrorKind::Format;
    let mut latin1 = file(HEADER, &[]).into_bytes();
    latin1.extend(b"# 5 \xb0\n");
    assert!(latin1.contains(&0xb0));
    vec![
        case("ULog", *b"ULog\x01\x12\x35\x01", Format, None, None, &["PX4 flight log", "pitchid show"]),
        case(
            "blackbox",
            "H Product:Blackbox flight data recorder\n",
            Format,
            None,
            None,
            &["Betaflight", "pitchid show"],
        ),
        case("DataFlash", *b"\xa3\x95\x80\x80", Format, None, None, &["ArduPilot", "pitchid show"]),
        case(
            "spreadsheet",
            *b"PK\x03\x04rest",
            Format,
            None,
            None,
            &["spreadsheet", "save the sheet as CSV"],
        ),
        case(
            "other binary",
            *b"t_s\n\x01\x00\x02",
            Format,
            Some(2),
            None,
            &["binary file", "offset 5", "convert"],
        ),
        case(
            "Latin-1",
            latin1,
            Format,
            Some(32),
            None,
            &["not UTF-8: byte 0xb0 at offset", "save the file as UTF-8"],
        ),
        case(
            "too few fields",
            with_cell("0.10,0.01"),
            Format,
            Some(7),
            None,
            &["2 fields", "3 fields, as the header has", "cut off"],
        ),
        case(
            "too many fields",
            with_cell("0,10,0,01,0,3"),
            Format,
            Some(7),
            None,
            &["6 fields", "decimal comma"],
        ),
    ]
}

fn cell_cases() -> Vec<Case> {
    use ErrorKind::Value;
    let supervised = "t_s,u_rad,q_rad_s,supervised\n0,0,0,0\n0.02,0,0,2\n";
    vec![
        case(
            "text",
            with_cell("0.10,0.01,abc"),
            Value,
            Some(7),
            Some("q_rad_s"),
            &["found \"abc\"", "a finite number", "correct the cell"],
        ),
        case(
            "number with unit",
            with_cell("0.10,0.01 rad,0.1"),
            Value,
            Some(7),
            Some("u_rad"),
            &["0.01 rad", "units belong in the header"],
        ),
        case(
            "infinity",
            with_cell("0.10,0.01,-inf"),
            Value,
            Some(7),
            Some("q_rad_s"),
            &["found \"-inf\"", "delete the row"],
        ),
        case(
            "huge",
            with_cell("0.10,0.01,1e300"),
            Value,
            Some(7),
            Some("q_rad_s"),
            &["1e300", "beyond any measurement", "broken logger"],
        ),
        case(
            "overflow",
            with_cell("0.10,0.01,1e999"),
            Value,
            Some(7),
            Some("q_rad_s"),
            &["1e999", "beyond any measurement"],
        ),
        case(
            "decimal comma",
            with_cell("0.10,\"0,01\",0.1"),
            Value,
            Some(7),
            Some("u_rad"),
            &["0,01", "decimals with a point"],
        ),
        case(
            "clock time",
            with_cell("12:30:01,0.01,0.1"),
            Value,
            Some(7),
            Some("t_s"),
            &["12:30:01", "seconds"],
        ),
        case(
            "supervised",
            supervised,
            Value,
            Some(3),
            Some("supervised"),
            &["found \"2\"", "0 or 1", "delete the column"],
        ),
        case(
            "blank lines and comments count",
            "\n# x\n\nt_s,u_rad,q_rad_s\n\n# y\n0,0,x\n",
            Value,
            Some(7),
            Some("q_rad_s"),
            &["\"x\""],
        ),
        case(
            "CRLF",
            "t_s,u_rad,q_rad_s\r\n0,0,1\r\n0.02,0,y\r\n",
            Value,
            Some(3),
            Some("q_rad_s"),
            &["\"y\""],
        ),
    ]
}

fn clock_cases() -> Vec<Case> {
    use ErrorKind::{Clock, TooShort};
    let gappy: String =
        (0..40).map(|k| format!("{},0,{}\n", f64::from(k) * 0.02 + f64::from(k / 10), k)).collect();
    let gappy = format!("{HEADER}\n{gappy}");
    vec![
        case(
            "time stands still",
            with_cell("0.08,0.01,0.7"),
            Clock,
            Some(7),
            Some("t_s"),
            &["stands still at 0.08 s", "more decimals"],
        ),
        case(
            "time backwards",
            with_cell("0.03,0.01,0.7"),
            Clock,
            Some(7),
            Some("t_s"),
            &["runs backwards: 0.03 s after 0.08 s", "separate them"],
        ),
        case(
            "milliseconds",
            stretched(20.0),
            Clock,
            Some(3),
            Some("t_s"),
            &["a step of 20", "milliseconds", "--column 't_s=t_s*0.001'"],
        ),
        case(
            "microseconds",
            stretched(20_000.0),
            Clock,
            Some(3),
            Some("t_s"),
            &["microseconds", "t_s*0.000001"],
        ),
        case("nanoseconds", stretched(2e7), Clock, Some(3), Some("t_s"), &["nanoseconds"]),
        case("tiny step", stretched(1e-9), Clock, Some(3), Some("t_s"), &["a step of 0.000000 s", "seconds"]),
        case(
            "too short",
            "t_s,u_rad,q_rad_s\n0,0,1\n0.02,1,2\n0.04,0,1\n",
            TooShort,
            None,
            None,
            &["3 samples", "at least 20", "record longer"],
        ),
        case("gaps everywhere", gappy, TooShort, None, None, &["gaps every few samples", "10 samples"]),
    ]
}

#[test]
fn every_malformed_recording_gets_a_message_for_people() {
    let cases: Vec<Case> =
        [header_cases(), format_cases(), cell_cases(), clock_cases()].into_iter().flatten().collect();
    assert!(cases.len() >= 40);
    for case in cases {
        let error = refused(&case.text, &ReadOptions::default());
        let message = error.to_string();
        assert_eq!(error.kind, case.kind, "{}: {message}", case.what);
        assert_eq!(error.line, case.line, "{}: {message}", case.what);
        assert_eq!(error.column.as_deref(), case.column, "{}: {message}", case.what);
        assert!(message.starts_with("bad.csv"), "{}: {message}", case.what);
        assert!(!error.advice.is_empty() && message.lines().count() <= 3, "{}: {message}", case.what);
        for part in case.says {
            assert!(message.contains(part), "{}: {part:?} is not in\n{message}", case.what);
        }
        if let Some(line) = case.line {
            assert!(message.contains(&format!("line {line}")), "{message}");
        }
    }
}

#[test]
fn options_that_fit_nothing_are_refused() {
    let good = file("t_s,u_rad,gy", &[]);
    let map = |text: &str| ReadOptions { columns: vec![text.parse().unwrap()], ..ReadOptions::default() };
    let with = |change: fn(&mut ReadOptions)| {
        let mut options = map("q_rad_s=gy");
        change(&mut options);
        options
    };
    let cases: [(ReadOptions, &[&str]); 6] = [
        (map("q_rad_s=gyro"), &["--column q_rad_s=gyro", "no column \"gyro\"", "one of gy, u_rad, t_s"]),
        (with(|o| o.columns.push("q_rad_s=u_rad".parse().unwrap())), &["q_rad_s twice", "keep one"]),
        (with(|o| o.splits = vec![99.0]), &["--split 99", "0 to 0.58 s", "seconds"]),
        (
            with(|o| o.sections = vec!["IV=5..9".parse().unwrap()]),
            &["--section IV=5..9", "no sample there", "0 to 0.58"],
        ),
        (
            with(|o| o.sections = vec!["I=0..0.3".parse().unwrap(), "II=0.2..0.5".parse().unwrap()]),
            &["I and --section II overlap"],
        ),
        (
            with(|o| (o.splits, o.sections) = (vec![0.2], vec!["I=0..0.3".parse().unwrap()])),
            &["both --split and --section"],
        ),
    ];
    for (options, says) in cases {
        let error = refused(&good, &options);
        for part in says {
            assert!(error.to_string().contains(part), "{part:?} is not in\n{error}");
        }
    }
}

#[test]
fn a_section_that_is_not_there_and_one_that_is_too_short() {
    let recording: Recording = parse("a.csv", file(HEADER, &[]).as_bytes(), &ReadOptions::default()).unwrap();
    let error = recording.section("IV").unwrap_err();
    assert_eq!(error.kind, ErrorKind::Section);
    assert!(error.to_string().contains("no section \"IV\"\n  expected: one of all"), "{error}");
    let all = recording.section("all").unwrap();
    recording.require(all, 30, "PI-MOESP").unwrap();
    let error = recording.require(all, 31, "PI-MOESP").unwrap_err();
    assert_eq!(error.kind, ErrorKind::TooShort);
    assert!(error.to_string().contains("a.csv: 30 samples (0.600 s)"), "{error}");
    assert!(error.to_string().contains("31 samples in section all, for PI-MOESP"), "{error}");
}

#[test]
fn files_that_cannot_be_opened() {
    let error = read(Path::new("no/such/file.csv"), &ReadOptions::default()).unwrap_err();
    assert_eq!(error.kind, ErrorKind::File);
    assert!(error.to_string().starts_with("no/such/file.csv: no such file"), "{error}");
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let error = read(here, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("this is a directory"), "{error}");
}

#[test]
fn everything_that_is_wrong_with_a_file_is_told_in_one_run() {
    let cells = ["0.10,x,0.1", "0.12,0.01,1e99", "0.14,0.01", "0.16,ab,cd"];
    let replaced: Vec<(usize, &str)> = cells.iter().enumerate().map(|(k, row)| (k + 5, *row)).collect();
    let error = refused(file(HEADER, &replaced), &ReadOptions::default());
    let message = error.to_string();
    assert_eq!((error.line, error.others().count()), (Some(7), 4), "{message}");
    for part in [
        "line 7, column u_rad: found \"x\"",
        "also: line 8, column q_rad_s: found \"1e99\"",
        "also: line 9: 2 fields",
    ] {
        assert!(message.contains(part), "{part:?} is not in\n{message}");
    }
    assert!(message.ends_with("also: line 10, column q_rad_s: found \"cd\""), "{message}");

    let text = "t_s,u_rad,q_rad_s\n".to_owned() + &"0.1,one,two\n".repeat(30);
    let message = refused(&text, &ReadOptions::default()).to_string();
    assert_eq!(message.matches("found \"").count(), 20, "{message}");
    assert!(message.ends_with("also: and 40 more"), "{message}");

    let back = [(5, "0.01,0.01,0.1"), (15, "0.02,0.01,0.1")];
    let error = refused(file(HEADER, &back), &ReadOptions::default());
    assert_eq!((error.line, error.others().count()), (Some(7), 1), "{error}");
    assert!(error.to_string().contains("also: line 17, column t_s"), "{error}");
}
