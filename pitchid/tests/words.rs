//! What is printed can be read by a stranger: the outputs of the real binary, word by word.

#[path = "support/command.rs"]
mod command;

use command::run;
use std::path::Path;

/// Things that are counted.
const COUNTED: [&str; 9] =
    ["samples", "rows", "gaps", "cycles", "sections", "columns", "flights", "spans", "files"];
/// What no answer says.
const NEVER: [&str; 8] = ["dull", "is borne", "N m/1", "looked at at", "NaN", "Some(", "None", "inf "];
/// Names of products that look like names of a program's inside.
const PRODUCTS: [&str; 3] = ["DataFlash", "PlotJuggler", "ArduPilot"];
/// Most significant digits of a number.
const DIGITS: usize = 9;

/// What is wrong with a text, with the line of it.
fn faults(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in text.lines() {
        found.extend(NEVER.iter().filter(|word| line.contains(**word)).map(|word| format!("{word}: {line}")));
        let words: Vec<&str> = line.split_whitespace().collect();
        for (place, word) in words.iter().enumerate() {
            let bare = word
                .trim_matches(|c: char| !c.is_alphanumeric() && !"-−+.".contains(c))
                .trim_end_matches('.');
            let number: Option<f64> = bare.replace('−', "-").parse().ok();
            let negative = bare.starts_with(['-', '−']);
            if number == Some(0.0) && negative {
                found.push(format!("a minus before a zero: {line}"));
            }
            let mantissa = bare.split(['e', 'E']).next().unwrap_or_default();
            let digits = mantissa.trim_start_matches(|c: char| !c.is_ascii_digit() || c == '0');
            if number.is_some()
                && bare.contains('.')
                && digits.chars().filter(char::is_ascii_digit).count() > DIGITS
            {
                found.push(format!("too many digits: {line}"));
            }
            if bare == "1"
                && words.get(place + 1).is_some_and(|next| COUNTED.iter().any(|what| next.starts_with(what)))
            {
                found.push(format!("one of several: {line}"));
            }
            if is_inside(bare) {
                found.push(format!("a name of the program's inside: {line}"));
            }
        }
    }
    found
}

/// Whether a word is written as programs write names: `NotExcited`.
fn is_inside(word: &str) -> bool {
    let letters: Vec<char> = word.chars().collect();
    let humps = letters.windows(2).filter(|pair| pair[0].is_lowercase() && pair[1].is_uppercase()).count();
    letters.iter().all(char::is_ascii_alphabetic)
        && letters.first().is_some_and(|c| c.is_uppercase())
        && humps > 0
        && !PRODUCTS.contains(&word)
}

#[test]
fn faults_are_seen() {
    for text in
        ["from -0.000 to 3 s", "−0.0", "1 rows", "0.12345678901234", "NotExcited: 3", "N m/1", "(1 samples)"]
    {
        assert!(!faults(text).is_empty(), "{text}");
    }
    for text in [
        "-0.5",
        "11 rows",
        "1 row",
        "0.000",
        "PI-MOESP dM_du",
        "1e-12",
        "ArduPilot DataFlash",
        "--axis",
        "- a note",
    ] {
        assert!(faults(text).is_empty(), "{text}: {:?}", faults(text));
    }
}

/// A recording that begins before zero, misses a second, and turns to degrees.
fn odd(folder: &Path) {
    let mut text = "t_s,u_norm,q_deg_s\n".to_owned();
    for k in (0..1500).filter(|k| !(700..750).contains(k)) {
        let t = 0.02 * f64::from(k);
        let u = if (k / 40) % 2 == 0 { 0.1 } else { -0.1 };
        text += &format!("{:.6},{u},{:.4}\n", t - 0.000_04, 30.0 * (2.0 * t).sin() + 0.1 * f64::from(k % 3));
    }
    std::fs::write(folder.join("odd.csv"), text).unwrap();
}

#[test]
fn every_command_speaks_plainly() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    odd(folder);
    let all: [&[&str]; 16] = [
        &["simulate", "--effect", "coulomb_friction:Mc=0.1", "--seed", "5", "--out", "flight.csv"],
        &["simulate", "--seed", "4", "--background", "paper", "--out", "other.csv"],
        &["show", "flight.csv"],
        &["show", "odd.csv"],
        &["doctor", "flight.csv", "odd.csv", "nowhere.csv"],
        &["doctor"],
        &["identify", "flight.csv", "--monitor-out", "craft.toml", "--report", "identified.html"],
        &["identify", "odd.csv"],
        &["diagnose", "flight.csv", "--out-model", "extended.toml"],
        &["diagnose", "other.csv"],
        &["diagnose", "odd.csv"],
        &["compare", "flight.csv", "other.csv"],
        &["monitor", "other.csv", "--monitor", "craft.toml"],
        &["convert", "odd.csv", "odd.mat"],
        &["identify", "flight.csv", "--time", "0..0.1"],
        &["demo", "--seed", "3"],
    ];
    let mut found = Vec::new();
    for arguments in all {
        let (_, out, err) = run(folder, arguments);
        found.extend(
            faults(&(out + &err))
                .into_iter()
                .map(|fault| format!("pitchid {}: {fault}", arguments.join(" "))),
        );
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn every_help_speaks_plainly() {
    let folder = tempfile::tempdir().unwrap();
    let (_, help, _) = run(folder.path(), &["--help"]);
    let commands =
        help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // what goes on from the line before is indented further
    let own = commands.filter(|line| line.chars().take_while(|c| *c == ' ').count() == 2);
    let names: Vec<&str> = own.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.contains(&"doctor") && names.len() > 12, "{names:?}");
    for name in names {
        let (_, help, _) = run(folder.path(), &["help", name]);
        let found: Vec<String> =
            faults(&help).into_iter().filter(|fault| !fault.starts_with("a minus")).collect();
        assert!(found.is_empty(), "{name}: {}", found.join("\n"));
        let asks = ["Examples:", "Example:", "Commands:", "pitchid "].iter().any(|word| help.contains(word));
        assert!(asks, "{name} has no example: {help}");
    }
}
