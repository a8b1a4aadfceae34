//! Sign and unit of the input: ∂M/∂u as the data have it against the user's model.
//!
//! Missing physics, and a start from a wrong unit, can bend a fit's ∂M/∂u by more than a unit does. A regression that knows
//! no model stays within a factor of two or three whatever is missing; it decides, and the fit's interval says how clearly.

use super::{DEGREES, DataCheck, Gravity, too_large};
use crate::estimate::Estimate;
use crate::estimate::digits;
use crate::likelihood::problem::Problem;
use crate::model::baseline::{TOLERABLE, rough_gain};
use crate::recording::{InputUnit, Recording};

/// Half width, in ln, of the band around 57.3: a factor of 2.5 for the regression, and 30 % for the user's value.
const NEAR: f64 = 1.2;
/// Largest rate that a gyro of a vehicle measures (2,000 °/s), rad/s.
const LARGEST_RATE: f64 = 35.0;
/// A turn, rad.
const LARGEST_ANGLE: f64 = std::f64::consts::TAU;
/// The columns of the measured motion.
const MOTION: [&str; 2] = ["q_rad_s", "theta_rad"];
const NO_MODEL: &str = "no model says what the response to the input should be";
const NO_INPUT: &str = "the input never changes";

/// ∂M/∂u of the data and of the user's model.
pub struct Response<'a> {
    fitted: Option<Estimate>,
    rough: Option<f64>,
    given: Option<f64>,
    recordings: &'a [Recording],
}

impl<'a> Response<'a> {
    /// Takes the estimate out of `estimates`; `given` is the model's value.
    pub fn new(
        recordings: &'a [Recording],
        problem: &Problem<'_>,
        estimates: Vec<Estimate>,
        given: Option<f64>,
    ) -> Self {
        Self {
            fitted: estimates.into_iter().find(|e| e.name == "dM_du"),
            rough: rough_gain(problem.data).map(|gain| gain * problem.baseline.plant.inertia),
            given,
            recordings,
        }
    }

    /// The sign. Where no section is open loop (`fed_back`), the fitted sign may be that of the controller.
    pub fn sign(&self, fed_back: bool) -> DataCheck {
        const CAUSE: &str = "input_sign";
        let (Some(gain), Some(given)) = (&self.fitted, self.given) else {
            let known = self.fitted.as_ref().map_or(String::new(), |g| format!("; the data have {g}"));
            return DataCheck::cannot_tell(CAUSE, format!("{NO_MODEL}{known}"));
        };
        let Some(rough) = self.rough else { return DataCheck::cannot_tell(CAUSE, NO_INPUT) };
        let described =
            format!("the data have {} (a regression: {}), the model {}", gain, digits(rough), digits(given));
        let clear = gain.ci95[0] * gain.ci95[1] > 0.0 && gain.value * rough > 0.0;
        if clear && gain.value * given > 0.0 {
            return DataCheck::ruled_out(CAUSE, described);
        }
        if clear && !fed_back {
            let advice = self.option(&[self.column()], -1.0);
            return DataCheck::found(
                CAUSE,
                Gravity::Stops,
                format!(
                    "the input is reversed against the model, or all of the measured motion is: {described}; read it with {advice}, or turn the model's sign"
                ),
            );
        }
        DataCheck::cannot_tell(CAUSE, described)
    }

    /// The unit.
    pub fn unit(&self) -> DataCheck {
        const CAUSE: &str = "input_unit";
        let looks_wrong = || {
            let note = self.recordings.iter().find_map(|r| too_large(r, self.column()))?;
            Some(DataCheck::found(CAUSE, Gravity::Headline, note))
        };
        let (Some(gain), Some(given)) = (&self.fitted, self.given) else {
            return looks_wrong().unwrap_or_else(|| DataCheck::cannot_tell(CAUSE, NO_MODEL));
        };
        let Some(rough) = self.rough else { return DataCheck::cannot_tell(CAUSE, NO_INPUT) };
        let ratio = (rough / given).abs();
        let described = format!(
            "a regression has ∂M/∂u at {} {}, {} times the model's {}",
            digits(rough),
            gain.unit,
            digits(ratio),
            digits(given)
        );
        let clear = gain.ci95[0] * gain.ci95[1] > 0.0;
        let near = |factor: f64| (ratio / factor).ln().abs() < NEAR;
        let in_radians = self.recordings.iter().all(|r| r.u_unit == InputUnit::Rad);
        let wrong = if in_radians && clear && near(1.0 / DEGREES) {
            Some(("the input is", vec![self.column()]))
        } else if near(DEGREES) && self.motion_is_beyond_radians() {
            Some(("the measured motion is", MOTION.to_vec()))
        } else {
            None
        };
        if let Some((what, columns)) = wrong {
            let advice = self.option(&columns, 1.0 / DEGREES);
            let words = format!("{what} in degrees where radians belong: {described}; read it with {advice}");
            return DataCheck::found(CAUSE, Gravity::Stops, words);
        }
        if clear && near(DEGREES) {
            let advice = self.option(&MOTION, 1.0 / DEGREES);
            return DataCheck::cannot_tell(
                CAUSE,
                format!(
                    "{described}: either the model's value is a placeholder, or the motion is in degrees (then read it with {advice})"
                ),
            );
        }
        looks_wrong().unwrap_or_else(|| {
            if ratio.ln().abs() < TOLERABLE {
                DataCheck::ruled_out(CAUSE, described)
            } else {
                DataCheck::cannot_tell(CAUSE, format!("{described}, which is no unit's factor"))
            }
        })
    }

    /// Whether rate or angle is larger than a gyro or a rig reaches in radians.
    fn motion_is_beyond_radians(&self) -> bool {
        let beyond = |values: &Option<Vec<f64>>, limit: f64| values.iter().flatten().any(|v| v.abs() > limit);
        self.recordings.iter().any(|r| beyond(&r.q, LARGEST_RATE) || beyond(&r.theta, LARGEST_ANGLE))
    }

    fn column(&self) -> &'static str {
        self.recordings.first().map_or("u_rad", |r| r.u_unit.column())
    }

    /// The options that scale these columns, as far as they are there.
    fn option(&self, columns: &[&str], factor: f64) -> String {
        let first = self.recordings.first();
        let all = columns.iter().filter_map(|column| first?.option_to_scale(column, factor));
        all.collect::<Vec<_>>().join(" ")
    }
}
