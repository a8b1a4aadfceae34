//! One signal out of a log: which fields of which topic, put together how, in which unit.

use std::fmt;

use super::Axis;
use crate::{Log, Topic, rate_hz};

/// A field times a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// The field's name in its topic.
    pub field: String,
    /// What it is multiplied by.
    pub factor: f64,
}

/// How the fields of a row make one number.
#[derive(Clone, Debug, PartialEq)]
pub enum Formula {
    /// Σ factor · field + offset.
    Sum {
        /// What is added up.
        terms: Vec<Term>,
        /// What is added to that.
        offset: f64,
    },
    /// An angle (rad) out of the quaternion w, x, y, z from the body (x forward, y right, z down) to the ground, in the
    /// order yaw, pitch, roll: roll atan2(2(wx + yz), 1 − 2(x² + y²)), pitch asin(2(wy − zx)),
    /// yaw atan2(2(wz + xy), 1 − 2(y² + z²)).
    Euler {
        /// The fields of w, x, y, z.
        quaternion: [String; 4],
        /// Which of the three angles.
        axis: Axis,
    },
    /// What the caller worked out of other channels; the topic is left empty.
    Worked {
        /// How, for people.
        text: String,
        /// The result.
        series: Series,
    },
}

/// A signal that a log holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The topic's name.
    pub topic: String,
    /// The topic's instance.
    pub instance: u8,
    /// How its fields make the signal.
    pub formula: Formula,
    /// The signal's unit: rad/s, rad, V, or 1 for what the autopilot normalises.
    pub unit: &'static str,
    /// Rows per second ([`Topic::rate_hz`]).
    pub rate_hz: Option<f64>,
    /// Why this one, and what to know of it.
    pub reason: String,
}

/// A signal with its times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Times on the log's clock, s.
    pub time_s: Vec<f64>,
    /// Finite values, as many.
    pub values: Vec<f64>,
}

impl Channel {
    /// The field that a user names as `topic.field`, or `topic.instance.field`, times `factor`; `None` where the log
    /// has none of this name.
    #[must_use]
    pub fn named(log: &Log, name: &str, factor: f64, unit: &'static str) -> Option<Self> {
        log.topics.iter().find_map(|topic| {
            let field = name.strip_prefix(&topic.title())?.strip_prefix('.')?;
            Self::sum(topic, &[(field.to_owned(), factor)], unit, "as asked")
        })
    }

    /// What the caller worked out of other channels, as `text` says.
    #[must_use]
    pub fn worked(text: String, series: Series, unit: &'static str) -> Self {
        Self {
            topic: String::new(),
            instance: 0,
            rate_hz: rate_hz(&series.time_s),
            formula: Formula::Worked { text, series },
            unit,
            reason: "as asked".to_owned(),
        }
    }

    /// The sum of fields of a topic, if they are all there.
    pub(super) fn sum(
        topic: &Topic,
        terms: &[(String, f64)],
        unit: &'static str,
        reason: impl Into<String>,
    ) -> Option<Self> {
        let there = !terms.is_empty() && terms.iter().all(|(field, _)| topic.field(field).is_some());
        let terms =
            terms.iter().map(|(field, factor)| Term { field: field.clone(), factor: *factor }).collect();
        there.then(|| Self::of(topic, Formula::Sum { terms, offset: 0.0 }, unit, reason.into()))
    }

    /// An angle out of the fields `prefix[0]` to `prefix[3]`.
    pub(super) fn euler(topic: &Topic, prefix: &str, axis: Axis, reason: &str) -> Option<Self> {
        let quaternion = [0, 1, 2, 3].map(|i| format!("{prefix}[{i}]"));
        let there = quaternion.iter().all(|field| topic.field(field).is_some());
        there.then(|| Self::of(topic, Formula::Euler { quaternion, axis }, "rad", reason.to_owned()))
    }

    fn of(topic: &Topic, formula: Formula, unit: &'static str, reason: String) -> Self {
        Self {
            topic: topic.name.clone(),
            instance: topic.instance,
            formula,
            unit,
            rate_hz: topic.rate_hz(),
            reason,
        }
    }

    pub(super) fn plus(mut self, more: f64) -> Self {
        if let Formula::Sum { offset, .. } = &mut self.formula {
            *offset += more;
        }
        self
    }

    /// The signal's rows in `log` that are finite; empty where the log lacks the topic or a field.
    #[must_use]
    pub fn series(&self, log: &Log) -> Series {
        self.values(log).unwrap_or_default()
    }

    fn values(&self, log: &Log) -> Option<Series> {
        if let Formula::Worked { series, .. } = &self.formula {
            return Some(series.clone());
        }
        let topic = log.topic(&self.topic, self.instance)?;
        let field = |name: &str| topic.field(name).map(|field| field.values.as_slice());
        let values: Vec<f64> = match &self.formula {
            Formula::Sum { terms, offset } => {
                let mut values = vec![*offset; topic.time_s.len()];
                for term in terms {
                    for (value, part) in values.iter_mut().zip(field(&term.field)?) {
                        *value += term.factor * part;
                    }
                }
                values
            }
            Formula::Euler { quaternion: [w, x, y, z], axis } => {
                let (w, x, y, z) = (field(w)?, field(x)?, field(y)?, field(z)?);
                let rows = w.iter().zip(x).zip(y).zip(z);
                rows.map(|(((&w, &x), &y), &z)| angle(*axis, [w, x, y, z])).collect()
            }
            Formula::Worked { .. } => return None,
        };
        let rows = topic.time_s.iter().zip(values).filter(|(_, value)| value.is_finite());
        let (time_s, values) = rows.map(|(&time_s, value)| (time_s, value)).unzip();
        Some(Series { time_s, values })
    }
}

fn angle(axis: Axis, [w, x, y, z]: [f64; 4]) -> f64 {
    match axis {
        Axis::Roll => (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)),
        // Rounding may carry the sine of a steep pitch beyond 1.
        Axis::Pitch => (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin(),
        Axis::Yaw => (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
    }
}

/// As people write it: `RATE.P * 0.017453`, `main.axisP[1] * 0.001 + main.axisI[1] * 0.001`, `pitch of
/// vehicle_attitude.q[0]..3`.
impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let title =
            if self.instance == 0 { self.topic.clone() } else { format!("{}.{}", self.topic, self.instance) };
        match &self.formula {
            Formula::Sum { terms, offset } => {
                for (i, Term { field, factor }) in terms.iter().enumerate() {
                    let plus = if i == 0 { "" } else { " + " };
                    write!(f, "{plus}{title}.{field}")?;
                    if *factor != 1.0 {
                        write!(f, " * {}", short(*factor))?;
                    }
                }
                if *offset != 0.0 {
                    write!(f, " + {}", short(*offset))?;
                }
                Ok(())
            }
            Formula::Euler { quaternion, axis } => write!(f, "{axis} of {title}.{}..3", quaternion[0]),
            Formula::Worked { text, .. } => f.write_str(text),
        }
    }
}

fn short(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_of_quaternions() {
        let half = 0.3_f64 / 2.0;
        for (axis, quaternion) in [
            (Axis::Roll, [half.cos(), half.sin(), 0.0, 0.0]),
            (Axis::Pitch, [half.cos(), 0.0, half.sin(), 0.0]),
            (Axis::Yaw, [half.cos(), 0.0, 0.0, half.sin()]),
        ] {
            for other in [Axis::Roll, Axis::Pitch, Axis::Yaw] {
                let expected = if other == axis { 0.3 } else { 0.0 };
                assert!((angle(other, quaternion) - expected).abs() < 1e-12, "{axis} in {other}");
            }
        }
    }
}
