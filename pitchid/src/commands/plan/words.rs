//! A plan as text: for the terminal, and the board's parameters.

use crate::format;
use crate::report::content::plant_meaning;
use crate::text::{heading, indented, paragraph, table};
use experiment::forecast::{Accuracy, Band};
use experiment::{Chance, Considered, Plan, PlannedTest, Test, Wishes};

/// For the terminal.
pub fn text(plan: &Plan, wishes: &Wishes) -> String {
    let mut text = paragraph(&headline(plan));
    for (k, planned) in plan.tests.iter().enumerate() {
        text.push_str(&heading(&format!("Test {}", k + 1)));
        text.push_str(&indented(&excitation(planned), "  ", "  "));
        let rows = expected(planned, wishes).into_iter().map(|row| row.to_vec());
        text.push_str(&table(&["  to expect", "least", "middle", "most", "limit"], rows, 1));
    }
    let flights = plan.tests.first().map_or(0, |test| test.excursion.flights);
    text.push('\n');
    text.push_str(&paragraph(&bands(flights)));
    text.push_str(&heading("What it will tell"));
    let rows = plan.accuracy.iter().map(|one| accuracy(one).to_vec());
    text.push_str(&table(&["  half the 95 % interval", "least", "middle", "most"], rows, 1));
    if let Some(chance) = &plan.chance {
        text.push('\n');
        text.push_str(&indented(&told_apart(chance), "  ", "  "));
    }
    text.push_str(&heading("What came into question"));
    let rows = plan.considered.iter().map(|one| considered(one).to_vec());
    text.push_str(&table(&["  dwell and amplitude", "excitation, s", "in the air, s"], rows, 1));
    for note in &plan.notes {
        text.push('\n');
        text.push_str(&paragraph(note));
    }
    text
}

/// The plan in one sentence.
pub fn headline(plan: &Plan) -> String {
    let total: f64 = plan.tests.iter().map(|test| test.length_s).sum();
    match plan.tests.as_slice() {
        [only] => format!("One test of {total:.0} s: {}.", prbs(&only.test)),
        tests => format!("{} tests, {total:.0} s in all.", tests.len()),
    }
}

fn prbs(test: &Test) -> String {
    let [shortest, longest] = test.dwell_s;
    format!("PRBS of ±{} rad, dwell {shortest} to {longest} s", test.amplitude_rad)
}

/// What a test excites, section by section.
pub fn excitation(planned: &PlannedTest) -> String {
    let Test { section_s, closed_loop_s, trip_theta_rad, .. } = planned.test;
    let closed_loop = if closed_loop_s > 0.0 { ", then the closed loop" } else { "" };
    format!(
        "{}: sections I to III of {section_s} s each{closed_loop}; {:.0} s in all. The supervisor takes over at {trip_theta_rad} rad.",
        prbs(&planned.test),
        planned.length_s
    )
}

/// What to expect of a test: what, least, middle, most, limit.
pub fn expected(planned: &PlannedTest, wishes: &Wishes) -> [[String; 5]; 4] {
    let shown = &planned.excursion;
    let row = |what: &str, Band { least, median, most }: Band, decimals: usize, limit: String| {
        let number = |x: f64| format!("{x:.decimals$}");
        [what.to_owned(), number(least), number(median), number(most), limit]
    };
    [
        row("  largest angle, rad", shown.angle_rad, 3, format!("{}", wishes.limit_rad)),
        row("  largest rate, rad/s", shown.rate_rad_s, 2, String::new()),
        row(
            "  taken by the supervisor, %",
            shown.overridden_percent,
            1,
            format!("{} in the middle", format::plain(100.0 * wishes.most_overridden)),
        ),
        row("  length with recoveries, s", shown.length_s, 0, String::new()),
    ]
}

/// What the bands mean.
pub fn bands(flights: usize) -> String {
    let share = 100.0 * (flights as f64 - 1.0) / (flights as f64 + 1.0);
    format!(
        "Of {flights} flights in the simulator, each on a craft as it may be and in air drawn afresh. A further one lies between least and \
         most with a probability of {share:.0} %, if the craft is as was said."
    )
}

/// What came into question: the excitations, the time of excitation and in the air that what was asked for takes.
pub fn considered(one: &Considered) -> [String; 3] {
    let excitation = |test: &Test| {
        let [shortest, longest] = test.dwell_s;
        format!("{shortest} to {longest} s, ±{} rad", test.amplitude_rad)
    };
    let all: Vec<String> = one.excitations.iter().map(excitation).collect();
    let needed = if one.needed_s < 1e5 { format!("{:.0}", one.needed_s) } else { "never".to_owned() };
    [format!("  {}", all.join(" and ")), needed, format!("{:.0}", one.total_s)]
}

/// How well a parameter will be known: which, least, middle, most.
pub fn accuracy(accuracy: &Accuracy) -> [String; 4] {
    let scale = if accuracy.unit == "s" { 1e3 } else { 1.0 };
    let unit = if accuracy.unit == "s" { "ms" } else { "%" };
    let meaning = plant_meaning(&accuracy.name);
    let name =
        if meaning.is_empty() { accuracy.name.clone() } else { format!("{}, {meaning}", accuracy.name) };
    let number = |x: f64| match scale * x {
        x if x < 100.0 => format!("±{} {unit}", format::plain(x)),
        _ => "not known".to_owned(),
    };
    let Band { least, median, most } = accuracy.half_width;
    [format!("  {name}"), number(least), number(median), number(most)]
}

/// The chance to tell rivals apart.
pub fn told_apart(chance: &Chance) -> String {
    let [first, second] = chance.rivals;
    let Chance { flown, right, wrong, evidence, .. } = chance;
    format!(
        "{first} or {second}: decided at odds of 20 to 1 in {} of {flown} simulated experiments, {right} rightly and {wrong} wrongly; 2 \
         ln(odds) {} in the middle.",
        right + wrong,
        format::plain(*evidence)
    )
}

/// The board's parameters as a file: one a line, as ground stations read them.
pub fn parameters(test: &Test) -> String {
    let lines = test.parameters().into_iter().map(|(name, value)| format!("{name} {value}\n"));
    std::iter::once("# written by pitchid plan: NAME VALUE\n".to_owned()).chain(lines).collect()
}
