//! What a test will show: flown many times in the simulator, with the core, each time on a craft as it may be and in air drawn
//! afresh; and what its recording will tell.

use crate::Error;
use crate::craft::Craft;
use crate::test::{Flown, Test, Weather, recording};
use host_sim::Setting;
use rayon::prelude::*;
use serde::Serialize;
use sysid::estimate::Estimate;
use sysid::likelihood::precision::precision;
use sysid::recording::Recording;

/// Half a 95 % interval in per cent of the value, or in s where the value may be zero.
const PER_CENT: f64 = 100.0;

/// The least, the middle and the largest of what was flown. A further test lies between the outer two with a probability of
/// (n − 1)/(n + 1) of n flown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Band {
    /// The least.
    pub least: f64,
    /// The middle.
    pub median: f64,
    /// The largest.
    pub most: f64,
}

impl Band {
    /// Of these values; infinite where there are none.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |k: usize| values.get(k).copied().unwrap_or(f64::INFINITY);
        Self { least: at(0), median: at(values.len() / 2), most: at(values.len().saturating_sub(1)) }
    }

    /// Whether a value lies in it.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

/// What the flights of a test show.
#[derive(Clone, Debug, Serialize)]
pub struct Excursion {
    /// How many were flown.
    pub flights: usize,
    /// Largest angle, rad.
    pub angle_rad: Band,
    /// Largest rate, rad/s.
    pub rate_rad_s: Band,
    /// Of the excited samples, those in which the supervisor held the craft, %.
    pub overridden_percent: Band,
    /// Length with recoveries, s.
    pub length_s: Band,
    /// How many the supervisor broke off.
    pub broken_off: usize,
}

/// How well the recordings tell a parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Accuracy {
    /// The parameter, as in model files.
    pub name: String,
    /// Unit of the half-width: `%` of the value, or `s`.
    pub unit: &'static str,
    /// Half the 95 % interval.
    pub half_width: Band,
}

/// Flies `test` once for every seed.
///
/// # Errors
/// A craft that cannot be.
pub fn flights(test: &Test, craft: &Craft, weather: Weather, seeds: &[u64]) -> Result<Vec<Flown>, Error> {
    let one = |&seed: &u64| Ok(Flown::of(&test.fly(craft, &[], weather, seed)?));
    seeds.par_iter().map(one).collect()
}

/// What these flights show together.
#[must_use]
pub fn excursion(flights: &[Flown]) -> Excursion {
    let band = |value: &dyn Fn(&Flown) -> f64| Band::of(flights.iter().map(value).collect());
    Excursion {
        flights: flights.len(),
        angle_rad: band(&|flown| flown.angle_rad),
        rate_rad_s: band(&|flown| flown.rate_rad_s),
        overridden_percent: band(&|flown| PER_CENT * flown.overridden),
        length_s: band(&|flown| flown.length_s),
        broken_off: flights.iter().filter(|flown| flown.broken_off).count(),
    }
}

/// What the recordings of `tests`, estimated from together, tell with every seed; `one_more` hears of each.
///
/// # Errors
/// A craft that cannot be.
pub fn accuracy(
    tests: &[Test],
    craft: &Craft,
    weather: Weather,
    seeds: &[u64],
    one_more: &(dyn Fn() + Sync),
) -> Result<Vec<Accuracy>, Error> {
    let all = seeds.par_iter().map(|&seed| {
        let found = estimated(tests, craft, &[], weather, seed);
        one_more();
        found
    });
    let all: Vec<Vec<Estimate>> = all.collect::<Result<_, Error>>()?;
    let names: Vec<String> =
        all.first().map(|one| one.iter().map(|e| e.name.clone()).collect()).unwrap_or_default();
    let of = |(place, name): (usize, String)| {
        let unit = if name == "delay" { "s" } else { "%" };
        let widths = all.iter().filter_map(|one| one.get(place)).map(half_width).collect();
        Accuracy { name, unit, half_width: Band::of(widths) }
    };
    Ok(names.into_iter().enumerate().map(of).collect())
}

/// Half the interval of an estimate, in the unit in which an accuracy is told.
#[must_use]
pub fn half_width(estimate: &Estimate) -> f64 {
    let [low, high] = estimate.ci95;
    let half = 0.5 * (high - low);
    if estimate.name == "delay" { half } else { PER_CENT * half / estimate.value.abs() }
}

/// What the recordings of `tests` tell with one seed.
///
/// # Errors
/// A craft that cannot be.
pub fn estimated(
    tests: &[Test],
    craft: &Craft,
    concealed: &[Setting],
    weather: Weather,
    seed: u64,
) -> Result<Vec<Estimate>, Error> {
    Ok(precision(&recordings(tests, craft, concealed, weather, seed)?, &craft.model)?)
}

/// The recordings of `tests`, one after the other on the same craft.
///
/// # Errors
/// A craft that cannot be.
pub fn recordings(
    tests: &[Test],
    craft: &Craft,
    concealed: &[Setting],
    weather: Weather,
    seed: u64,
) -> Result<Vec<Recording>, Error> {
    tests.iter().map(|test| recording(&test.fly(craft, concealed, weather, seed)?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_holds_what_it_was_made_of() {
        let band = Band::of(vec![3.0, 1.0, 2.0]);
        assert_eq!(band, Band { least: 1.0, median: 2.0, most: 3.0 });
        assert!(band.holds(1.0) && band.holds(3.0) && !band.holds(3.1));
        assert_eq!(Band::of(Vec::new()).most, f64::INFINITY);
    }
}
