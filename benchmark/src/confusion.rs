//! What was concealed against what was answered, as a picture.

use crate::judge::Outcome;
use host_sim::effects::{every, named};
use host_sim::proof_case::Kind;
use std::fmt::Write as _;

/// Side of a cell, CSS pixels.
const CELL: usize = 22;
/// Room for the slanted names beyond the last column, CSS pixels.
const MARGIN: usize = 60;
/// Room for the names, CSS pixels.
const NAMES: usize = 165;

/// Rows and columns with counts.
struct Matrix {
    rows: Vec<&'static str>,
    columns: Vec<&'static str>,
    counts: Vec<Vec<usize>>,
}

const NOTHING: &str = "(nothing)";
/// Answers without a name of their own.
const OTHERS: [&str; 6] = [
    "ambiguous, right among ≤ 3",
    "ambiguous, wrong",
    "named with a remainder",
    "unlisted",
    "no_mismatch",
    "not_excited",
];

impl Matrix {
    /// Single effects, nothing, and what is outside; pairs have no place in it.
    fn new(outcomes: &[Outcome]) -> Self {
        let mut rows: Vec<&str> = every().map(|entry| entry.id).collect();
        rows.insert(named().count(), NOTHING);
        let columns: Vec<&str> = named().map(|entry| entry.id).chain(OTHERS).collect();
        let mut counts = vec![vec![0; columns.len()]; rows.len()];
        for outcome in outcomes.iter().filter(|o| o.kind != Kind::Pair) {
            let concealed = outcome.ids.first().map_or(NOTHING, String::as_str);
            let row = rows.iter().position(|row| *row == concealed);
            let column = columns.iter().position(|column| *column == answered(outcome));
            if let Some(count) = row.zip(column).and_then(|(r, c)| counts.get_mut(r)?.get_mut(c)) {
                *count += 1;
            }
        }
        let seen: Vec<bool> = counts.iter().map(|row: &Vec<usize>| row.iter().any(|n| *n > 0)).collect();
        let keep = |i: &usize| seen[*i];
        let rows_seen = (0..rows.len()).filter(keep).map(|i| rows[i]).collect();
        let counts = (0..rows.len()).filter(keep).map(|i| counts[i].clone()).collect();
        Self { rows: rows_seen, columns, counts }
    }
}

/// The column of an answer.
fn answered(outcome: &Outcome) -> &str {
    let outside = matches!(outcome.kind, Kind::Outside | Kind::Untouched);
    match outcome.verdict.as_str() {
        "named" if outside && outcome.unlisted => OTHERS[2],
        "named" => outcome.listed.first().map_or("", String::as_str),
        "ambiguous" if outcome.among_three => OTHERS[0],
        "ambiguous" => OTHERS[1],
        other => other,
    }
}

/// The picture.
pub fn svg(outcomes: &[Outcome]) -> String {
    let matrix = Matrix::new(outcomes);
    let (width, height) =
        (NAMES + CELL * matrix.columns.len() + MARGIN, NAMES + CELL * matrix.rows.len() + 8);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100%\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"What was concealed (rows) against what was answered (columns)\" font-size=\"11\">"
    );
    // writing to a string cannot fail
    for (c, name) in matrix.columns.iter().enumerate() {
        let (x, y) = (NAMES + c * CELL + CELL / 2 + 4, NAMES - 6);
        let turned = format!("transform=\"rotate(-60 {x} {y})\"");
        let _ = write!(out, "<text x=\"{x}\" y=\"{y}\" {turned} class=\"name\">{name}</text>");
    }
    for (r, name) in matrix.rows.iter().enumerate() {
        let (x, y) = (NAMES - 8, NAMES + r * CELL);
        let middle = y + CELL / 2 + 4;
        let _ =
            write!(out, "<text x=\"{x}\" y=\"{middle}\" text-anchor=\"end\" class=\"name\">{name}</text>");
        let whole: usize = matrix.counts[r].iter().sum();
        for (c, count) in matrix.counts[r].iter().enumerate() {
            out.push_str(&cell([NAMES + c * CELL, y], *count, whole, is_right(name, matrix.columns[c])));
        }
    }
    out.push_str("</svg>");
    out
}

/// Whether this answer is what one hopes for.
fn is_right(concealed: &str, answer: &str) -> bool {
    if named().any(|entry| entry.id == concealed) {
        return concealed == answer || answer == OTHERS[0];
    }
    if concealed == NOTHING { answer == "no_mismatch" } else { OTHERS[2..4].contains(&answer) }
}

/// One cell: the darker, the larger its share of the row; blue where the answer is right.
fn cell([x, y]: [usize; 2], count: usize, whole: usize, right: bool) -> String {
    let side = CELL - 2;
    let rect = |class: &str, more: &str| {
        format!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{side}\" height=\"{side}\" rx=\"3\" class=\"{class}\"{more}/>"
        )
    };
    let empty = rect("cell", "");
    if count == 0 {
        return if right { empty + &rect("goal", "") } else { empty };
    }
    let share = count as f64 / whole.max(1) as f64;
    let opacity = format!(" fill-opacity=\"{:.2}\"", 0.25 + 0.75 * share);
    let full = rect(if right { "right" } else { "wrong" }, &opacity);
    let (x, y) = (x + side / 2, y + side / 2 + 4);
    let class = if share > 0.4 { "on" } else { "name" };
    format!("{empty}{full}<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" class=\"{class}\">{count}</text>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::judge;
    use crate::judge::tests::{beside, said, truth};

    #[test]
    fn every_case_but_a_pair_is_counted_once_in_its_place() {
        let of = |kind: &str, ids: &[&str], verdict: &str, answer: &[&str]| {
            judge(&truth(kind, ids, "lab"), Some(&said(verdict, answer, &[])), &beside(&[]))
        };
        let outcomes = [
            of("effect", &["servo_lag"], "named", &["servo_lag"]),
            of("effect", &["servo_lag"], "named", &["gyro_lag"]),
            of("effect", &["servo_lag"], "ambiguous", &["servo_lag"]),
            of("nothing", &[], "no_mismatch", &[]),
            of("outside", &["gust_burst"], "unlisted", &["unlisted"]),
            of("pair", &["servo_lag", "gyro_lag"], "named", &["servo_lag"]),
        ];
        let matrix = Matrix::new(&outcomes);
        assert_eq!(matrix.rows, ["servo_lag", NOTHING, "gust_burst"]);
        let at = |row: &str, column: &str| {
            let row = matrix.rows.iter().position(|r| *r == row).unwrap();
            matrix.counts[row][matrix.columns.iter().position(|c| *c == column).unwrap()]
        };
        assert_eq!((at("servo_lag", "servo_lag"), at("servo_lag", "gyro_lag")), (1, 1));
        assert_eq!((at("servo_lag", OTHERS[0]), at(NOTHING, "no_mismatch")), (1, 1));
        assert_eq!(at("gust_burst", "unlisted"), 1);
        assert_eq!(matrix.counts.iter().flatten().sum::<usize>(), 5);
        assert_eq!(
            svg(&outcomes).matches("class=\"on\"").count()
                + svg(&outcomes).matches("\"middle\" class=\"name\"").count(),
            5
        );
    }
}
