//! Answers as they stand on a terminal: paragraphs and tables of plain text.

pub mod axes;
pub mod comparison;

use crate::format;
use crate::output::width;
use crate::report::content::{CheckRows, Content, capitalised, plant_meaning};
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Table, presets};
use std::fmt::Write as _;
use sysid::diagnosis::questions::Question;
use sysid::estimate::Estimate;
use sysid::identify::compare::Identification;

/// Longest name in the first column of a table that is not broken, columns of the terminal.
const LONGEST_NAME: u16 = 24;

/// A paragraph, wrapped to the terminal, every further line under the first.
pub fn paragraph(text: &str) -> String {
    indented(text, "", "")
}

/// A paragraph with a start of its own.
pub fn indented(text: &str, first: &str, further: &str) -> String {
    let options = textwrap::Options::new(width().into()).initial_indent(first).subsequent_indent(further);
    // neither 4e-10 nor 33 % is torn apart
    let options = options.word_splitter(textwrap::WordSplitter::NoHyphenation);
    let whole = text.replace(" %", "\u{a0}%").replace(" = ", "\u{a0}= ");
    format!("{}\n", textwrap::fill(&whole, options).replace('\u{a0}', " "))
}

/// What to do next, and the command for it in one piece: a terminal breaks a long line where it can be copied.
pub fn next(what: &str, command: &str) -> String {
    format!("  {what}: {command}\n")
}

/// A paragraph for each line, behind a dash.
pub fn bullets(lines: &[String]) -> String {
    lines.iter().map(|line| indented(line, "  - ", "    ")).collect()
}

/// A line with a blank line before it.
pub fn heading(text: &str) -> String {
    format!("\n{text}\n")
}

/// A table with `left` columns of text, the others of numbers.
pub fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>, left: usize) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(presets::NOTHING.header_separator(rule));
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(width()).set_header(header.to_vec()).add_rows(rows);
    let name = table.column_max_content_widths().first().copied().unwrap_or(0);
    if let Some(column) = table.column_mut(0).filter(|_| name <= LONGEST_NAME) {
        column.set_constraint(ColumnConstraint::ContentWidth);
    }
    for column in table.column_iter_mut().skip(left) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let lines: Vec<String> = table.lines().map(|line| line.trim_end().to_owned() + "\n").collect();
    lines.concat()
}

/// A diagnosis.
pub fn diagnosis(content: &Content) -> String {
    let answer = &content.answer;
    let mut text = paragraph(&format!("{}: {}", content.verdict.to_uppercase(), content.headline));
    text.push('\n');
    text.push_str(&paragraph(&answer.summary));
    text.push_str(&questions(&answer.questions));
    text.push_str(&checks(&content.checks));
    text.push_str(&fit(content));
    for effect in &content.effects {
        text.push_str(&heading(&format!("Added: {} ({})", effect.id, effect.locus)));
        text.push_str(&indented(&effect.equation, "  ", "    "));
        text.push_str(&indented(&effect.evidence, "  ", "  "));
        if let Some(alternatives) = &effect.alternatives {
            text.push_str(&indented(&format!("instead possible: {alternatives}"), "  ", "  "));
        }
    }
    if let Some(remainder) = &content.remainder {
        text.push_str(&heading("What is left"));
        text.push_str(&indented(remainder, "  ", "  "));
    }
    text.push_str(&parameters(content));
    text.push_str(&location(content));
    if let Some(next) = &answer.next_experiment {
        text.push_str(&heading("Next experiment"));
        let [low, high] = next.switching_s;
        let [a, b] = &next.separates;
        let told = format!(
            "PRBS in {}, {} s, dwell {low} to {high} s, amplitude {}: tells {a} from {b}; {}",
            next.section, next.length_s, next.amplitude_rad, next.why
        );
        text.push_str(&indented(&told, "  ", "  "));
    }
    text + &notes(&answer.notes)
}

/// The questions and their answers.
pub fn questions(all: &[Question]) -> String {
    let lines: Vec<String> = all
        .iter()
        .map(|q| indented(&format!("{} {}.", q.question, capitalised(&q.answer)), "  ", "    "))
        .collect();
    if lines.is_empty() { String::new() } else { heading("In order") + &lines.concat() }
}

fn checks(rows: &CheckRows) -> String {
    let found = rows.found.iter().map(|(cause, words)| format!("{cause}: found; {words}"));
    let listed = [("cannot tell", &rows.unknown), ("ruled out", &rows.ruled_out)];
    let listed = listed.into_iter().filter(|(_, names)| !names.is_empty());
    let lines: Vec<String> = found
        .chain(listed.map(|(what, names)| format!("{what}: {names}")))
        .map(|line| indented(&line, "  ", "    "))
        .collect();
    if lines.is_empty() { String::new() } else { heading("Checks of the data") + &lines.concat() }
}

fn fit(content: &Content) -> String {
    if content.fit.is_empty() {
        return String::new();
    }
    let changed = !content.effects.is_empty();
    let rows = content.fit.iter().map(|row| {
        let after = |cell: &String| changed.then(|| cell.clone());
        let near = [Some(row.near_baseline.clone()), after(&row.near_extended)];
        let free = [Some(row.baseline.clone()), after(&row.extended), Some(row.ceiling.clone())];
        [row.section.clone()]
            .into_iter()
            .chain(near.into_iter().flatten())
            .chain(free.into_iter().flatten())
            .collect()
    });
    let header: &[&str] = if changed {
        &["section", "1 s ahead: before", "after", "free run: before", "after", "ceiling"]
    } else {
        &["section", "1 s ahead", "free run", "ceiling"]
    };
    heading(
        "VAF, %, of each section by models selected and fitted without it (ceiling: an unstructured linear model fitted to the section itself)",
    ) + &table(header, rows, 1)
}

fn parameters(content: &Content) -> String {
    if content.parameters.is_empty() {
        return String::new();
    }
    let changed = !content.effects.is_empty();
    let shown = |shown: &Option<format::Shown>| match shown {
        Some(s) => [s.value.clone(), s.interval.clone()],
        None => ["-".into(), String::new()],
    };
    let rows = content.parameters.iter().map(|row| {
        let of_effect = plant_meaning(&row.name).is_empty() && !row.meaning.is_empty();
        let name = if of_effect { format!("{} ({})", row.name, row.meaning) } else { row.name.clone() };
        let mut cells = vec![name, row.unit.clone()];
        if content.model.is_some() {
            cells.push(row.given.clone().unwrap_or("-".into()));
        }
        cells.extend(shown(&row.baseline));
        if changed {
            cells.extend(shown(&row.extended));
        }
        cells
    });
    let given = content.model.as_ref().map(|_| "in the model");
    let estimated: &[&str] = if changed {
        &["before", "95 % interval", "after", "95 % interval"]
    } else {
        &["estimated", "95 % interval"]
    };
    let header: Vec<&str> =
        ["parameter", "unit"].into_iter().chain(given).chain(estimated.iter().copied()).collect();
    heading("Parameters") + &table(&header, rows, 2)
}

fn location(content: &Content) -> String {
    let Some(location) = &content.location else { return String::new() };
    let shares: Vec<String> =
        location.shares.iter().map(|(name, share)| format!("{name} {share:.0} %")).collect();
    let mut text = heading("Where the model differs");
    let lines = [
        ("in the loop", location.locus.as_str()),
        ("when", &location.condition),
        ("time", &location.time),
        ("band", &location.band),
        ("depends on", &location.variable),
        ("share of the residual moment", &shares.join(", ")),
    ];
    for (what, value) in lines.into_iter().filter(|(_, value)| !value.is_empty()) {
        text.push_str(&indented(&format!("{what}: {value}"), "  ", "    "));
    }
    text
}

/// An identification.
pub fn identification(found: &Identification) -> String {
    let mut text = cautions(&found.cautions) + &methods(found);
    text.push_str(&heading("Parameters of the grey box: the free run's errors taken as white, intervals corrected where they are not"));
    text.push_str(&estimates(&found.parameters));
    if !found.parameters_coloured.is_empty() && found.parameters_coloured != found.parameters {
        text.push_str(&heading("The same, with the colour of the errors modelled"));
        text.push_str(&estimates(&found.parameters_coloured));
    }
    if let Some(hinf) = &found.hinf {
        text.push_str(&heading("The same, matched to the PI-MOESP model (bootstrap intervals; mount held)"));
        text.push_str(&estimates(&hinf.parameters));
    }
    text.push_str(&reasons(found));
    let _ =
        write!(text, "\nfitted on {}; held out {}\n", found.training.join(", "), found.held_out.join(", "));
    text + &notes(&found.notes)
}

/// How the choices were made, and what the data cannot tell.
fn reasons(found: &Identification) -> String {
    let mut lines = Vec::new();
    if let Some(subspace) = &found.subspace {
        lines.push(format!("PI-MOESP: {}", subspace.reason));
    }
    if let Some(delay) = &found.delay {
        let [low, high] = delay.ci95_s;
        lines.push(format!(
            "loop delay by profile likelihood: {:.4} s, 95 %: {low:.4} to {high:.4} s",
            delay.best_s
        ));
    }
    if let Some(hinf) = &found.hinf {
        lines.push(format!(
            "H∞: weighted error {:.4} at {:.2} rad/s (largest on a dense grid {:.4}), weight of order {} at {:.1} rad/s",
            hinf.norm, hinf.norm_omega_rad_s, hinf.dense_grid, hinf.weight_order, hinf.weight_cutoff_rad_s
        ));
    }
    if let Some(told) = &found.identifiability {
        lines.push(told.statement.clone());
    }
    let left =
        found.methods.iter().flat_map(|m| m.tests.iter().map(move |(section, tests)| (m, section, tests)));
    let clean: Vec<String> = left
        .filter(|(.., tests)| tests.input.independent)
        .map(|(m, section, _)| format!("{} ({}) on {section}", m.name, m.detail))
        .collect();
    if !found.held_out.is_empty() {
        let none = "none".to_owned();
        let clean = if clean.is_empty() { none } else { clean.join(", ") };
        lines.push(format!(
            "nothing of the input is left in the errors (a test that is wrong once in a hundred) of: {clean}"
        ));
    }
    heading("How sure") + &bullets(&lines)
}

/// The methods side by side: VAF on what was held out.
pub fn methods(found: &Identification) -> String {
    let columns: Vec<String> = found.held_out.iter().map(|label| held_out_title(label, found)).collect();
    let mut header = vec!["method", "", "remark"];
    header.extend(columns.iter().map(String::as_str));
    let cells = |of: &std::collections::BTreeMap<String, f64>| -> Vec<String> {
        let vaf = |label: &String| of.get(label).map_or("-".into(), |v| format::percent(*v));
        found.held_out.iter().map(vaf).collect()
    };
    let ceiling =
        ["ceiling".to_owned(), String::new(), "unstructured, fitted to the section itself".to_owned()];
    let rows = found.methods.iter().map(|method| {
        let own = [method.name.clone(), method.detail.clone(), method.remark.clone()];
        own.into_iter().chain(cells(&method.vaf_percent)).collect()
    });
    let rows = rows.chain([ceiling.into_iter().chain(cells(&found.ceiling_vaf_percent)).collect()]);
    String::from("VAF of the simulated pitch motion on data that nothing was fitted on, %\n")
        + &table(&header, rows, 3)
}

/// What a held-out section is: the closed loop, or an excitation that was left over.
fn held_out_title(label: &str, found: &Identification) -> String {
    let is_closed_loop = |l: &str| l.rsplit(':').next().is_some_and(|l| l.split('#').next() == Some("IV"));
    match label {
        _ if is_closed_loop(label) => format!("{label} (closed loop)"),
        _ if found.held_out.iter().any(|l| is_closed_loop(l)) => format!("{label} (unused PRBS)"),
        _ => label.to_owned(),
    }
}

/// Estimates with unit and interval.
pub fn estimates(list: &[Estimate]) -> String {
    let rows = list.iter().map(|estimate| {
        let shown = format::estimate(estimate);
        let (name, unit) = (estimate.name.clone(), format::unit(&estimate.unit).to_owned());
        vec![name, plant_meaning(&estimate.name).into(), unit, shown.value, shown.interval]
    });
    table(&["parameter", "", "unit", "value", "95 % interval"], rows, 3)
}

/// What speaks against the grey box, first of all.
fn cautions(cautions: &[String]) -> String {
    if cautions.is_empty() {
        return String::new();
    }
    format!("NOT THE PLANT'S VALUES YET\n{}\n", bullets(cautions))
}

fn notes(notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    heading("Noticed in the recordings") + &bullets(notes)
}
