//! Two effects that look alike, and the chance that a test tells them apart.
//!
//! Each in turn is concealed in the craft, with the parameters at which it comes nearest to the other, and flown; both are then
//! fitted to what was recorded. A contest is decided where the odds of one against the other are 20 to 1.

use crate::Error;
use crate::craft::Craft;
use crate::forecast::recordings;
use crate::test::{Test, Weather};
use host_sim::Setting;
use rayon::prelude::*;
use serde::Serialize;
use sysid::likelihood::contest::contest;

/// 2 ln of the odds that decide: 20 to 1.
const DECIDED: f64 = 5.99;
/// Flights of the test in hand from which the second rival takes its parameters.
const PAST: u64 = 1;

/// Two rivals.
#[derive(Clone, Debug)]
pub struct Rivals {
    /// The one that stands in the model, or is named first.
    pub first: Setting,
    /// The other, as it imitates the first.
    pub second: Setting,
}

/// How often a test decides.
#[derive(Clone, Debug, Serialize)]
pub struct Chance {
    /// The rivals.
    pub rivals: [&'static str; 2],
    /// Contests that were flown, half of them with each rival concealed.
    pub flown: usize,
    /// Of them decided for the one that was concealed.
    pub right: usize,
    /// Of them decided for the other.
    pub wrong: usize,
    /// Middle of 2 ln(odds) for the one that was concealed.
    pub evidence: f64,
}

impl Rivals {
    /// The rival `other` at the parameters with which it imitates `first` in `test`.
    ///
    /// # Errors
    /// An effect that the diagnosis or the simulator does not know.
    pub fn new(
        first: Setting,
        other: &str,
        craft: &Craft,
        test: &Test,
        weather: Weather,
    ) -> Result<Self, Error> {
        let ids = [first.entry().id, other];
        let past = recordings(&[*test], craft, std::slice::from_ref(&first), weather, PAST)?;
        let [_, parameters] = contest(&past, &craft.model, ids)?.parameters;
        let named: Vec<(&str, f64)> =
            parameters.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        Ok(Self { second: Setting::new(other, &named)?, first })
    }

    fn ids(&self) -> [&'static str; 2] {
        [self.first.entry().id, self.second.entry().id]
    }

    /// Flies `tests` with each rival concealed, once for every seed, and lets them contest.
    ///
    /// # Errors
    /// A craft that cannot be.
    pub fn chance(
        &self,
        tests: &[Test],
        craft: &Craft,
        weather: Weather,
        seeds: &[u64],
    ) -> Result<Chance, Error> {
        let rivals = self.ids();
        let flown: Vec<(u64, bool)> = seeds.iter().flat_map(|&seed| [(seed, true), (seed, false)]).collect();
        let one = |&(seed, is_first): &(u64, bool)| -> Result<f64, Error> {
            let concealed = if is_first { &self.first } else { &self.second };
            let found = recordings(tests, craft, std::slice::from_ref(concealed), weather, seed)?;
            let evidence = contest(&found, &craft.model, rivals)?.evidence;
            Ok(if is_first { evidence } else { -evidence })
        };
        let mut evidence = flown.par_iter().map(one).collect::<Result<Vec<f64>, Error>>()?;
        evidence.sort_by(f64::total_cmp);
        Ok(Chance {
            rivals,
            flown: evidence.len(),
            right: evidence.iter().filter(|&&e| e >= DECIDED).count(),
            wrong: evidence.iter().filter(|&&e| e <= -DECIDED).count(),
            evidence: evidence.get(evidence.len() / 2).copied().unwrap_or(0.0),
        })
    }
}
