//! Which excitations come into question: for every range of dwells the largest amplitude that the limits bear.

use crate::Error;
use crate::craft::Craft;
use crate::forecast::{Excursion, excursion, flights};
use crate::test::{Flown, Test};
use crate::wishes::Wishes;
use estimator_core::plan::PlanConfig;
use sysid::progress::{Counted, Progress};

/// Ranges of dwells, s: the paper's four campaigns, one faster, two slower.
const DWELLS_S: [[f32; 2]; 7] =
    [[0.03, 0.06], [0.05, 0.1], [0.1, 0.2], [0.2, 0.4], [0.4, 0.8], [0.6, 1.2], [0.8, 1.6]];
/// Amplitudes tried are this far apart.
const STEP: f64 = 0.87;
/// How many, from the largest that is allowed: down to a twelfth of it.
const AMPLITUDES: usize = 18;
/// Of the angle that is allowed, what those few flights may reach: the largest of many lies further out.
const RESERVE: f64 = 0.9;
/// Section that is flown, s: the paper's.
pub const SECTION_S: f32 = 25.0;
/// The supervisor takes over at one of these shares of the angle that is allowed, the first that will do: what is left is for its
/// overshoot.
const TRIPS: [f64; 3] = [0.65, 0.5, 0.35];

/// Why no excitation comes into question, by the gentlest that was tried.
fn refused(wishes: &Wishes, gentlest: &Excursion) -> Error {
    let angle = gentlest.angle_rad.most;
    let message = if gentlest.broken_off > 0 {
        format!(
            "no excitation comes into question: even the gentlest was broken off by the supervisor in {} of {} flights",
            gentlest.broken_off, gentlest.flights
        )
    } else {
        format!(
            "no excitation comes into question: even the gentlest reaches {angle:.2} rad, or leaves the supervisor more than {:.0} % \
             of the samples",
            100.0 * wishes.most_overridden
        )
    };
    let help = "the board's attitude controller is tuned for a machine like the paper's (dM/du / Iyy of 135 1/s² per rad); allow a \
                larger angle, or less gusty air, or retune it"
        .to_owned();
    Error::Craft { message, help }
}

/// Section IV of the tests, s: the usual one, or none where following the stick alone takes the craft too far.
fn closed_loop_s(craft: &Craft, wishes: &Wishes) -> Result<f32, Error> {
    let calm = Test { amplitude_rad: rounded(0.0), dwell_s: DWELLS_S[0], ..test(wishes) };
    let flown = flights(&calm, craft, wishes.weather, &wishes.screening_seeds())?;
    let kept = flown.iter().all(|flown| flown.closed_loop_angle_rad <= RESERVE * wishes.limit_rad);
    Ok(if kept { calm.closed_loop_s } else { 0.0 })
}

/// A test with all but the excitation.
fn test(wishes: &Wishes) -> Test {
    Test {
        dwell_s: DWELLS_S[0],
        amplitude_rad: 0.0,
        section_s: SECTION_S,
        closed_loop_s: PlanConfig::default().closed_loop_s,
        trip_theta_rad: rounded(TRIPS[0] * wishes.limit_rad),
    }
}

/// The tests that come into question.
///
/// # Errors
/// None does, or a craft that cannot be.
pub fn candidates(craft: &Craft, wishes: &Wishes, say: &Progress<'_>) -> Result<Vec<Test>, Error> {
    say("flying without excitation".into());
    let plain = Test { closed_loop_s: closed_loop_s(craft, wishes)?, ..test(wishes) };
    let mut gentlest = None;
    for trip in TRIPS {
        let plain = Test { trip_theta_rad: rounded(trip * wishes.limit_rad), ..plain };
        let mut found = Vec::new();
        let counted = Counted::new(say, "looking for what the limits bear", DWELLS_S.len());
        for dwell_s in DWELLS_S {
            match strongest(&Test { dwell_s, ..plain }, craft, wishes)? {
                Ok(test) => found.push(test),
                Err(shown) => gentlest = Some(shown),
            }
            counted.one();
        }
        if !found.is_empty() {
            return Ok(found);
        }
    }
    Err(gentlest
        .map_or_else(|| unreachable!("every excitation was found or refused"), |g| refused(wishes, &g)))
}

/// `plain` with the largest amplitude that the limits bear, or what the least one shows.
fn strongest(plain: &Test, craft: &Craft, wishes: &Wishes) -> Result<Result<Test, Excursion>, Error> {
    let amplitude = |step: usize| rounded(wishes.most_amplitude_rad * STEP.powi(step as i32));
    let test = |step: usize| Test { amplitude_rad: amplitude(step), ..*plain };
    let (shown, is_borne) = judge(&test(AMPLITUDES - 1), craft, wishes)?;
    if !is_borne {
        return Ok(Err(shown));
    }
    // the first step that is borne, by bisection: what a larger amplitude bears a smaller one bears too
    let (mut refused, mut borne) = (None, AMPLITUDES - 1);
    while refused.map_or(borne > 0, |refused| borne - refused > 1) {
        let middle = refused.map_or(borne / 2, |refused: usize| usize::midpoint(refused, borne));
        if judge(&test(middle), craft, wishes)?.1 { borne = middle } else { refused = Some(middle) }
    }
    Ok(Ok(test(borne)))
}

/// What a few flights of a test show, and whether they keep the limits.
fn judge(test: &Test, craft: &Craft, wishes: &Wishes) -> Result<(Excursion, bool), Error> {
    let shown = excursion(&flights(test, craft, wishes.weather, &wishes.screening_seeds())?);
    let borne = shown.broken_off == 0
        && shown.angle_rad.most <= RESERVE * wishes.limit_rad
        && shown.overridden_percent.median <= 100.0 * wishes.most_overridden;
    Ok((shown, borne))
}

/// To a tenth of a milliradian, as a person would set it.
fn rounded(angle_rad: f64) -> f32 {
    ((angle_rad * 1e4).floor().max(1.0) / 1e4) as f32
}

/// Flies a test until every flight keeps the angle that is allowed: the limit at which the supervisor takes over is drawn in, and
/// section IV left out where it is the pilot who goes too far.
///
/// # Errors
/// No limit does, or a craft that cannot be.
pub fn settled(mut test: Test, craft: &Craft, wishes: &Wishes) -> Result<(Test, Excursion), Error> {
    /// How far it is drawn in at a time, and how often at most.
    const DRAWN_IN: f32 = 0.9;
    const MOST: usize = 8;
    let seeds = wishes.forecast_seeds();
    let mut shown = flights(&test, craft, wishes.weather, &seeds)?;
    for _ in 0..MOST {
        let beyond =
            |angle: &dyn Fn(&Flown) -> f64| shown.iter().any(|flown| angle(flown) > wishes.limit_rad);
        if beyond(&|flown| flown.closed_loop_angle_rad) {
            test.closed_loop_s = 0.0;
        } else if beyond(&|flown| flown.angle_rad) {
            test.trip_theta_rad = (test.trip_theta_rad * DRAWN_IN * 1e3).floor() / 1e3;
        } else {
            return Ok((test, excursion(&shown)));
        }
        shown = flights(&test, craft, wishes.weather, &seeds)?;
    }
    Err(refused(wishes, &excursion(&shown)))
}
