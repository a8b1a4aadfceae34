//! Text files as programs other than this one lay them out.

use sysid::recording::{ReadOptions, Recording, parse};

fn parsed(text: impl AsRef<[u8]>, columns: &[&str]) -> Result<Recording, sysid::error::Error> {
    let columns = columns.iter().map(|map| map.parse().unwrap()).collect();
    parse("a.txt", text.as_ref(), &ReadOptions { columns, ..ReadOptions::default() })
}

const ROWS: usize = 200;

/// Time in s, an angle in degrees, a command of 0 and 1, in a line of this form.
fn rows(line: impl Fn(f64, f64, usize) -> String) -> String {
    (0..ROWS).map(|k| line(0.02 * k as f64, (0.05 * k as f64).sin(), k % 7 % 2) + "\n").collect()
}

#[track_caller]
fn is_read(text: impl AsRef<[u8]>, columns: &[&str]) -> Recording {
    let read = parsed(text, columns).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read.len(), ROWS);
    assert!((read.step - 0.02).abs() < 1e-6, "{}", read.step);
    assert_eq!(read.u[..8], [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
    assert!((read.theta.as_ref().unwrap()[10] - 0.5_f64.sin().to_radians()).abs() < 1e-4);
    read
}

fn says(read: &Recording, text: &str) -> bool {
    read.notes.iter().any(|note| note.text.contains(text))
}

const BY_PLACE: [&str; 3] = ["t_s=c1", "theta_deg=c2", "u_norm=c3"];
const BY_NAME: [&str; 3] = ["t_s=time", "theta_deg=angle", "u_norm=pwm"];

#[test]
fn columns_without_a_header_are_called_by_their_places() {
    let text = rows(|t, angle, u| format!("{:.0},{angle:.4},{u},", 1000.0 * t));
    let read = is_read(&text, &["t_s=c1/1000", "theta_deg=c2", "u_norm=c3"]);
    assert!(says(&read, "the file has no header: from the left its columns are c1 to c4"));

    let refused = parsed(&text, &["t_s=c1/1000", "u_norm=c9"]).unwrap_err().to_string();
    assert!(refused.contains("the file has no column \"c9\""), "{refused}");
    let refused = parsed(&text, &["t_s=c1/1000", "u_norm=c3"]).unwrap_err().to_string();
    assert!(refused.contains("neither pitch rate nor pitch angle among c1, c2, c3, c4"), "{refused}");
}

#[test]
fn columns_stand_between_blanks() {
    let text = rows(|t, angle, u| format!("  {t:.6e}   {angle:.4} {u}"));
    let read = is_read(&text, &BY_PLACE);
    assert!(says(&read, "columns separated by blanks"), "{:?}", read.notes);
    is_read(format!("time angle pwm\n{text}"), &BY_NAME);
    let read = is_read(format!("time (s)  angle (deg)  pwm\n{text}"), &BY_PLACE);
    assert!(says(&read, "line 1 is not of the table: \"time (s)  angle (deg)  pwm\""), "{:?}", read.notes);
    let decimal = rows(|t, angle, u| format!("{t:.3} {angle:.4} {u}")).replace('.', ",");
    is_read(decimal, &BY_PLACE);
}

#[test]
fn names_may_stand_in_a_comment() {
    let text = rows(|t, angle, u| format!("{t:.4} {angle:.4} {u}"));
    is_read(format!("# rig 3\n# time angle pwm\n{text}"), &BY_NAME);
    is_read(format!("# time angle pwm\n{text}"), &BY_PLACE);
    let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u}"));
    is_read(format!("%time,angle,pwm\n{text}"), &BY_NAME);
    is_read(format!("# written at 12 o'clock, by hand\n{text}"), &BY_PLACE);
}

#[test]
fn what_stands_above_the_table_is_left_out() {
    let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u}"));
    let read = is_read(format!("Step test\nRate,50\n\ntime,angle,pwm\ns,deg,-\n{text}"), &BY_NAME);
    assert!(says(&read, "line 1 is not of the table: \"Step test\" and 2 more"), "{:?}", read.notes);
    is_read(format!("time,angle,pwm\n[s],[deg],\n{text}"), &BY_NAME);
    let read = is_read(format!("begin\n{text}"), &BY_PLACE);
    assert!(says(&read, "the file has no header"), "{:?}", read.notes);
    let refused = parsed(format!("begin\n{text}"), &[]).unwrap_err().to_string();
    assert!(
        refused.contains("no line that names the 3 columns") && refused.contains("c1 to c3"),
        "{refused}"
    );
}

#[test]
fn the_table_is_where_most_lines_are_rows_of_it() {
    let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u}"));
    let settings: String = (0..300).map(|k| format!("Setting {k}: value {k}\n")).collect();
    is_read(format!("{settings}time,angle,pwm\n{text}"), &BY_NAME);
    // rows of another table, and columns in groups under a rule
    is_read(format!("-0.06,1,2\n-0.04,1,3\ntime,angle,pwm\n{text}"), &BY_NAME);
    is_read(format!("encoder,encoder,motor\n----,----,----\ntime,angle,pwm\n{text}"), &BY_NAME);
    let text_by_tabs = rows(|t, angle, u| format!("{t:.4}\t{angle:.4}\t{u}"));
    let preamble = "LabVIEW Measurement\t\nWriter_Version\t2\n***End_of_Header***\t\t\n";
    is_read(format!("{preamble}X_Value\tA\tB\tComment\n{text_by_tabs}"), &BY_PLACE);
    let oscilloscope = "Model,DPO2014\nPoints,200\n\n";
    is_read(format!("{oscilloscope}time,angle,pwm\n{text}"), &BY_NAME);
    is_read(format!("time,angle,pwm,\n{text}"), &BY_NAME);
    is_read(format!("34,-0.01\n{text}"), &BY_PLACE);
    // what is garbled among the first rows is no header
    let mut lines: Vec<&str> = text.lines().collect();
    lines.insert(2, "#.7,##,?");
    lines.insert(3, "?,##,?");
    is_read(format!("time,angle,pwm\n{}\n", lines.join("\n")), &BY_NAME);
    let numbered = rows(|t, angle, u| format!("{:.0},{t:.4},{angle:.4},{u}", 50.0 * t));
    is_read(format!(",0,1,2\n{numbered}"), &["t_s=c2", "theta_deg=c3", "u_norm=c4"]);
}

#[test]
fn a_row_without_any_number_is_no_header() {
    for missing in [",,", "nan,nan,nan"] {
        let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u}"));
        let mut lines: Vec<&str> = text.lines().collect();
        lines.insert(15, missing);
        is_read(lines.join("\n") + "\n", &BY_PLACE);
    }
    // as many of them as rows, and time that is linear in these
    let sparse = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u}\n,,\n,,"));
    is_read(sparse, &BY_PLACE);
}

#[test]
fn of_several_lines_of_names_that_with_those_that_are_asked_for_counts() {
    let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u},0,0"));
    is_read(format!("Rig,A,bench,3b,x\ntime,angle,pwm,a,b\n{text}"), &BY_NAME);
    is_read(format!("time,angle,pwm,a,a\ns,deg,one,V,A\n{text}"), &BY_NAME);
    let text = rows(|t, angle, u| format!("{t:.4} {angle:.4} {u}"));
    is_read(format!("# time angle pwm\n# s deg -\n\n{text}"), &BY_NAME);
    let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u},"));
    is_read(format!("Step test\ntime,angle,pwm\n{text}"), &BY_NAME);
}

#[test]
fn a_terminal_puts_the_time_before_each_line() {
    let clock = |t: f64| format!("23:59:{:06.3}", t + 50.0);
    let stamped = |between: &'static str| {
        (0..ROWS)
            .map(|k| {
                let (t, angle, u) = (0.02 * k as f64, (0.05 * k as f64).sin(), k % 7 % 2);
                format!("{}{between}{angle:.4},{u}\n", clock(t))
            })
            .collect::<String>()
    };
    let columns = ["t_s=clock", "theta_deg=angle", "u_norm=pwm"];
    for between in [" -> ", " ", "\t"] {
        let text = stamped(between);
        let read = is_read(format!("23:59:49.900{between}angle,pwm\n{text}"), &columns);
        assert!(says(&read, "it is the column clock"), "{:?}", read.notes);
        is_read(format!("angle,pwm\n{text}"), &columns);
        is_read(text, &["t_s=c1", "theta_deg=c2", "u_norm=c3"]);
    }
}

#[test]
fn a_number_is_a_name_and_a_row_may_have_a_label() {
    let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u}"));
    is_read(format!("time,angle,1\n{text}"), &["t_s=time", "theta_deg=angle", "u_norm=c3"]);
    let labelled = rows(|t, angle, u| format!("run,{t:.4},{angle:.4},{u}"));
    is_read(labelled, &["t_s=c2", "theta_deg=c3", "u_norm=c4"]);
}

#[test]
fn a_row_may_end_with_a_separator_that_the_header_lacks() {
    is_read("time,angle,pwm\n".to_owned() + &rows(|t, angle, u| format!("{t:.4},{angle:.4},{u},")), &BY_NAME);
}

#[test]
fn columns_of_one_name_are_called_by_their_places() {
    let text = rows(|t, angle, u| format!("{t:.4},{angle:.4},{u}"));
    is_read(format!("time,value,value\n{text}"), &["t_s=time", "theta_deg=c2", "u_norm=c3"]);
}

#[test]
fn time_may_be_the_time_of_day() {
    let clock = |t: f64| format!("{:02}:{:06.3}", (59.0 + t / 60.0) as u32 % 60, (t + 0.5) % 60.0);
    let text = rows(|t, angle, u| format!("23:{},{angle:.4},{u}", clock(t)));
    is_read(format!("time,angle,pwm\n{text}"), &BY_NAME);
    let parts =
        rows(|t, angle, u| format!("23:{},{:.0},{angle:.4},{u}", &clock(t)[..5], 1000.0 * (t + 0.5).fract()));
    is_read(parts, &["t_s=c1+c2/1000", "theta_deg=c3", "u_norm=c4"]);
    let text = rows(|t, angle, u| format!("2024-05-03 23:{},{angle:.4},{u}", clock(t)));
    is_read(&text, &BY_PLACE);
}

#[test]
fn other_programs_encode_otherwise() {
    let text = "time;angle °;pwm\n".to_owned() + &rows(|t, angle, u| format!("{t:.4};{angle:.4};{u}"));
    let latin_1: Vec<u8> = text.chars().map(|c| c as u8).collect();
    is_read(latin_1, &["t_s=time", "theta_deg=c2", "u_norm=pwm"]);
    let utf_16: Vec<u8> =
        "\u{feff}".chars().chain(text.chars()).flat_map(|c| (c as u16).to_le_bytes()).collect();
    is_read(utf_16, &["t_s=time", "theta_deg=c2", "u_norm=pwm"]);
}
