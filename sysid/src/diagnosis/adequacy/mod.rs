//! Whether anything is left in the innovations of a fitted model: a family of tests with one level.
//!
//! Where the model is right, its innovations are white noise of one size (Kailath, 1968), and unpredictable from all that
//! was known before. Every test looks for one way in which they are not, and says with which probability chance alone
//! goes so far; [`failing`] holds the whole family to one level. On a few seconds the noise itself is a guess.
//!
//! | test | what it looks for |
//! | --- | --- |
//! | `line` | a moment of one frequency |
//! | `burst`, `unevenness` | windows of time in which the disturbance is stronger than elsewhere |
//! | `tails` | errors larger than those of Gaussian noise |
//! | `switches` | errors that grow after a switch of the input, at large rates, at large angles |
//! | `constancy` | parameters that are not the same everywhere |
//! | `moment`, `sensor`, `time` | any moment of (u, q, θ), any addition to the measurement, any change over time |

mod burst;
mod constancy;
pub(super) mod features;
pub(super) mod left;
mod line;
mod noise;
mod p_values;
mod score;
#[cfg(test)]
mod sizes;
mod switches;
mod tails;

use crate::dataset::Place;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use left::Left;

/// One test of what a model leaves.
#[derive(Clone, Debug)]
pub struct Test {
    /// What is tested: `line`, `burst`, `unevenness`, `tails`, `switches`, `constancy`, `moment`, `sensor` or `time`.
    pub name: &'static str,
    /// The figure that is compared with chance.
    pub statistic: f64,
    /// Probability that chance alone gives as much, corrected for all that the test looked at.
    pub p_value: f64,
    /// 2 ln likelihood that a model with what the test sees would gain, about; 0 where the test says nothing of a missing
    /// mean.
    pub closes: f64,
    /// Whether it speaks of missing physics, and not of a background that is uneven or heavy-tailed.
    pub of_physics: bool,
    /// Windows of time, s; empty for the whole recording.
    pub windows: Vec<[f64; 2]>,
    /// As the end of "what the model leaves is ...".
    pub words: String,
}

impl Test {
    /// A test that finds nothing, or has too little to look at.
    fn silent(name: &'static str, of_physics: bool) -> Self {
        let words = String::from("too short to tell");
        Self { name, statistic: 0.0, p_value: 1.0, closes: 0.0, of_physics, windows: Vec::new(), words }
    }
}

/// All tests of `fit`, in a fixed order; `sections` are the parts of the data between which its parameters are compared.
/// Empty where the fit has no finite innovations or derivatives. Where one speaks of missing physics at `level`, and the data are too
/// short for the noise to be known, every p-value is that of all noise that is as likely.
pub fn tests(problem: &Problem<'_>, fit: &Fit, sections: &[Place], level: f64) -> Vec<Test> {
    let mut all = with_its_noise(problem, fit, sections);
    if failing(&all, level).iter().any(|test| test.of_physics) {
        let beside = noise::as_likely(problem, fit);
        let beside: Vec<Vec<Test>> =
            beside.iter().map(|fit| with_its_noise(problem, fit, sections)).collect();
        for (i, test) in all.iter_mut().enumerate() {
            let p_values: Vec<f64> = beside.iter().filter_map(|tests| Some(tests.get(i)?.p_value)).collect();
            if !p_values.is_empty() {
                test.p_value = p_values.iter().sum::<f64>() / p_values.len() as f64;
            }
        }
    }
    all
}

fn with_its_noise(problem: &Problem<'_>, fit: &Fit, sections: &[Place]) -> Vec<Test> {
    let Some(left) = Left::new(problem, fit) else { return Vec::new() };
    vec![
        line::test(&left),
        burst::test(&left),
        tails::test(&left),
        switches::test(&left),
        constancy::test(&left, problem, fit, sections),
        features::moment(&left),
        features::sensor(&left),
        features::time(&left),
    ]
}

/// Those that fail when the probability of one false failure among all is held to `level` (Holm, Scandinavian Journal of
/// Statistics 6, 1979), least p-value first.
pub fn failing(tests: &[Test], level: f64) -> Vec<&Test> {
    let mut sorted: Vec<&Test> = tests.iter().collect();
    sorted.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    let fails = |(i, test): (usize, &&Test)| test.p_value <= level / (tests.len() - i) as f64;
    let count = sorted.iter().enumerate().take_while(|&(i, test)| fails((i, test))).count();
    sorted.truncate(count);
    sorted
}

#[cfg(test)]
mod unit {
    use super::*;
    use crate::diagnosis::data_checks::fixture::{GAIN, fitted, flight, flown, model};

    fn with(p_value: f64) -> Test {
        Test { p_value, ..Test::silent("line", true) }
    }

    #[test]
    fn holm_stops_at_the_first_that_does_not_fail() {
        let all = [0.03, 0.001, 0.9, 0.014].map(with);
        let failed: Vec<f64> = failing(&all, 0.05).iter().map(|t| t.p_value).collect();
        // 0.001 against 0.05/4, 0.014 against 0.05/3, 0.03 against 0.05/2
        assert_eq!(failed, [0.001, 0.014]);
        assert!(failing(&[0.02, 0.02, 0.02].map(with), 0.05).is_empty());
        assert!(failing(&[], 0.05).is_empty());
    }

    #[test]
    fn a_flight_of_the_model_leaves_nothing_and_one_of_another_actuator_something() {
        let all = |flight: crate::recording::Recording| {
            fitted(&flight, &model(GAIN, 0.06), |_, problem, fit| {
                tests(problem, fit, &problem.data.places(), 0.01)
            })
        };
        let right = all(flight(3, 0.0).recording());
        let names: Vec<&str> = right.iter().map(|t| t.name).collect();
        assert_eq!(names, ["line", "burst", "tails", "switches", "constancy", "moment", "sensor", "time"]);
        assert!(failing(&right, 0.01).is_empty(), "{right:?}");
        // half of the moment comes a sample early
        let wrong = all(flown(3, 0.0, [0.5, 0.5]).recording());
        let failed = failing(&wrong, 0.01);
        assert!(failed.iter().any(|t| t.name == "switches" && t.of_physics), "{wrong:?}");
    }
}
