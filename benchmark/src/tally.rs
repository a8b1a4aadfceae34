//! All outcomes together, as tables: the same for the terminal, for `table.md` and for the report.

use crate::judge::{Outcome, Vaf, lowered};
use host_sim::proof_case::Kind;
use serde::Serialize;
use std::collections::BTreeSet;

/// A table with a title and what its columns mean.
#[derive(Clone, Debug, Serialize)]
pub struct Table {
    /// What it counts.
    pub title: &'static str,
    /// What its columns mean; empty where they say it themselves.
    pub note: String,
    /// Columns.
    pub header: Vec<&'static str>,
    /// Cells, as many as there are columns.
    pub rows: Vec<Vec<String>>,
}

type Column<'a> = (&'static str, &'a dyn Fn(&Outcome) -> bool);
type Rows<'a> = Vec<(String, Vec<&'a Outcome>)>;

/// All tables.
pub fn tables(outcomes: &[Outcome]) -> Vec<Table> {
    let of = |kinds: &[Kind]| -> Vec<&Outcome> {
        outcomes.iter().filter(|outcome| kinds.contains(&outcome.kind)).collect()
    };
    let single = of(&[Kind::Effect]);
    let tables = [
        singles(&single),
        by_effect(&single),
        nothing(&of(&[Kind::Nothing])),
        pairs(&of(&[Kind::Pair])),
        outside(&of(&[Kind::Outside, Kind::Untouched])),
        parameters(&of(&[Kind::Effect, Kind::Pair])),
        improvement(outcomes),
        windows(outcomes),
    ];
    tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn singles(cases: &[&Outcome]) -> Table {
    let mut rows = vec![("all".to_owned(), cases.to_vec())];
    rows.extend(split(cases, |o| &o.size, &["strong", "moderate", "weak"]));
    rows.extend(split(cases, |o| &o.level, &["clean", "lab", "paper"]));
    rows.extend(split(
        cases,
        |o| if o.imu_rigid { "IMU rigid" } else { "IMU on its mount" },
        &["IMU rigid", "IMU on its mount"],
    ));
    shares(
        "One effect of the catalogue",
        "Right: named, and the first name is right. Confidently wrong: a wrong name with a probability of 0.9 or more. Sparse \
         regression (STLSQ) is right where it keeps exactly the term of the effect, and that term stands for it alone.",
        rows,
        &[
            ("right", &|o| o.right),
            ("or among ≤ 3", &|o| o.among_three),
            ("right, and spurious", &|o| o.all_found && o.companions),
            ("confidently wrong", &|o| o.confidently_wrong),
            ("missed", &|o| o.missed),
            ("STLSQ: right", &|o| o.sparse.right),
        ],
    )
}

fn by_effect(cases: &[&Outcome]) -> Table {
    let ids: BTreeSet<&str> = cases.iter().filter_map(|o| o.ids.first().map(String::as_str)).collect();
    let rows = ids.into_iter().map(|id| {
        let own = cases.iter().filter(|o| o.ids.first().is_some_and(|own| own == id)).copied().collect();
        (id.to_owned(), own)
    });
    shares(
        "Effect by effect",
        "",
        rows.collect(),
        &[
            ("right", &|o| o.right),
            ("or among ≤ 3", &|o| o.among_three),
            ("confidently wrong", &|o| o.confidently_wrong),
            ("missed", &|o| o.missed),
            ("STLSQ: right", &|o| o.sparse.right),
        ],
    )
}

fn nothing(cases: &[&Outcome]) -> Table {
    let mut rows = vec![("all".to_owned(), cases.to_vec())];
    rows.extend(split(cases, |o| &o.level, &["clean", "lab", "paper"]));
    shares(
        "Nothing concealed",
        "A gust alone is no false alarm at the levels lab and paper, where one blows.",
        rows,
        &[
            ("no mismatch", &|o| o.verdict == "no_mismatch"),
            ("false alarm", &|o| o.false_alarm),
            ("STLSQ: false alarm", &|o| !o.sparse.terms.is_empty()),
        ],
    )
}

fn pairs(cases: &[&Outcome]) -> Table {
    let mut rows = vec![("all".to_owned(), cases.to_vec())];
    rows.extend(split(cases, |o| &o.size, &["strong", "moderate", "weak"]));
    rows.extend(split(cases, |o| &o.level, &["clean", "lab", "paper"]));
    shares(
        "Two effects of the catalogue",
        "",
        rows,
        &[
            ("both found", &|o| o.all_found),
            ("at least one", &|o| o.one_found),
            ("something spurious", &|o| o.companions),
            ("confidently wrong", &|o| o.confidently_wrong),
            ("STLSQ: both", &|o| o.sparse.among),
        ],
    )
}

fn outside(cases: &[&Outcome]) -> Table {
    let mut rows: Rows<'_> = Vec::new();
    for (name, kind) in [("outside, all", Kind::Outside), ("never tuned on, all", Kind::Untouched)] {
        let own: Vec<&Outcome> = cases.iter().filter(|o| o.kind == kind).copied().collect();
        let ids: BTreeSet<&str> = own.iter().filter_map(|o| o.ids.first().map(String::as_str)).collect();
        rows.push((name.to_owned(), own.clone()));
        for id in ids {
            rows.push((id.to_owned(), own.iter().filter(|o| o.ids[0] == id).copied().collect()));
        }
    }
    rows.extend(split(cases, |o| &o.size, &["strong", "moderate", "weak"]));
    rows.extend(split(cases, |o| &o.level, &["clean", "lab", "paper"]));
    shares(
        "Outside the catalogue",
        "There is no right name; a remainder says what is there besides. A far one is not even a relative of what was concealed.",
        rows,
        &[
            ("unlisted, or named with a remainder", &|o| o.unlisted),
            ("ambiguous", &|o| o.verdict == "ambiguous"),
            ("confidently wrong", &|o| o.confidently_wrong),
            ("and far", &|o| o.far),
            ("missed", &|o| o.missed),
            ("STLSQ: names one", &|o| !o.sparse.terms.is_empty()),
        ],
    )
}

fn parameters(cases: &[&Outcome]) -> Table {
    let found = || cases.iter().flat_map(|o| &o.parameters);
    let names: BTreeSet<&str> = found().map(|p| p.name.as_str()).collect();
    let row = |name: &str, own: &dyn Fn(&str) -> bool| {
        let errors: Vec<f64> = found().filter(|p| own(&p.name)).map(|p| p.relative_error).collect();
        let covered = found().filter(|p| own(&p.name) && p.covered).count();
        vec![name.to_owned(), median(&errors, 100.0, " %"), share(covered, errors.len())]
    };
    let mut rows = vec![row("all", &|_| true)];
    rows.extend(names.into_iter().map(|name| row(name, &|other| other == name)));
    Table {
        title: "Parameters of effects that were found",
        note: "Among single effects and pairs. A 95 % interval should cover the true value in 95 % of the cases.".into(),
        header: vec!["parameter", "median relative error", "95 % interval covers"],
        rows: if found().next().is_some() { rows } else { Vec::new() },
    }
}

fn improvement(outcomes: &[Outcome]) -> Table {
    let concealed = |o: &&Outcome| matches!(o.kind, Kind::Effect | Kind::Pair);
    let judged = || outcomes.iter().filter(concealed).filter_map(|o| Some((o, o.vaf?)));
    // what is reached; before and after, by which a loss is judged
    let row = |name: &str, reached: &dyn Fn(&Outcome, &Vaf) -> Option<[f64; 3]>| {
        let all: Vec<_> = judged().filter_map(|(o, vaf)| Some((vaf, reached(o, &vaf)?))).collect();
        let closed: Vec<f64> = all.iter().filter_map(|(vaf, [reached, ..])| vaf.closed(*reached)).collect();
        let half = closed.iter().filter(|share| **share >= 0.5).count();
        let lowered = all.iter().filter(|(_, [_, before, after])| lowered([*before, *after])).count();
        let median = median(&closed, 1.0, "");
        vec![name.to_owned(), median, share(half, closed.len()), share(lowered, all.len())]
    };
    let own = |vaf: &Vaf| [vaf.extended, vaf.in_turn[0], vaf.in_turn[1]];
    let other = |vaf: &Vaf, reached: Option<f64>| reached.map(|r| [r, vaf.baseline, r]);
    let rows = vec![
        row("diagnosis, where it added something", &|o, vaf| (!o.listed.is_empty()).then(|| own(vaf))),
        row("diagnosis, all cases", &|_, vaf| Some(own(vaf))),
        row("sparse regression", &|_, vaf| other(vaf, vaf.sparse)),
        row("black box with as many parameters", &|_, vaf| other(vaf, vaf.black_box)),
    ];
    Table {
        title: "Held-out VAF",
        note: "Single effects and pairs. Gap closed: share of the distance from the baseline to the true model, where that is 2 points \
               or more. Lowered: held-out VAF more than 0.5 points below the baseline's; \
               the diagnosis's on sections held out in turn, where its answer has them."
            .into(),
        header: vec!["method", "gap closed, median", "half or more closed", "VAF lowered"],
        rows: if judged().next().is_some() { rows } else { Vec::new() },
    }
}

fn windows(outcomes: &[Outcome]) -> Table {
    let timed: Vec<&Outcome> = outcomes.iter().filter(|o| o.window.is_some()).collect();
    let ids: BTreeSet<&str> = timed.iter().map(|o| o.ids[0].as_str()).collect();
    let mut rows = vec![("all".to_owned(), timed.clone())];
    rows.extend(
        ids.into_iter().map(|id| (id.to_owned(), timed.iter().filter(|o| o.ids[0] == id).copied().collect())),
    );
    shares(
        "Effects in a time window",
        "Mostly inside: half of what the answer points at, or more, lies in the true window.",
        rows,
        &[
            ("window touched", &|o| o.window.is_some_and(|[touched, _]| touched)),
            ("mostly inside", &|o| o.window.is_some_and(|[_, inside]| inside)),
        ],
    )
}

/// The cases by what `key` says of them.
fn split<'a>(cases: &[&'a Outcome], key: impl Fn(&Outcome) -> &str, values: &[&str]) -> Rows<'a> {
    let own = |value: &str| cases.iter().filter(|o| key(o) == value).copied().collect();
    values.iter().map(|value| ((*value).to_owned(), own(value))).collect()
}

/// A table of shares; rows without a case are left out.
fn shares(title: &'static str, note: &str, rows: Rows<'_>, columns: &[Column<'_>]) -> Table {
    let mut header = vec!["", "cases"];
    header.extend(columns.iter().map(|(name, _)| *name));
    let row = |(name, cases): (String, Vec<&Outcome>)| {
        let count = |holds: &dyn Fn(&Outcome) -> bool| cases.iter().filter(|o| holds(o)).count();
        let mut row = vec![name, cases.len().to_string()];
        row.extend(columns.iter().map(|(_, holds)| share(count(holds), cases.len())));
        row
    };
    let rows = rows.into_iter().filter(|(_, cases)| !cases.is_empty()).map(row).collect();
    Table { title, note: note.to_owned(), header, rows }
}

/// "84 % (42/50)".
fn share(hits: usize, of: usize) -> String {
    if of == 0 { "–".into() } else { format!("{:.0} % ({hits}/{of})", 100.0 * hits as f64 / of as f64) }
}

fn median(values: &[f64], factor: f64, unit: &str) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match (sorted.get(middle), sorted.len() % 2) {
        (None, _) => "–".into(),
        (Some(upper), 1) => format!("{:.2}{unit}", factor * upper),
        (Some(upper), _) => format!("{:.2}{unit}", factor * 0.5 * (upper + sorted[middle - 1])),
    }
}

impl Table {
    /// The rows without the counts behind the percentages: the number of cases stands in its own column.
    #[must_use]
    pub fn short_rows(&self) -> Vec<Vec<String>> {
        let short = |cell: &String| cell.split(" (").next().unwrap_or_default().to_owned();
        self.rows.iter().map(|row| row.iter().map(short).collect()).collect()
    }

    /// The table in Markdown, under a heading.
    #[must_use]
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let header: Vec<String> = self.header.iter().map(|cell| (*cell).to_owned()).collect();
        let rule: Vec<String> = header.iter().map(|_| "---".to_owned()).collect();
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        let note = if self.note.is_empty() { String::new() } else { format!("\n{}\n", self.note) };
        format!("### {}\n{note}\n{}{}{rows}\n", self.title, line(&header), line(&rule))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::judge;
    use crate::judge::tests::{beside, said, truth};

    fn outcomes() -> Vec<Outcome> {
        let drag = truth("effect", &["quadratic_drag"], "lab");
        vec![
            judge(&drag, Some(&said("named", &["quadratic_drag"], &[])), &beside(&[&["quadratic_drag"]])),
            judge(&drag, Some(&said("no_mismatch", &[], &[])), &beside(&[])),
            judge(&truth("nothing", &[], "paper"), Some(&said("no_mismatch", &[], &[])), &beside(&[])),
            judge(&truth("outside", &["gust_burst"], "lab"), Some(&said("unlisted", &[], &[])), &beside(&[])),
        ]
    }

    #[test]
    fn shares_are_counted_over_their_own_cases() {
        let tables = tables(&outcomes());
        let single = &tables[0];
        assert_eq!(single.rows[0][..3], ["all", "2", "50 % (1/2)"]);
        assert_eq!(
            single.rows.iter().map(|row| row[0].as_str()).collect::<Vec<_>>()[1..3],
            ["moderate", "lab"]
        );
        let of = |title: &str| tables.iter().find(|t| t.title == title).unwrap();
        assert_eq!(of("Nothing concealed").rows[0][2], "100 % (1/1)");
        assert_eq!(of("Outside the catalogue").rows[0][2], "100 % (1/1)");
        assert_eq!(of("Held-out VAF").rows[0][1..], ["0.75", "100 % (1/1)", "0 % (0/1)"]);
        assert!(tables.iter().all(|t| t.title != "Two effects of the catalogue"), "no pair was there");
    }

    #[test]
    fn markdown_has_as_many_cells_in_every_line() {
        for table in tables(&outcomes()) {
            let text = table.markdown();
            let bars: BTreeSet<usize> =
                text.lines().filter(|l| l.starts_with('|')).map(|l| l.matches('|').count()).collect();
            assert_eq!(bars.len(), 1, "{text}");
        }
    }

    #[test]
    fn the_median_of_an_even_number_lies_between() {
        assert_eq!(median(&[3.0, 1.0, 2.0], 1.0, ""), "2.00");
        assert_eq!(median(&[0.3, 0.1], 100.0, " %"), "20.00 %");
        assert_eq!(median(&[], 1.0, ""), "–");
    }
}
