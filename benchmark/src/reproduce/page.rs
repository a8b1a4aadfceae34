//! The tables, and the page with them.

use super::study::{Paper, Spread, Study};
use std::fmt::Write as _;
use sysid::identify::compare::Identification;

/// Columns of [`rows`].
pub const HEADER: [&str; 5] = ["method", "closed loop (IV)", "paper", "unused PRBS", "paper"];
/// Columns of [`errors`].
pub const ERRORS_HEADER: [&str; 3] = ["", "error of ∂M/∂q, %", "error of ∂M/∂u, %"];
/// The paper's Table 2, %: method, closed loop, PRBS.
const TABLE_2: [(&str, f64, f64); 4] = [
    ("LMS FIR + Kung", 23.3, 71.5),
    ("PI-MOESP", 64.4, 71.0),
    ("grey-box ML", 58.4, 64.9),
    ("H∞ match", 60.1, 64.1),
];
/// The paper's agreement of the H∞ match with PI-MOESP, %.
const AGREEMENT: f64 = 96.9;

/// The page.
pub fn markdown(paper: &Paper, shown: &Identification, given: Option<&Identification>) -> String {
    let mut page = format!(
        "# The paper's Table 2 and figures, in the simulator\n\n\
         Campaign {}, {} seeds for each condition. VAF of the free run in %, median and middle 80 % of the seeds. Each \
         method learns from section I of three tests (0.012, 0.015, 0.019 rad), and is judged by sections IV and II of the \
         second.\n",
        paper.campaign, paper.seeds
    );
    for study in &paper.studies {
        let _ =
            write!(page, "\n## {}\n\n{}.\n\n", capital(study.condition.told()), capital(&supervised(study)));
        page.push_str(&table(&HEADER, &rows(study)));
        let _ = write!(page, "\n{}\n\n", agreement(study));
        page.push_str(&table(&ERRORS_HEADER, &errors(study)));
    }
    page.push_str("\n## The first realistic campaign\n\n");
    for (file, caption) in [
        ("figure6.svg", "Figure 6: closed loop (section IV), measured and simulated."),
        ("figure7.svg", "Figure 7: unused PRBS, measured and simulated."),
        (
            "figure8.svg",
            "Figure 8: responses of the PI-MOESP model and of the grey box matched to it, to the same PRBS.",
        ),
        (
            "bode.svg",
            "Gain of every model, of the data without a model, and the 95 % band of the PI-MOESP model (bootstrap).",
        ),
        ("choice.svg", "Cross-validated VAF of PI-MOESP over block size, for each order."),
    ] {
        let _ = write!(page, "![{caption}]({file})\n\n{caption}\n\n");
    }
    if let Some(subspace) = &shown.subspace {
        let _ = writeln!(page, "{}", subspace.reason);
    }
    if let Some(given) = given {
        let columns: Vec<&str> =
            ["method", ""].into_iter().chain(given.held_out.iter().map(String::as_str)).collect();
        let rows: Vec<Vec<String>> = given
            .methods
            .iter()
            .map(|method| {
                let vaf = |label: &String| method.vaf_percent.get(label).map_or("-".into(), |v| percent(*v));
                let own = [method.name.clone(), method.detail.clone()];
                own.into_iter().chain(given.held_out.iter().map(vaf)).collect()
            })
            .collect();
        let _ = write!(page, "\n## The given recordings\n\n{}", table(&columns, &rows));
    }
    page
}

/// VAF of every method, under [`HEADER`].
#[must_use]
pub fn rows(study: &Study) -> Vec<Vec<String>> {
    study
        .methods()
        .into_iter()
        .map(|method| {
            let printed = TABLE_2.iter().find(|(name, ..)| *name == method);
            let paper = |value: Option<f64>| value.map_or(String::new(), percent);
            vec![
                method.to_owned(),
                spread(study, study.spread(method, |m| m.closed_loop)),
                paper(printed.map(|(_, closed, _)| *closed)),
                spread(study, study.spread(method, |m| m.prbs)),
                paper(printed.map(|(.., prbs)| *prbs)),
            ]
        })
        .collect()
}

/// Relative errors of the grey boxes, under [`ERRORS_HEADER`].
#[must_use]
pub fn errors(study: &Study) -> Vec<Vec<String>> {
    let of = |method: &str| {
        vec![
            method.to_owned(),
            spread(study, study.error(method, |e| e.dm_dq_percent)),
            spread(study, study.error(method, |e| e.dm_du_percent)),
        ]
    };
    study.grey_boxes().into_iter().map(of).collect()
}

/// "61.3 (55.0 to 66.2)", and how many seeds gave no stable model.
fn spread(study: &Study, spread: Option<Spread>) -> String {
    let Some(Spread { median, range: [low, high], count }) = spread else { return "-".into() };
    let missing = study.seeds.len() - count;
    let note = if missing > 0 { format!(", {missing} unstable") } else { String::new() };
    format!("{} ({} to {}{note})", percent(median), percent(low), percent(high))
}

/// How much of the data was left out, in words.
#[must_use]
pub fn supervised(study: &Study) -> String {
    let share = Spread::of(study.seeds.iter().map(|s| 100.0 * s.supervised));
    let share = share.map_or(0.0, |s| s.median);
    format!("{share:.0} % of the rows to learn from were overridden by the supervisor, and left out")
}

/// How well the H∞ match follows PI-MOESP, in words.
#[must_use]
pub fn agreement(study: &Study) -> String {
    let found = spread(study, study.agreement());
    format!(
        "Responses of the H∞ match and of PI-MOESP to the PRBS agree to a VAF of {found} % (paper: {AGREEMENT})."
    )
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Per cent with one decimal; nobody wants to read "-0.0".
fn percent(x: f64) -> String {
    let shown = format!("{x:.1}");
    if shown == "-0.0" { "0.0".into() } else { shown }
}

/// A table in Markdown.
fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = format!("| {} |\n|{}\n", header.join(" | "), " --- |".repeat(header.len()));
    for row in rows {
        let _ = writeln!(table, "| {} |", row.join(" | "));
    }
    table
}
