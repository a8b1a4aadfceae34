//! The report of a proof: one HTML file that needs nothing else.

use crate::confusion;
use crate::html::Document;
use crate::judge::Outcome;
use crate::tally::Table;
use host_sim::Air;
use maud::{Markup, PreEscaped, html};

const STYLE: &str = include_str!("proof.css");

/// Renders the report.
pub fn html(outcomes: &[Outcome], tables: &[Table], seed: u64, air: Air) -> String {
    let body = html! {
        header {
            p .verdict { "Proof" }
            h1 { "What was concealed, and what was found" }
            p { (lead(outcomes)) }
        }
        h2 { "Concealed against answered" }
        figure {
            (PreEscaped(confusion::svg(outcomes)))
            figcaption {
                "Rows: what was concealed. Columns: what the diagnosis answered. Blue: right, or for what is outside the catalogue \
                 “unlisted”, or named with a remainder. Orange: anything else. The stronger the colour, the larger the share of the \
                 row. Pairs are in their table."
            }
        }
        @for table in tables { (table_of(table)) }
        details {
            summary { "Every case" }
            div .table { table .list {
                thead { tr { th { "case" } th { "concealed" } th { "size" } th { "background" } th { "answered" } } }
                tbody { @for outcome in outcomes { (case(outcome)) } }
            } }
        }
        footer {
            "To repeat it: " code { (command(outcomes.len(), seed, air)) } ". Same seed, same bytes. pitchid "
            (env!("CARGO_PKG_VERSION")) "."
        }
    };
    Document { title: "pitchid: proof", style: STYLE, body, json: None }.html(false)
}

fn table_of(table: &Table) -> Markup {
    html! {
        h2 { (table.title) }
        @if !table.note.is_empty() { p .soft.small { (table.note) } }
        div .table { table {
            thead { tr { @for cell in &table.header { th { (cell) } } } }
            tbody { @for row in &table.rows { tr { @for cell in row { td { (cell) } } } } }
        } }
    }
}

/// How to do it again.
pub fn command(cases: usize, seed: u64, air: Air) -> String {
    let air = if air == Air::default() { String::new() } else { format!(" --air {air}") };
    format!("pitchid prove --cases {cases} --seed {seed}{air}")
}

/// What it was, in a sentence.
pub fn lead(outcomes: &[Outcome]) -> String {
    format!(
        "{} cases: a simulator concealed physics, sealed the truth with a hash, and the diagnosis was given the recording and a nominal \
         model alone. Plants, sizes, excitation and noise were drawn by a seed.",
        outcomes.len()
    )
}

fn case(outcome: &Outcome) -> Markup {
    let concealed = if outcome.ids.is_empty() { "nothing".to_owned() } else { outcome.ids.join(" + ") };
    let names = outcome.listed.join(", ");
    let remainder = if outcome.unlisted && outcome.verdict == "named" { ", and a remainder" } else { "" };
    let answer = if names.is_empty() || names == outcome.verdict {
        outcome.verdict.clone()
    } else {
        format!("{}: {names}{remainder}", outcome.verdict)
    };
    html! {
        tr {
            td { (outcome.case) }
            td { (concealed) }
            td { (outcome.size) }
            td { (outcome.level) }
            td class=(tone(outcome)) { (answer) }
        }
    }
}

/// Good, open or wrong.
fn tone(outcome: &Outcome) -> &'static str {
    use host_sim::proof_case::Kind;
    let good = match outcome.kind {
        Kind::Effect => outcome.right && !outcome.companions,
        Kind::Pair => outcome.all_found && !outcome.companions,
        Kind::Nothing => !outcome.false_alarm,
        Kind::Outside | Kind::Untouched => outcome.unlisted,
    };
    let open = outcome.among_three || (outcome.kind == Kind::Pair && outcome.one_found);
    match (good, open && !outcome.confidently_wrong) {
        (true, _) => "good",
        (false, true) => "open",
        (false, false) => "wrong",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::judge;
    use crate::judge::tests::{beside, said, truth};
    use crate::tally::tables;

    #[test]
    fn the_page_shows_every_case_and_table() {
        let lag = truth("effect", &["servo_lag"], "lab");
        let outcomes = [judge(&lag, Some(&said("ambiguous", &["gyro_lag"], &["servo_lag"])), &beside(&[]))];
        let tables = tables(&outcomes);
        let page = html(&outcomes, &tables, 1, Air::default());
        assert!(page.contains("ambiguous: gyro_lag, servo_lag") && page.contains("class=\"open\""), "{page}");
        assert!(tables.iter().all(|table| page.contains(table.title)));
        assert!(page.contains("pitchid prove --cases 1 --seed 1"));
        assert!(
            !page.contains("http://")
                || page.matches("http://").count() == page.matches("http://www.w3.org").count()
        );
    }
}
