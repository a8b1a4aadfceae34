//! The report of a proof: one HTML file that needs nothing else.

use crate::Error;
use crate::confusion;
use crate::judge::Outcome;
use crate::tally::Table;
use host_sim::Air;
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;

/// What all pages look like.
pub const STYLE: &str = include_str!("page.css");

/// What the template is given.
#[derive(Serialize)]
struct Page<'a> {
    lead: String,
    confusion: String,
    tables: &'a [Table],
    cases: Vec<Case<'a>>,
    command: String,
    version: &'static str,
    style: &'static str,
}

/// One line of the list of cases.
#[derive(Serialize)]
struct Case<'a> {
    number: u64,
    concealed: String,
    size: &'a str,
    level: &'a str,
    answer: String,
    tone: &'static str,
}

/// Renders the report.
pub fn html(outcomes: &[Outcome], tables: &[Table], seed: u64, air: Air) -> Result<String, Error> {
    let failed = |error: minijinja::Error| {
        Error::new(format!("the report could not be made: {error}"), "results.json holds everything")
    };
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("proof", include_str!("proof.html")).map_err(failed)?;
    let page = Page {
        lead: lead(outcomes),
        confusion: confusion::svg(outcomes),
        tables,
        cases: outcomes.iter().map(case).collect(),
        command: command(outcomes.len(), seed, air),
        version: env!("CARGO_PKG_VERSION"),
        style: STYLE,
    };
    environment.get_template("proof").and_then(|t| t.render(Serde(page))).map_err(failed)
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

fn case(outcome: &Outcome) -> Case<'_> {
    let concealed = if outcome.ids.is_empty() { "nothing".to_owned() } else { outcome.ids.join(" + ") };
    let names = outcome.listed.join(", ");
    let remainder = if outcome.unlisted && outcome.verdict == "named" { ", and a remainder" } else { "" };
    let answer = if names.is_empty() || names == outcome.verdict {
        outcome.verdict.clone()
    } else {
        format!("{}: {names}{remainder}", outcome.verdict)
    };
    Case {
        number: outcome.case,
        concealed,
        size: &outcome.size,
        level: &outcome.level,
        answer,
        tone: tone(outcome),
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
        let page = html(&outcomes, &tables, 1, Air::default()).unwrap();
        assert!(page.contains("ambiguous: gyro_lag, servo_lag") && page.contains("class=\"open\""), "{page}");
        assert!(tables.iter().all(|table| page.contains(table.title)));
        assert!(page.contains("pitchid prove --cases 1 --seed 1"));
        assert!(
            !page.contains("http://")
                || page.matches("http://").count() == page.matches("http://www.w3.org").count()
        );
    }
}
