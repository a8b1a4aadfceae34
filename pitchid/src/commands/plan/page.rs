//! The page to take to the bench.

use super::words;
use crate::failure::Failure;
use crate::report::recorded;
use crate::report::repeat::Repeat;
use benchmark::html::Document;
use experiment::{Craft, Plan, PlannedTest, Wishes, test};
use maud::{Markup, PreEscaped, html};
use sysid::recording::Recording;

const STYLE: &str = include_str!("../../report/report.css");

/// The file.
pub fn page(plan: &Plan, wishes: &Wishes, craft: &Craft, repeat: &Repeat) -> Result<String, Failure> {
    let headline = words::headline(plan);
    let flown = plan.tests.iter().map(|planned| example(planned, wishes, craft));
    let flown = flown.collect::<Result<Vec<Recording>, Failure>>()?;
    let flights = plan.tests.first().map_or(0, |test| test.excursion.flights);
    let body = html! {
        header style="--tone: var(--found)" {
            p .verdict { "plan" }
            h1 { (headline) }
            @for note in &plan.notes { p { (note) } }
        }
        h2 { "Before the motors run" }
        ul .steps {
            li { "Propellers off: set the parameters, arm, start, watch the servos move both ways, abort. The blades stop in neutral." }
            li { "The rig is free over ±" (wishes.limit_rad) " rad and stops softly beyond; nobody within reach of the rotors." }
            li { "A second person has the kill switch and looks at nothing else." }
            li { "Nose up is positive: lift it by hand, the angle has to rise." }
        }
        @for (k, (planned, flown)) in plan.tests.iter().zip(&flown).enumerate() {
            h2 { "Test " (k + 1) }
            p { (words::excitation(planned)) }
            p { code { "pitchid fly PORT --parameters test-" (k + 1) ".param --out test-" (k + 1) ".csv" } }
            (expected(planned, wishes))
            figure {
                (PreEscaped(recorded::picture(flown, &[]).html()))
                figcaption { "How it may look: one of the flights of the simulator." }
            }
            (parameters(planned))
        }
        p .soft.small { (words::bands(flights)) }
        h2 { "Break it off" }
        ul .steps {
            li { "when the angle passes ±" (wishes.limit_rad) " rad: the supervisor should have stopped it;" }
            li { "when it swings up by itself while the supervisor has it: the controller does not hold this craft;" }
            li { "when the supervisor has it for more than 5 s: it then breaks the test off by itself." }
        }
        h2 { "What it will tell" }
        div .table { table .figures {
            thead { tr { th { "Half the 95 % interval" } th .n { "least" } th .n { "middle" } th .n { "most" } } }
            tbody { @for one in &plan.accuracy { (row(&words::accuracy(one))) } }
        } }
        p .soft.small { "Of " (plan.estimated_from) " simulated experiments, each estimated from as if it were real." }
        @if let Some(chance) = &plan.chance { p { (words::told_apart(chance)) } }
        h2 { "What came into question" }
        div .table { table .figures {
            thead { tr { th { "Dwell and amplitude" } th .n { "excitation, s" } th .n { "in the air, s" } } }
            tbody { @for one in &plan.considered { (row(&words::considered(one))) } }
        } }
        p .soft.small { "Time after which what was asked for is reached; in the air within what a battery was said to bear." }
        p { "Afterwards: " code { "pitchid identify test-1.csv" } ", and " code { "pitchid diagnose" } " against the model in use." }
        (repeat.html())
        footer { "pitchid " (env!("CARGO_PKG_VERSION")) "." }
    };
    let json = serde_json::to_string(plan).ok().map(|json| ("plan", json));
    Ok(Document { title: &headline, style: STYLE, body, json }.html(true))
}

/// A flight of the test, for the picture.
fn example(planned: &PlannedTest, wishes: &Wishes, craft: &Craft) -> Result<Recording, Failure> {
    let flight = planned.test.fly(craft, &[], wishes.weather, wishes.seed)?;
    Ok(test::recording(&flight)?)
}

fn expected(planned: &PlannedTest, wishes: &Wishes) -> Markup {
    html! {
        div .table { table .figures {
            thead { tr { th { "To expect" } th .n { "least" } th .n { "middle" } th .n { "most" } th .n { "limit" } } }
            tbody { @for one in &words::expected(planned, wishes) { (row(one)) } }
        } }
    }
}

fn row(cells: &[String]) -> Markup {
    html! {
        tr {
            @for (k, cell) in cells.iter().enumerate() {
                @if k == 0 { td { (cell.trim_start()) } } @else { td .n { (cell) } }
            }
        }
    }
}

fn parameters(planned: &PlannedTest) -> Markup {
    html! {
        div .table { table .figures {
            thead { tr { th { "Parameter of the board" } th .n { "value" } } }
            tbody { @for (name, value) in planned.test.parameters() { tr { td { code { (name) } } td .n { (value) } } } }
        } }
    }
}
