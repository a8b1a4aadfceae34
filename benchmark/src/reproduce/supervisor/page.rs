//! The study of the supervisor as a page.

use super::{Study, Watched};
use host_sim::fault::Fault;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Heads of the table.
pub const HEADER: [&str; 9] = [
    "what breaks",
    "tests",
    "done",
    "recoveries",
    "longest, s",
    "beyond the limit, rad: 99 %, most",
    "without a bound",
    "nearest to the bound",
    "promises broken",
];

/// The groups: what breaks, and its tests.
fn groups(study: &Study) -> BTreeMap<(u8, &'static str), Vec<&Watched>> {
    let mut groups: BTreeMap<(u8, &'static str), Vec<&Watched>> = BTreeMap::new();
    for test in &study.tests {
        let key = test.failing.map_or((0, "nothing"), |failing| {
            (if failing.fault.is_of_sensors() { 1 } else { 2 }, Fault::told(&failing.fault))
        });
        groups.entry(key).or_default().push(test);
    }
    groups
}

/// One row a group, and all of them.
#[must_use]
pub fn rows(study: &Study) -> Vec<Vec<String>> {
    let mut rows: Vec<_> = groups(study).iter().map(|((_, told), tests)| row(told, tests)).collect();
    rows.push(row("all", &study.tests.iter().collect::<Vec<_>>()));
    rows
}

fn row(told: &str, tests: &[&Watched]) -> Vec<String> {
    let mut excess: Vec<f64> =
        tests.iter().filter_map(|test| test.furthest).map(|one| one.excess_rad).collect();
    excess.sort_by(f64::total_cmp);
    let share = |p: f64| excess.get((p * excess.len() as f64) as usize).or(excess.last());
    let beyond = match (share(0.99), excess.last()) {
        (Some(most_of_them), Some(most)) => format!("{most_of_them:.2}, {most:.2}"),
        _ => "-".to_owned(),
    };
    let nearest = tests.iter().filter_map(|test| test.nearest).map(|(_, ratio)| ratio).reduce(f64::max);
    let sum = |of: &dyn Fn(&Watched) -> usize| tests.iter().map(|test| of(test)).sum::<usize>();
    let longest = tests.iter().map(|test| test.longest_s).fold(0.0, f64::max);
    let unbounded = sum(&|test| test.unbounded);
    vec![
        told.to_owned(),
        tests.len().to_string(),
        tests.iter().filter(|test| test.ended == "done").count().to_string(),
        sum(&|test| test.recoveries as usize).to_string(),
        format!("{longest:.2}"),
        beyond,
        if unbounded == 0 {
            "-".to_owned()
        } else {
            format!("{unbounded} of {}", sum(&|test| test.excursions))
        },
        nearest.map_or("-".to_owned(), |ratio| format!("{:.0} %", 100.0 * ratio)),
        sum(&|test| test.broken.len()).to_string(),
    ]
}

/// The tests that came nearest to their bound with nothing broken on them, the nearest first.
#[must_use]
pub fn worst(study: &Study) -> Vec<&Watched> {
    let ratio = |test: &&Watched| test.nearest.map_or(0.0, |(_, ratio)| ratio);
    let mut worst: Vec<&Watched> = study.tests.iter().filter(|test| test.failing.is_none()).collect();
    worst.sort_by(|a, b| ratio(b).total_cmp(&ratio(a)));
    worst.truncate(10);
    worst
}

/// Promises that were broken, a line each.
#[must_use]
pub fn broken(study: &Study) -> Vec<String> {
    let told = |test: &Watched| {
        let number = test.number;
        test.broken.iter().map(move |promise| format!("test {number}, {promise}")).collect::<Vec<_>>()
    };
    study.tests.iter().flat_map(told).collect()
}

/// The page.
#[must_use]
pub fn markdown(study: &Study) -> String {
    let mut page = format!("# The supervisor where tests go wrong, seed {}\n\n", study.seed);
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    page += &line(&HEADER.map(str::to_owned));
    page += &format!("|{}\n", " --- |".repeat(HEADER.len()));
    rows(study).iter().for_each(|cells| page += &line(cells));
    page += "\nHow they ended:\n\n| | tests |\n| --- | --- |\n";
    let mut ends: BTreeMap<String, usize> = BTreeMap::new();
    for test in &study.tests {
        *ends.entry(test.ended.clone()).or_default() += 1;
    }
    ends.iter().for_each(|(end, count)| {
        let _ = writeln!(page, "| {end} | {count} |");
    });
    page += "\nNearest to their bound with nothing broken:\n\n| test | concealed | beyond the limit, rad | bound, rad |\n| --- | --- | --- | --- |\n";
    for test in worst(study) {
        let Some((one, _)) = test.nearest else { continue };
        let bound = one.bound_rad.unwrap_or(f64::NAN);
        let concealed = if test.effects.is_empty() { "nothing".to_owned() } else { test.effects.join(", ") };
        let _ = writeln!(page, "| {} | {concealed} | {:.3} | {bound:.3} |", test.number, one.excess_rad);
    }
    let broken = broken(study);
    if !broken.is_empty() {
        page += "\nBroken:\n\n";
        broken.iter().for_each(|promise| page += &format!("- {promise}\n"));
    }
    page
}
