//! How the monitor does in simulated flights: false alarms in hours of ordinary flight, and changes at random moments.

pub mod page;
mod vehicle;

pub use vehicle::{Alteration, Kind};

use vehicle::{AIRS, Vehicle};

use crate::{Error, files};
use estimator_core::monitor::{CAUSES, Cause, Monitor, MonitorConfig, MonitorModel, SIZES, Test, Verdict};
use host_sim::Background;
use host_sim::seeds::{Stream, generator};
use rand::RngExt;
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;
use sysid::monitor::{Row, replay};
use sysid::progress::{Counted, Progress};

/// How long a flight goes on after the change, s.
const AFTER_S: f64 = 25.0;
/// Earliest and latest change, s.
const BETWEEN_S: [f64; 2] = [20.0, 40.0];
/// Length of one ordinary flight, s.
const ORDINARY_S: f32 = 900.0;
/// Sticks of the altered flights, as shares of the usual.
const STICKS: [f64; 3] = [1.0, 0.4, 0.0];

/// What is done to a vehicle; the sign is drawn where both are usual.
const ALTERATIONS: [(Alteration, bool); 14] = [
    (Alteration { kind: Kind::Effectiveness, size: -0.3 }, false),
    (Alteration { kind: Kind::Effectiveness, size: -0.15 }, false),
    (Alteration { kind: Kind::Lag, size: 0.04 }, false),
    (Alteration { kind: Kind::Delay, size: 0.04 }, false),
    (Alteration { kind: Kind::Lag, size: 0.02 }, false),
    (Alteration { kind: Kind::Trim, size: 0.05 }, true),
    (Alteration { kind: Kind::Trim, size: 0.1 }, true),
    (Alteration { kind: Kind::Damping, size: 0.6 }, false),
    (Alteration { kind: Kind::Damping, size: 1.2 }, false),
    (Alteration { kind: Kind::Friction, size: 0.06 }, false),
    (Alteration { kind: Kind::Friction, size: 0.12 }, false),
    (Alteration { kind: Kind::GyroBias, size: 0.05 }, true),
    (Alteration { kind: Kind::GyroBias, size: 0.02 }, true),
    (Alteration { kind: Kind::GyroScale, size: 0.15 }, true),
];

/// What the monitor said of one altered flight.
#[derive(Clone, Debug, Serialize)]
pub struct Altered {
    /// What was done.
    pub alteration: Alteration,
    /// Explained share of the air, per cent.
    pub air: u32,
    /// Stick.
    pub stick: f64,
    /// Time in which a test that knows cause, size and model tells it, s.
    pub omniscient: Option<f64>,
    /// What the monitor said.
    #[serde(flatten)]
    pub said: Said,
}

/// What the monitor said of a flight in which one thing changed.
#[derive(Clone, Debug, Serialize)]
pub struct Said {
    /// Time from the change to the first telling, s.
    pub told_after: Option<f64>,
    /// What was told first.
    pub told_first: String,
    /// What was told at the end.
    pub told_last: String,
    /// Whether those are the cause.
    pub right: [bool; 2],
    /// Whether what was told first are two causes, one of them the right one.
    pub one_of: bool,
    /// The size at the end over the true one, and whether its interval covers, where the cause is right.
    pub size: Option<(f64, bool)>,
    /// Whether something was told before the change.
    pub false_alarm: bool,
}

fn is_told(verdict: &Verdict) -> bool {
    !matches!(verdict, Verdict::AsIdentified | Verdict::CannotTell(_))
}

fn name(verdict: &Verdict) -> String {
    match verdict {
        Verdict::Changed(change) => change.cause.name().into(),
        Verdict::OneOf(a, b) => format!("{} or {}", a.cause.name(), b.cause.name()),
        Verdict::SomethingElse { .. } => "something else".into(),
        Verdict::AsIdentified | Verdict::CannotTell(_) => "nothing".into(),
    }
}

/// The test of one cause at one size, by a model without errors.
fn knowing(model: &MonitorModel, cause: Cause, size: f64) -> MonitorModel {
    let mut model = *model;
    for (test, of) in model.tests.iter_mut().zip(Cause::ALL) {
        let sizes = if of == cause { [size as f32, 0.0, 0.0, 0.0, 0.0, 0.0] } else { [0.0; 6] };
        *test = Test { dead_zone: 0.0, sizes, ..*test };
    }
    model
}

/// Time from `at_s` to where the evidence of `cause` passes `share` of the threshold, s.
fn crossing(rows: &[Row], cause: Cause, share: f32, at_s: f64) -> Option<f64> {
    let place = Cause::ALL.iter().position(|of| *of == cause)?;
    rows.iter().find(|row| row.t >= at_s && row.report.evidence[place] >= share).map(|row| row.t - at_s)
}

/// The monitor at its default run length.
fn built(model: &MonitorModel) -> Result<Monitor, Error> {
    let config = MonitorConfig::default();
    config.build(model).map_err(|error| Error::new(error.to_string(), "this is a fault of the program"))
}

/// Flies one altered flight.
fn altered(vehicle: &Vehicle, air: Background, seed: u64) -> Result<Altered, Error> {
    let mut random = generator(seed, Stream::Choice);
    let (mut alteration, signed) = ALTERATIONS[random.random_range(0..ALTERATIONS.len())];
    if signed && random.random_bool(0.5) {
        alteration.size = -alteration.size;
    }
    let stick = STICKS[random.random_range(0..STICKS.len())];
    let at_s = random.random_range(BETWEEN_S[0]..BETWEEN_S[1]);
    let mut scenario = vehicle.ordinary(seed, (at_s + AFTER_S) as f32, stick)?;
    Vehicle::alter(&mut scenario, alteration, at_s)?;
    let data = vehicle.fly(&scenario)?;
    let replayed = |monitor: &Monitor| -> Vec<Row> {
        let rows = replay(monitor, &data).into_iter().flatten();
        rows.take_while(|row| row.t < at_s + AFTER_S).collect()
    };
    let (cause, size) = alteration.truth(vehicle.inertia());
    // its threshold is that of one sum
    let sharp = built(&knowing(&vehicle.exact.model, cause, size))?;
    let one = (sharp.threshold() - ((CAUSES * SIZES) as f32).ln()) / sharp.threshold();
    let omniscient = crossing(&replayed(&sharp), cause, one, at_s);
    let air = (100.0 * air.explainable().unwrap_or(1.0)).round() as u32;
    let rows = replayed(&built(&vehicle.design.model)?);
    Ok(Altered { alteration, air, stick, omniscient, said: said(&rows, at_s, cause, size) })
}

/// What `rows` say of a change of `cause` by `size` at `at_s`.
fn said(rows: &[Row], at_s: f64, cause: Cause, size: f64) -> Said {
    let first = rows.iter().find(|row| row.t >= at_s && is_told(&row.report.verdict));
    let last = rows.last().filter(|row| is_told(&row.report.verdict));
    let rightly = |row: &Row| match row.report.verdict {
        Verdict::Changed(change) if change.cause == cause => Some(change),
        _ => None,
    };
    let one_of = |row: &Row| match row.report.verdict {
        Verdict::OneOf(a, b) => a.cause == cause || b.cause == cause,
        _ => false,
    };
    let named = |row: Option<&Row>| row.map_or("nothing".into(), |row| name(&row.report.verdict));
    Said {
        told_after: first.map(|row| row.t - at_s),
        told_first: named(first),
        told_last: named(last),
        right: [first, last].map(|row| row.and_then(rightly).is_some()),
        one_of: first.is_some_and(one_of),
        size: last.and_then(rightly).map(|change| {
            let (found, interval) = (f64::from(change.size), f64::from(change.interval));
            (found / size, (found - size).abs() <= interval)
        }),
        false_alarm: rows.iter().any(|row| row.t < at_s && is_told(&row.report.verdict)),
    }
}

/// An alarm where nothing changed.
#[derive(Clone, Debug, Serialize)]
pub struct Alarm {
    /// Seed of the vehicle, and of the flight.
    pub seeds: [u64; 2],
    /// When, s.
    pub t: f64,
    /// What was told.
    pub verdict: String,
}

/// Flies one ordinary flight, with gusts where that is asked for: spans in which the air is two to four times as strong.
fn quiet(vehicle: &Vehicle, seeds: [u64; 2], gusts: bool) -> Result<(Vec<Alarm>, f32), Error> {
    let mut scenario = vehicle.ordinary(seeds[1], ORDINARY_S, 1.0)?;
    if gusts {
        let mut random = generator(seeds[1], Stream::Choice);
        let mut t = 10.0;
        while t < f64::from(ORDINARY_S) {
            let length = random.random_range(3.0..20.0);
            scenario.gusts.push(([t, t + length], random.random_range(2.0..4.0)));
            t += length + random.random_range(20.0..60.0);
        }
    }
    let data = vehicle.fly(&scenario)?;
    let monitor = built(&vehicle.design.model)?;
    let rows: Vec<Row> = replay(&monitor, &data).into_iter().flatten().collect();
    let most = rows.iter().flat_map(|row| row.report.evidence).fold(0.0, f32::max);
    let mut alarms = Vec::new();
    let mut told = false;
    for row in &rows {
        let now = is_told(&row.report.verdict);
        if now && !told {
            alarms.push(Alarm { seeds, t: row.t, verdict: row.report.verdict.to_string() });
        }
        told = now;
    }
    Ok((alarms, most))
}

/// How much is flown.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Amount {
    /// Vehicles in each air.
    pub vehicles: u64,
    /// Altered flights.
    pub flights: u64,
    /// Hours of ordinary flight in the air of the identification, and as many in gusts.
    pub hours: u64,
    /// Seed of everything.
    pub seed: u64,
}

/// What the study found.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// How much was flown.
    pub amount: Amount,
    /// False alarms in the air of the identification.
    pub quiet: Vec<Alarm>,
    /// False alarms in gusts.
    pub gusty: Vec<Alarm>,
    /// Largest evidence in quiet air, over the threshold.
    pub most_quiet: f32,
    /// The altered flights.
    pub altered: Vec<Altered>,
}

/// Identifies, flies, counts, and writes `monitor.md` and `monitor.json` into `folder`, which is there.
///
/// # Errors
/// A vehicle that cannot be identified, or a file that cannot be written.
pub fn monitor(folder: &Path, amount: Amount, say: &Progress<'_>) -> Result<Study, Error> {
    let Amount { vehicles: each, flights, hours, seed } = amount;
    say("identifying the vehicles".into());
    let vehicles = vehicles(each, seed)?;
    let of = |k: u64| &vehicles[k as usize % vehicles.len()];
    let count = hours * (3600.0 / ORDINARY_S) as u64;
    let counted = Counted::new(say, "flying where nothing changes", 2 * count as usize);
    let ordinary = |gusts: bool| -> Result<(Vec<Alarm>, f32), Error> {
        let flown = (0..count).into_par_iter().map(|k| {
            let (_, vehicle_seed, vehicle) = of(k);
            let flown = quiet(vehicle, [*vehicle_seed, seed * 1_000_003 + k], gusts);
            counted.one();
            flown
        });
        let flown: Vec<(Vec<Alarm>, f32)> = flown.collect::<Result<_, _>>()?;
        let most = flown.iter().map(|(_, most)| *most).fold(0.0, f32::max);
        Ok((flown.into_iter().flat_map(|(alarms, _)| alarms).collect(), most))
    };
    let ((quiet, most_quiet), (gusty, _)) = (ordinary(false)?, ordinary(true)?);
    let counted = Counted::new(say, "flying where something changes", flights as usize);
    let altered = (0..flights).into_par_iter().map(|k| {
        let (air, _, vehicle) = of(k);
        let flown = altered(vehicle, *air, seed * 2_000_003 + k);
        counted.one();
        flown
    });
    let altered: Vec<Altered> = altered.collect::<Result<_, _>>()?;
    let study = Study { amount, quiet, gusty, most_quiet, altered };
    files::write(&folder.join("monitor.json"), &files::json(&study)?)?;
    files::write(&folder.join("monitor.md"), &page::markdown(&study))?;
    Ok(study)
}

/// The vehicles of the study: so many of each air.
fn vehicles(each: u64, seed: u64) -> Result<Vec<(Background, u64, Vehicle)>, Error> {
    let all: Vec<(Background, u64)> = AIRS
        .into_iter()
        .enumerate()
        .flat_map(|(place, air)| (0..each).map(move |k| (air, seed * 1000 + place as u64 * 100 + k)))
        .collect();
    all.into_par_iter()
        .map(|(air, seed)| Vehicle::new(seed, air).map(|vehicle| (air, seed, vehicle)))
        .collect()
}
