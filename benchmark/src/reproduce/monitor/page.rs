//! The study of the monitor as a page.

use super::{Alteration, Altered, Kind, Said, Study};
use std::fmt::Write as _;

/// Heads of the table.
pub const HEADER: [&str; 8] = [
    "change",
    "motion",
    "flights",
    "told",
    "after, median",
    "omniscient",
    "right; one of two",
    "interval covers",
];

/// What is told of the stick.
fn motion(stick: f64) -> &'static str {
    if stick == 0.0 {
        "excitation"
    } else if stick < 1.0 {
        "calm pilot"
    } else {
        "busy pilot"
    }
}

fn told(alteration: Alteration) -> String {
    let percent = |name: &str, s: f64| format!("{name} {:+.0} %", 100.0 * s);
    let Alteration { kind, size } = alteration;
    match kind {
        Kind::Effectiveness => percent("effectiveness", size),
        Kind::GyroScale => format!("gyro scale ±{:.0} %", 100.0 * size.abs()),
        Kind::Lag => format!("servo lag {:.0} ms", 1000.0 * size),
        Kind::Delay => format!("delay {:.0} ms", 1000.0 * size),
        Kind::Trim => format!("trim ±{:.2} N m", size.abs()),
        Kind::Damping => format!("damping +{size:.1} N m s/rad"),
        Kind::Friction => format!("friction {size:.2} N m"),
        Kind::GyroBias => format!("gyro bias ±{:.2} rad/s", size.abs()),
    }
}

/// The middle of `times`, those that never came last.
fn median(times: impl Iterator<Item = Option<f64>>) -> String {
    let mut all: Vec<f64> = times.map(|time| time.unwrap_or(f64::INFINITY)).collect();
    all.sort_by(f64::total_cmp);
    match all.get(all.len() / 2) {
        Some(time) if time.is_finite() => format!("{time:.1} s"),
        _ => "> 25 s".into(),
    }
}

/// How many of some flights are what.
struct Counts {
    told: usize,
    right: usize,
    one_of: usize,
    sized: usize,
    covered: usize,
}

impl Counts {
    fn of<'a>(flights: impl Iterator<Item = &'a Altered>) -> Self {
        let mut counts = Self { told: 0, right: 0, one_of: 0, sized: 0, covered: 0 };
        for Said { told_after, right: [right, _], one_of, size, .. } in flights.map(|flight| &flight.said) {
            counts.told += usize::from(told_after.is_some());
            counts.right += usize::from(*right);
            counts.one_of += usize::from(*one_of);
            counts.sized += usize::from(size.is_some());
            counts.covered += usize::from(size.is_some_and(|(_, covers)| covers));
        }
        counts
    }
}

/// A row for each change and motion.
#[must_use]
pub fn rows(study: &Study) -> Vec<Vec<String>> {
    let mut groups: Vec<((String, &str), Vec<&Altered>)> = Vec::new();
    let mut order: Vec<&Altered> = study.altered.iter().collect();
    order.sort_by(|a, b| told(a.alteration).cmp(&told(b.alteration)).then(a.stick.total_cmp(&b.stick)));
    for flight in order {
        let key = (told(flight.alteration), motion(flight.stick));
        match groups.last_mut() {
            Some((last, of)) if *last == key => of.push(flight),
            _ => groups.push((key, vec![flight])),
        }
    }
    let row = |((change, motion), of): ((String, &str), Vec<&Altered>)| {
        let Counts { told, right, one_of, sized, covered } = Counts::of(of.iter().copied());
        vec![
            change,
            motion.to_owned(),
            of.len().to_string(),
            told.to_string(),
            median(of.iter().map(|flight| flight.said.told_after)),
            median(of.iter().map(|flight| flight.omniscient)),
            format!("{right}; {one_of}"),
            format!("{covered} of {sized}"),
        ]
    };
    groups.into_iter().map(row).collect()
}

/// The totals in a paragraph.
#[must_use]
pub fn totals(study: &Study) -> String {
    let Counts { told, right, one_of, sized, covered } = Counts::of(study.altered.iter());
    let early = study.altered.iter().filter(|flight| flight.said.false_alarm).count();
    let share = |part: usize, whole: usize| if whole == 0 { 0.0 } else { 100.0 * part as f64 / whole as f64 };
    format!(
        "{} of {} changes were told within 25 s; of the told, {:.0} % with the right cause and {:.0} % as one of two, the right one \
         among them; {early} were told before they happened. The interval of the size covers in {:.0} %. In {} h of ordinary flight {} false \
         alarms (largest evidence {:.2} of the threshold), in {} h of gusts {}.",
        told,
        study.altered.len(),
        share(right, told),
        share(one_of, told),
        share(covered, sized),
        study.amount.hours,
        study.quiet.len(),
        study.most_quiet,
        study.amount.hours,
        study.gusty.len(),
    )
}

/// The page.
#[must_use]
pub fn markdown(study: &Study) -> String {
    let mut page = String::from("# The monitor in simulated flights\n\n");
    let _ = writeln!(page, "{}\n", totals(study));
    let _ = writeln!(
        page,
        "Each of {} vehicles (parameters ±25 %, a third each in air of 98, 90 and 75 %) was identified from one test of 75 s of excitation; \
         the monitor has the errors that follow. Flights are of that vehicle in that air: the loop closed with a pilot on the stick (busy: \
         ±0.08 to ±0.25 rad; calm: 0.4 of it), or the excitation of campaign 4. Gusts: for 3 to 20 s, every minute or so, the air is 2 to 4 \
         times as strong from one moment to the next. One thing changes between 20 and 40 s. *Omniscient* is the same test of the one true \
         cause at its one true size, with a model identified from 1200 s, for the same run length of 10 h. Seed {}.\n",
        3 * study.amount.vehicles,
        study.amount.seed
    );
    let _ = writeln!(page, "| {} |\n|{}", HEADER.join(" | "), " --- |".repeat(HEADER.len()));
    for row in rows(study) {
        let _ = writeln!(page, "| {} |", row.join(" | "));
    }
    let alarms = |page: &mut String, title: &str, alarms: &[super::Alarm]| {
        if alarms.is_empty() {
            return;
        }
        let _ = writeln!(page, "\n{title}:\n");
        for alarm in alarms {
            let _ = writeln!(page, "- seeds {:?}, {:.1} s: {}", alarm.seeds, alarm.t, alarm.verdict);
        }
    };
    alarms(&mut page, "False alarms in ordinary air", &study.quiet);
    alarms(&mut page, "False alarms in gusts", &study.gusty);
    page
}
