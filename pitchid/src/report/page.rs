//! The page of a diagnosis.

use super::Report;
use super::content::{CheckRows, EffectRow, FitRow, LocationRow, ParameterRow};
use super::figures::{Figure, Figures, MOST_SECTIONS};
use crate::format;
use benchmark::html::Document;
use maud::{Markup, html};
use sysid::diagnosis::answer::NextExperiment;
use sysid::diagnosis::candidates::Candidate;
use sysid::diagnosis::questions::Question;

const STYLE: &str = include_str!("report.css");
/// Candidates in the ranking.
const MOST_CANDIDATES: usize = 14;

/// The file.
pub fn page(report: &Report<'_>, figures: &Figures) -> String {
    let content = report.content;
    let answer = &content.answer;
    let changed = !content.effects.is_empty();
    let undrawn = report.found.traces.len().saturating_sub(MOST_SECTIONS + 1);
    let body = html! {
        header style={ "--tone: var(--" (content.tone) ")" } {
            p .verdict { (content.verdict) }
            h1 { (content.headline) }
            p { (answer.summary) }
        }
        (wide("What was recorded", &figures.recorded))
        (side_by_side("What is missing, as the data have it", figures.terms.iter()))
        @if let Some(first) = &figures.first {
            h2 { "Measured and simulated" }
            (first.html())
            p .soft.small { "Every simulation runs freely along the recorded input from an estimated initial state." }
        }
        (in_order(&answer.questions))
        (checks(&content.checks))
        @if changed {
            h2 { "What was added" }
            @for effect in &content.effects { (card(effect)) }
        }
        @if let Some(left) = &content.remainder {
            h2 { "What is left" }
            p { (left) }
            @if !figures.left.is_empty() { (pair(figures.left.iter())) }
        }
        (fit(&content.fit, changed))
        @if let Some(location) = &content.location { (place(location, figures)) }
        (ranking(&report.found.candidates))
        (side_by_side("How it answers the input", figures.step.iter().chain(&figures.response)))
        (side_by_side("What is left, over frequency and lag", figures.spectrum.iter().chain(&figures.correlations)))
        (parameters(&content.parameters, content.model.is_some(), changed))
        @if let Some(next) = &answer.next_experiment { (experiment(next)) }
        (side_by_side("The other sections", figures.others.iter()))
        @if undrawn > 0 {
            p .soft.small { (undrawn) " more sections are in the table and not drawn." }
        }
        @if !answer.notes.is_empty() {
            h2 { "Noticed in the recordings" }
            ul { @for note in &answer.notes { li { (note) } } }
        }
        (report.repeat.html())
        footer {
            (content.recordings.join(", "))
            @if let Some(model) = &content.model { " against " (model) }
            ". pitchid " (content.version) "."
        }
    };
    let json = serde_json::to_string(content).ok().map(|json| ("diagnosis", json));
    Document { title: &content.headline, style: STYLE, body, json }.html(true)
}

fn wide(title: &str, figures: &[Figure]) -> Markup {
    html! {
        @if !figures.is_empty() {
            h2 { (title) }
            @for figure in figures { (figure.html()) }
        }
    }
}

fn side_by_side<'f>(title: &str, figures: impl Iterator<Item = &'f Figure>) -> Markup {
    let figures: Vec<&Figure> = figures.collect();
    html! {
        @if !figures.is_empty() {
            h2 { (title) }
            (pair(figures.into_iter()))
        }
    }
}

fn pair<'f>(figures: impl Iterator<Item = &'f Figure>) -> Markup {
    html! { div .pair { @for figure in figures { (figure.html()) } } }
}

fn in_order(questions: &[Question]) -> Markup {
    html! {
        @if !questions.is_empty() {
            h2 { "In order" }
            dl { @for row in questions { dt { (row.question) } dd { (row.answer) } } }
        }
    }
}

fn checks(checks: &CheckRows) -> Markup {
    html! {
        @if !(checks.found.is_empty() && checks.unknown.is_empty() && checks.ruled_out.is_empty()) {
            h2 { "Checks of the data" }
            dl {
                @for (name, words) in &checks.found { dt { (name) } dd { (words) } }
                @if !checks.unknown.is_empty() { dt { "cannot tell" } dd { (checks.unknown) } }
                @if !checks.ruled_out.is_empty() { dt { "ruled out" } dd { (checks.ruled_out) } }
            }
        }
    }
}

fn card(effect: &EffectRow) -> Markup {
    html! {
        div .card {
            p { strong { (effect.id) } ": " (effect.sentence) }
            p { code { (effect.equation) } " " span .tag { (effect.locus) } }
            p .soft.small { (effect.evidence) }
            @if let Some(alternatives) = &effect.alternatives {
                p .small { "The data cannot rule out instead: " (alternatives) }
            }
        }
    }
}

/// Two figures of a cell above one another: before and after, or one alone.
fn cell(before: &str, after: &str, changed: bool) -> Markup {
    html! {
        td .n {
            @if changed { span .before { (before) } span .after { (after) } } @else { span .after { (before) } }
        }
    }
}

fn fit(rows: &[FitRow], changed: bool) -> Markup {
    // a short section has none of the long ones
    let longest = rows.iter().map(|row| &row.horizons).max_by_key(|horizons| horizons.len());
    let horizons: Vec<&str> = longest.into_iter().flatten().map(|[seconds, ..]| seconds.as_str()).collect();
    let told = |row: &FitRow, seconds: &str| {
        row.horizons
            .iter()
            .find(|[own, ..]| own == seconds)
            .map_or_else(|| cell("–", "–", changed), |[_, before, after]| cell(before, after, changed))
    };
    html! {
        @if !rows.is_empty() {
            h2 { "How well the motion is predicted" }
            div .table { table .figures {
                thead { tr {
                    th { "Held out" }
                    @for seconds in &horizons { th .n { (seconds.trim_end_matches(".0")) " s ahead" } }
                    th .n { "free run" }
                    th .n { "ceiling" }
                } }
                tbody { @for row in rows { tr {
                    td { (row.section) }
                    @for seconds in &horizons { (told(row, seconds)) }
                    (cell(&row.baseline, &row.extended, changed))
                    td .n.soft { (row.ceiling) }
                } } }
            } }
            p .soft.small {
                "VAF = 100·max(0, 1 − var(y − ŷ)/var(y)) in per cent, each section by models that were selected and fitted without it: \
                 predicted so long ahead from the filter's state (± its standard error), and simulated freely. "
                @if changed {
                    span .before { "Before" } ": the model, its parameters estimated again. " span .after { "After" } ": with what was missing. "
                } @else { "The model: its parameters estimated again. " }
                "Ceiling: what a linear model without structure reaches that was fitted to that very section. In a closed loop the free run \
                 judges little."
            }
        }
    }
}

fn place(location: &LocationRow, figures: &Figures) -> Markup {
    html! {
        h2 { "Where the model differs" }
        @for figure in &figures.maps { (figure.html()) }
        div .pair {
            @if let Some(dependence) = &figures.dependence { (dependence.html()) }
            div {
                dl {
                    dt { "In the loop" } dd { (location.locus) }
                    dt { "When" } dd { (location.condition) }
                    dt { "Time" } dd { (location.time) }
                    dt { "Band" } dd { (location.band) }
                    dt { "Depends on" } dd { (location.variable) }
                }
                @if !location.shares.is_empty() {
                    div .bars {
                        span .soft.small { "Share of the residual moment's variance, by signal" }
                        @for (signal, share) in &location.shares {
                            div { span { (signal) } i style=(format!("width: {share:.2}%")) {} span .n.small { (format!("{share:.1} %")) } }
                        }
                    }
                }
            }
        }
        @for figure in &figures.moments { (figure.html()) }
    }
}

/// Every candidate with the odds of the best model with it against the best without it.
fn ranking(candidates: &[Candidate]) -> Markup {
    let told: Vec<&Candidate> = candidates.iter().filter(|c| c.log_odds.is_some()).collect();
    let vanished: Vec<&str> =
        candidates.iter().filter(|c| c.log_odds.is_none()).map(|c| c.about.id).collect();
    let most = told.iter().filter_map(|c| c.log_odds).fold(1.0_f64, |most, odds| most.max(odds.abs()));
    html! {
        @if !candidates.is_empty() {
            h2 { "What could be missing instead" }
            p .soft.small {
                "Every candidate that was fitted, by ln of the odds between the best model with it and the best without it: 3 is twenty to one; \
                 below zero the data speak against it. In bold: in the model."
            }
            div .bars.ranking {
                @for candidate in told.iter().take(MOST_CANDIDATES) {
                    @let odds = candidate.log_odds.unwrap_or_default();
                    div {
                        span .name.chosen[candidate.chosen] title=(candidate.about.sentence) { (candidate.about.id) }
                        i .against[odds < 0.0] style=(format!("width: {:.2}%", 100.0 * odds.abs() / most)) {}
                        span .n.small { (format::signed(odds)) }
                    }
                }
            }
            @if told.len() > MOST_CANDIDATES {
                p .small { "Less probable: " (told[MOST_CANDIDATES..].iter().map(|c| c.about.id).collect::<Vec<_>>().join(", ")) "." }
            }
            @if !vanished.is_empty() {
                p .small { "Vanish when they are fitted: " (vanished.join(", ")) "." }
            }
        }
    }
}

fn parameters(rows: &[ParameterRow], with_model: bool, changed: bool) -> Markup {
    html! {
        @if !rows.is_empty() {
            h2 { "Parameters" }
            div .table { table .figures {
                thead { tr {
                    th { "Parameter" }
                    @if with_model { th .n { "in the model" } }
                    @if changed { th .n { "before, 95 %" } th .n { "after, 95 %" } } @else { th .n { "estimated, 95 %" } }
                } }
                tbody { @for row in rows { tr {
                    td {
                        code { (row.name) }
                        @if !row.unit.is_empty() { span .small { ", " (row.unit) } }
                        span .soft.small.block { (row.meaning) }
                    }
                    @if with_model { td .n.soft { (row.given.as_deref().unwrap_or("–")) } }
                    (estimated(row.baseline.as_ref()))
                    @if changed { (estimated(row.extended.as_ref())) }
                } } }
            } }
        }
    }
}

fn estimated(shown: Option<&format::Shown>) -> Markup {
    html! {
        td .n { @if let Some(shown) = shown { (shown.value) span .ci { (shown.interval) } } @else { "–" } }
    }
}

fn experiment(next: &NextExperiment) -> Markup {
    let [shortest, longest] = next.switching_s;
    html! {
        h2 { "Next experiment" }
        div .card {
            p {
                "PRBS in " (next.section) ", " strong { (next.length_s) " s" } ", dwell " strong { (shortest) " to " (longest) " s" }
                ", amplitude " strong { "±" (next.amplitude_rad) } " in the unit of the input: tells " strong { (next.separates[0]) }
                " from " strong { (next.separates[1]) } "."
            }
            p .soft.small { (next.why) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_too_short_for_a_horizon_has_a_dash_there() {
        let row = |section: &str, horizons: &[&str]| FitRow {
            section: section.into(),
            baseline: "1".into(),
            extended: "2".into(),
            horizons: horizons.iter().map(|s| [*s, "3", "4"].map(str::to_owned)).collect(),
            near_baseline: String::new(),
            near_extended: String::new(),
            ceiling: "5".into(),
        };
        for changed in [false, true] {
            let rows = [row("a", &["0.1"]), row("b", &["0.1", "1.0"])];
            let table = fit(&rows, changed).into_string();
            assert!(table.contains("0.1 s ahead") && table.contains("1 s ahead"), "{table}");
            let cells = table.split("<tr>").skip(1).map(|row| row.matches("<t").count()).collect::<Vec<_>>();
            assert_eq!(cells[1..], [5, 5], "{table}");
            assert_eq!(table.matches('–').count(), if changed { 2 } else { 1 });
        }
    }
}
