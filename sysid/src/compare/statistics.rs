//! Whether two estimates differ.
//!
//! With δ = after − before, σ² = σ_b² + σ_a², and degrees of freedom ν after Welch (Biometrika 34, 1947),
//!
//! ```text
//! t = δ/σ,   p = 2 P(T_ν > |t|),   z = the normal deviate of the same p
//! ```
//!
//! The evidence for "changed" over "same" is that of separate values over a common one (Savage and Dickey, Ann. Math.
//! Stat. 42, 1971), with the prior δ ~ N(0, s²), s the size of a usual change:
//!
//! ```text
//! ln B = ½ ( z² s²/(s² + σ²) − ln(1 + s²/σ²) ),   P(changed) = B/(1 + B)
//! ```
//!
//! for even prior odds. Told as changed is what has p < [`LEVEL`] after Holm's correction for all quantities of the
//! comparison (Scand. J. Stat. 6, 1979), P(changed) ≥ [`SURE`], and a 95 % interval beyond ± s/10: no two flights of one craft are the
//! same to the last digit, and a tenth of a usual change matters to nobody.

use crate::estimate::Estimate;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Probability with which a craft that is the same gets any change told.
pub const LEVEL: f64 = 0.01;
/// Least posterior probability of a change that is told.
pub const SURE: f64 = 0.95;
/// Share of a usual change that matters to nobody.
const NEGLIGIBLE: f64 = 0.1;
/// Probability with which an effect of the size that "would have been seen" is seen.
const POWER: f64 = 0.9;
/// Usual changes that an effect must have to be seen, beyond which the data cannot tell.
const COARSE: f64 = 3.0;
/// Degrees of freedom from which on a deviation counts as known.
const MANY: f64 = 1e4;
/// Largest normal deviate that is told: the probability behind it is no number any more.
const LARGEST_Z: f64 = 38.0;

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// Its standard deviation; infinite where the data do not tell.
    pub deviation: f64,
    /// Degrees of freedom of the deviation; infinite where it is known.
    pub freedom: f64,
}

impl Measured {
    /// `other` less this.
    #[must_use]
    pub fn to(&self, other: &Self) -> Self {
        let [b, a] = [self.deviation, other.deviation].map(|deviation| deviation * deviation);
        let spread = b * b / self.freedom + a * a / other.freedom;
        let freedom = if spread > 0.0 { (b + a) * (b + a) / spread } else { f64::INFINITY };
        let freedom = if freedom.is_nan() { f64::INFINITY } else { freedom };
        Self { value: other.value - self.value, deviation: (b + a).sqrt(), freedom }
    }

    /// With the standard error of the mean of `parts` where that is more.
    #[must_use]
    pub fn or_spread(self, parts: &[f64]) -> Self {
        let count = parts.len() as f64;
        let mean = parts.iter().sum::<f64>() / count;
        let spread = parts.iter().map(|part| (part - mean).powi(2)).sum::<f64>();
        let deviation = (spread / (count * (count - 1.0))).sqrt();
        if deviation > self.deviation { Self { deviation, freedom: count - 1.0, ..self } } else { self }
    }

    /// With its 95 % interval.
    #[must_use]
    pub fn estimate(&self, name: &str, unit: &str) -> Estimate {
        let reach =
            if self.deviation.is_finite() { self.quantile(0.05) * self.deviation } else { f64::INFINITY };
        let ci95 = [self.value - reach, self.value + reach];
        Estimate { name: name.into(), unit: unit.into(), value: self.value, ci95 }
    }

    /// Deviations beyond which `level` of the probability lies, both sides together.
    fn quantile(&self, level: f64) -> f64 {
        if self.freedom < MANY
            && let Ok(student) = StudentsT::new(0.0, 1.0, self.freedom.max(1.0))
        {
            return student.inverse_cdf(1.0 - 0.5 * level);
        }
        Normal::standard().inverse_cdf(1.0 - 0.5 * level)
    }

    /// p of a value this far from zero.
    fn p_value(&self) -> f64 {
        let t = (self.value / self.deviation).abs();
        if self.freedom < MANY
            && let Ok(student) = StudentsT::new(0.0, 1.0, self.freedom.max(1.0))
        {
            return 2.0 * student.sf(t);
        }
        2.0 * Normal::standard().sf(t)
    }
}

/// What is said of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It changed.
    Changed,
    /// No change is seen, and one of a usual size would have been.
    Same,
    /// The data cannot tell.
    CannotTell,
}

/// What the data say of a difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// What is said.
    pub verdict: Verdict,
    /// Normal deviate, with the sign of the difference.
    pub z: f64,
    /// p-value after Holm's correction.
    pub p_value: f64,
    /// Posterior probability of a change.
    pub probability: f64,
    /// A change of this size would have been told, nine times in ten; none where the data do not tell.
    pub would_be_seen: Option<f64>,
}

impl Difference {
    /// Whether chance hardly makes it, be it too little to matter.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.p_value < LEVEL
    }
}

/// Judges pairs of before and after, each with the size of a usual change, together.
#[must_use]
pub fn judge(pairs: &[([Measured; 2], f64)]) -> Vec<Difference> {
    let differences: Vec<Measured> = pairs.iter().map(|([before, after], _)| before.to(after)).collect();
    let known: Vec<usize> = (0..pairs.len()).filter(|&i| differences[i].deviation.is_finite()).collect();
    let adjusted = holm(&known.iter().map(|&i| differences[i].p_value()).collect::<Vec<f64>>());
    let level = LEVEL / known.len().max(1) as f64;
    let told = |i: usize| {
        let difference = &differences[i];
        let Some(place) = known.iter().position(|&k| k == i) else {
            return Difference {
                verdict: Verdict::CannotTell,
                z: 0.0,
                p_value: 1.0,
                probability: 0.5,
                would_be_seen: None,
            };
        };
        let p = difference.p_value();
        let z = if p > 0.0 { (-Normal::standard().inverse_cdf(0.5 * p)).min(LARGEST_Z) } else { LARGEST_Z };
        let probability = probability(z, difference.deviation, pairs[i].1);
        let power = Normal::standard().inverse_cdf(POWER);
        let seen = (difference.quantile(level) + power) * difference.deviation;
        let beyond_chance = adjusted[place] < LEVEL;
        let least = difference.value.abs() - difference.quantile(0.05) * difference.deviation;
        let matters = least > NEGLIGIBLE * pairs[i].1;
        let verdict = if beyond_chance && probability >= SURE && matters {
            Verdict::Changed
        } else if !(beyond_chance && matters) && seen <= COARSE * pairs[i].1 {
            Verdict::Same
        } else {
            Verdict::CannotTell
        };
        let z = z.copysign(difference.value);
        let negligible = NEGLIGIBLE * pairs[i].1 + (difference.quantile(0.05) + power) * difference.deviation;
        let would_be_seen = Some(seen.max(negligible));
        Difference { verdict, z, p_value: adjusted[place], probability, would_be_seen }
    };
    (0..pairs.len()).map(told).collect()
}

/// ln B of a difference `z` deviations from zero, `usual` the size of a usual one.
#[must_use]
pub fn log_odds(z: f64, deviation: f64, usual: f64) -> f64 {
    let ratio = (usual / deviation).powi(2);
    0.5 * (z * z * ratio / (1.0 + ratio) - ratio.ln_1p())
}

/// P(changed).
fn probability(z: f64, deviation: f64, usual: f64) -> f64 {
    1.0 / (1.0 + (-log_odds(z, deviation, usual)).exp())
}

/// p-values after Holm's correction.
fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let (mut adjusted, mut least) = (vec![1.0; p_values.len()], 0.0_f64);
    for (rank, &i) in order.iter().enumerate() {
        least = least.max((p_values.len() - rank) as f64 * p_values[i]).min(1.0);
        adjusted[i] = least;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(value: f64, deviation: f64) -> Measured {
        Measured { value, deviation, freedom: f64::INFINITY }
    }

    #[test]
    fn differences_are_judged_together() {
        let unknown = known(0.0, f64::INFINITY);
        let judged = judge(&[
            ([known(0.0, 0.1), known(2.0, 0.1)], 1.0),
            ([known(1.0, 0.1), known(1.1, 0.1)], 0.5),
            ([known(1.0, 1.0), known(1.5, 1.0)], 0.5),
            ([unknown, known(1.0, 0.1)], 0.5),
        ]);
        let verdicts = judged.iter().map(|d| d.verdict).collect::<Vec<_>>();
        use Verdict::{CannotTell, Changed, Same};
        assert_eq!(verdicts, [Changed, Same, CannotTell, CannotTell]);
        assert!((judged[0].z - 14.14).abs() < 0.5, "{:?}", judged[0]);
        assert!(judged[0].probability > 0.999 && judged[1].probability < 0.5);
        assert_eq!(judged[3].would_be_seen, None);
    }

    #[test]
    fn what_matters_to_nobody_is_no_change() {
        let told = |value: f64, deviation: f64| {
            judge(&[([known(0.0, 0.0), known(value, deviation)], 0.05)])[0].verdict
        };
        assert_eq!(told(0.0047, 0.0008), Verdict::Same, "certain, and a tenth of a usual change");
        assert_eq!(told(0.02, 0.0008), Verdict::Changed);
        assert_eq!(told(0.02, 0.008), Verdict::Same);
        assert_eq!(told(0.2, 0.06), Verdict::CannotTell, "beyond chance, and not sure");
    }

    #[test]
    fn welch_and_savage_dickey_by_hand() {
        let side = |value| Measured { value, deviation: 1.0, freedom: 7.0 };
        let difference = side(0.0).to(&side(3.0));
        assert!(
            (difference.freedom - 14.0).abs() < 1e-12 && (difference.deviation - 2_f64.sqrt()).abs() < 1e-12
        );
        let ci95 = difference.estimate("x", "1").ci95;
        assert!((ci95[1] - 3.0 - 2.1448 * 2_f64.sqrt()).abs() < 1e-3, "{ci95:?}");
        // s = σ: ln B = ½ (z²/2 − ln 2)
        let odds = (0.5 * (9.0 / 2.0 - 2_f64.ln())).exp();
        assert!((probability(3.0, 2.0, 2.0) - odds / (1.0 + odds)).abs() < 1e-12);
        assert_eq!(holm(&[0.03, 0.01, 0.5]), [0.06, 0.03, 0.5]);
    }
}
