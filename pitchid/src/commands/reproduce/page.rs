//! The tables, on the terminal and as a page.

use super::study::{Paper, Spread, Study};
use crate::{format, text};
use std::fmt::Write as _;
use sysid::identify::compare::Identification;

/// The paper's Table 2, %: method, closed loop, PRBS.
const TABLE_2: [(&str, f64, f64); 4] = [
    ("LMS FIR + Kung", 23.3, 71.5),
    ("PI-MOESP", 64.4, 71.0),
    ("grey-box ML", 58.4, 64.9),
    ("H∞ match", 60.1, 64.1),
];
/// The paper's agreement of the H∞ match with PI-MOESP, %.
const AGREEMENT: f64 = 96.9;

/// What a terminal shows.
pub fn terminal(paper: &Paper, given: Option<&Identification>) -> String {
    let mut shown = String::new();
    for study in &paper.studies {
        let _ =
            writeln!(shown, "\n{}; {} campaigns, {}", study.condition.told(), paper.seeds, supervised(study));
        shown.push_str(&text::table(&header(), rows(study), 1));
        shown.push_str(&text::paragraph(&agreement(study)));
        shown.push_str(&text::table(&["", "error of ∂M/∂q, %", "error of ∂M/∂u, %"], errors(study), 1));
    }
    if let Some(given) = given {
        shown.push_str("\nThe given recordings\n");
        shown.push_str(&text::methods(given));
    }
    shown
}

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
        page.push_str(&table(&header(), &rows(study)));
        let _ = write!(page, "\n{}\n\n", agreement(study));
        page.push_str(&table(&["", "error of ∂M/∂q, %", "error of ∂M/∂u, %"], &errors(study)));
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
                let vaf = |label: &String| {
                    method.vaf_percent.get(label).map_or("-".into(), |v| format::percent(*v))
                };
                let own = [method.name.clone(), method.detail.clone()];
                own.into_iter().chain(given.held_out.iter().map(vaf)).collect()
            })
            .collect();
        let _ = write!(page, "\n## The given recordings\n\n{}", table(&columns, &rows));
    }
    page
}

fn header() -> [&'static str; 5] {
    ["method", "closed loop (IV)", "paper", "unused PRBS", "paper"]
}

fn rows(study: &Study) -> Vec<Vec<String>> {
    study
        .methods()
        .into_iter()
        .map(|method| {
            let printed = TABLE_2.iter().find(|(name, ..)| *name == method);
            let paper = |value: Option<f64>| value.map_or(String::new(), format::percent);
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

fn errors(study: &Study) -> Vec<Vec<String>> {
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
    format!("{} ({} to {}{note})", format::percent(median), format::percent(low), format::percent(high))
}

fn supervised(study: &Study) -> String {
    let share = Spread::of(study.seeds.iter().map(|s| 100.0 * s.supervised));
    let share = share.map_or(0.0, |s| s.median);
    format!("{share:.0} % of the rows to learn from were overridden by the supervisor, and left out")
}

fn agreement(study: &Study) -> String {
    let found = spread(study, study.agreement());
    format!(
        "Responses of the H∞ match and of PI-MOESP to the PRBS agree to a VAF of {found} % (paper: {AGREEMENT})."
    )
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A table in Markdown.
fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let mut table = format!("| {} |\n|{}\n", header.join(" | "), " --- |".repeat(header.len()));
    for row in rows {
        let _ = writeln!(table, "| {} |", row.join(" | "));
    }
    table
}
