//! The table, and the page with it.

use super::{BENCHMARKS, Outcome};
use std::fmt::Write as _;

/// Columns of [`rows`].
pub const HEADER: [&str; 6] =
    ["test", "RMSE", "step a quarter as long", "plant without terms", "goal", "published black boxes"];

/// One row for each test.
#[must_use]
pub fn rows(outcomes: &[Outcome]) -> Vec<Vec<String>> {
    let of = |outcome: &Outcome| -> Vec<Vec<String>> {
        let unit = outcome.unit;
        let tests = outcome.tests.iter().map(|test| {
            let rivals: Vec<String> =
                test.rivals.iter().map(|(name, rmse)| format!("{name} {rmse}")).collect();
            vec![
                format!("{}, {}", outcome.name, test.name),
                format!("{:.3} {unit}", test.rmse),
                format!("{:.3}", test.rmse_finer),
                format!("{:.2}", test.linear),
                test.goal.map_or(String::new(), |goal| format!("{goal}")),
                rivals.join(", "),
            ]
        });
        tests.collect()
    };
    outcomes.iter().flat_map(of).collect()
}

/// What the diagnosis named, and what the simulation kept of it, in words.
#[must_use]
pub fn told(outcome: &Outcome) -> String {
    let named: Vec<String> =
        outcome.diagnosed.iter().map(|(id, [chosen, of])| format!("{id} ({chosen} of {of})")).collect();
    let fits: Vec<String> = outcome.fits.iter().map(|(way, error)| format!("{way} {error:.3}")).collect();
    let model: Vec<String> =
        outcome.model.iter().map(|(name, value)| format!("{name} = {value:.5e}")).collect();
    format!(
        "{}: diagnosis of {} training rows: {}, with {} (rotations that chose it). Free run over all \
         training data, {}: {}. Model: {}. Training error {:.3} {}.",
        outcome.name,
        outcome.diagnosed_rows,
        outcome.verdict,
        if named.is_empty() { "nothing".into() } else { named.join(", ") },
        outcome.unit,
        fits.join("; "),
        model.join(", "),
        outcome.train,
        outcome.unit,
    )
}

/// The page.
pub fn markdown(outcomes: &[Outcome]) -> String {
    let mut page = String::from(
        "# Public benchmarks\n\nFree run over the test data of the official split, root mean square error after the \
         initialisation.\n\n",
    );
    let _ = write!(page, "| {} |\n|{}\n", HEADER.join(" | "), " --- |".repeat(HEADER.len()));
    for row in rows(outcomes) {
        let _ = writeln!(page, "| {} |", row.join(" | "));
    }
    for outcome in outcomes {
        let _ = write!(page, "\n{}\n", told(outcome));
    }
    page.push_str("\nData:\n\n");
    for benchmark in &BENCHMARKS {
        let _ = writeln!(page, "- {}: {}.", benchmark.name, benchmark.source);
    }
    page.push_str("- Published errors: Champneys and others, 2024, free run in the same protocol.\n");
    page
}
