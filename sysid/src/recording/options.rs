//! What a caller may say about a recording: columns of other names, sections by time, the input's hold.

use std::str::FromStr;

use super::columns::{KNOWN_COLUMNS, Role, is_of_another_axis};
use super::expression::Expression;
use crate::error::{Error, ErrorKind, nearest, quote};

/// How the input behaves between two samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InputHold {
    /// A command held over [t_k, t_k+1) (zero-order hold).
    #[default]
    Held,
    /// A measured input, straight between samples (first-order hold).
    Interpolated,
}

impl FromStr for InputHold {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "held" => Ok(Self::Held),
            "interpolated" => Ok(Self::Interpolated),
            other => Err(Error::new(
                ErrorKind::Options,
                format!("--input {}", quote(other)),
                "choose one of the two",
            )
            .expecting("held (a command) or interpolated (a measured input)")),
        }
    }
}

/// One `--column TARGET=EXPRESSION`: `source`, worked out of the file's columns, times `factor` is the project's `target`.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnMap {
    /// A column of the format, e.g. `q_rad_s`.
    pub target: String,
    /// A column of the file, or arithmetic over several.
    pub source: Expression,
    /// Finite, not zero, at most 1e12 in magnitude.
    pub factor: f64,
}

impl ColumnMap {
    /// The option that multiplies the column by `factor` on top of its own.
    #[must_use]
    pub fn option_to_scale(&self, factor: f64) -> String {
        let scale = self.factor * factor;
        let scale = format!("{scale:.6e}").parse::<f64>().unwrap_or(scale);
        match scale {
            1.0 => format!("--column '{}={}'", self.target, self.source),
            scale => format!("--column '{}={}'", self.target, self.source.scaled(scale)),
        }
    }

    /// The option that holds the column between two values.
    #[must_use]
    pub fn option_to_limit(&self, ends: [f64; 2]) -> String {
        let read = if self.factor == 1.0 { self.source.clone() } else { self.source.scaled(self.factor) };
        format!("--column '{}={}'", self.target, read.limited(ends))
    }
}

impl FromStr for ColumnMap {
    type Err = Error;

    /// Parses `q_rad_s=gy`, `q_rad_s=-gy*pi/180`, `u_norm=0.25*(m1+m2-m3-m4)`, and, where nothing was commanded, `u_norm=0`.
    fn from_str(text: &str) -> Result<Self, Error> {
        let refuse = |what: String| {
            Error::new(
                ErrorKind::Options,
                format!("--column {}: {what}", quote(text)),
                "write --column q_rad_s=gyro_y, --column 'q_rad_s=-gyro_y*pi/180' where unit or sign differs, or \
                 --column 'u_norm=0.25*(m1+m2-m3-m4)'",
            )
        };
        let (target, rest) = text.split_once('=').ok_or_else(|| refuse("no = in it".into()))?;
        let target = target.trim();
        if Role::of(target).is_none() && !is_of_another_axis(target) {
            return Err(refuse(format!("{} is not a column of the format", quote(target)))
                .expecting(format!("one of {}", nearest(KNOWN_COLUMNS, target))));
        }
        let read = rest.parse::<Expression>();
        let read = read.map_err(|error| Error {
            found: format!("--column {target}={}: {}", rest.trim(), error.found).into(),
            ..error
        })?;
        let role = Role::of(target).map(|(role, _)| role);
        if read.names().is_empty() && matches!(role, Some(Role::Input(_))) {
            let value = read.value(&[]);
            if !value.is_finite() || value.abs() > 1e12 {
                return Err(refuse(format!("the value {value} is no number or out of range")));
            }
            return Ok(Self { target: target.into(), source: read, factor: 1.0 });
        }
        let (factor, source) = read.without_factor();
        if source.names().is_empty() {
            return Err(refuse("no column of the file is named".into()));
        }
        if !(1e-12..=1e12).contains(&factor.abs()) {
            return Err(refuse(format!("the factor {factor} is zero or out of range")));
        }
        if matches!(role, Some(Role::Section | Role::Supervised))
            && (source.as_column().is_none() || factor != 1.0)
        {
            return Err(refuse(format!("{target} is a label: name one column, without arithmetic")));
        }
        Ok(Self { target: target.into(), source, factor })
    }
}

/// One `--section NAME=FROM..TO`: the samples with FROM ≤ t < TO, in seconds of the file's own clock.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionSpec {
    /// The section's label.
    pub label: String,
    /// First time, s; −∞ where it was left out.
    pub from: f64,
    /// Time before which it ends, s; ∞ where it was left out.
    pub to: f64,
}

impl FromStr for SectionSpec {
    type Err = Error;

    /// Parses `IV=31.5..62`; either end may be left out.
    fn from_str(text: &str) -> Result<Self, Error> {
        let refuse = |what: String| {
            let advice = "write --section NAME=FROM..TO in seconds, e.g. --section IV=31.5..62";
            Error::new(ErrorKind::Options, format!("--section {}: {what}", quote(text)), advice)
        };
        let bound = |part: &str, open: f64| match part.trim() {
            "" => Ok(open),
            number => match number.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ => Err(refuse(format!("{} is no time", quote(number)))),
            },
        };
        let (label, span) = text.split_once('=').ok_or_else(|| refuse("no = in it".into()))?;
        let (from, to) = span.split_once("..").ok_or_else(|| refuse("no .. in it".into()))?;
        let (from, to) = (bound(from, f64::NEG_INFINITY)?, bound(to, f64::INFINITY)?);
        let label = label.trim();
        if label.is_empty() || label == "-" {
            return Err(refuse("the section has no name".into()));
        }
        if from >= to {
            return Err(refuse("it ends before it begins".into()));
        }
        Ok(Self { label: label.into(), from, to })
    }
}

/// How a recording is to be read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// How the input behaves between samples.
    pub input_hold: InputHold,
    /// Columns of other names; a map goes before a column that is there already.
    pub columns: Vec<ColumnMap>,
    /// Times, s, at which a new section begins (`S1`, `S2`, ...); overrides the `section` column.
    pub splits: Vec<f64>,
    /// Sections by time; overrides the `section` column, excludes `splits`.
    pub sections: Vec<SectionSpec>,
    /// Whether what lies on the ground or near it is used too, as it is where one of `sections` has nothing else.
    pub on_ground: bool,
    /// The least number of samples that a contiguous stretch of the recording must have; at least 3.
    pub min_samples: usize,
}

impl Default for ReadOptions {
    /// A held input, the file's own columns and sections, and at least 20 samples.
    fn default() -> Self {
        Self {
            input_hold: InputHold::Held,
            columns: Vec::new(),
            splits: Vec::new(),
            sections: Vec::new(),
            on_ground: false,
            min_samples: 20,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_with_and_without_factor() {
        let map: ColumnMap = "q_rad_s=gy*0.5".parse().unwrap();
        assert_eq!((map.target.as_str(), map.source.as_column(), map.factor), ("q_rad_s", Some("gy"), 0.5));
        assert_eq!("u_V = volts".parse::<ColumnMap>().unwrap().factor, 1.0);
        let nothing: ColumnMap = "u_norm=0".parse().unwrap();
        assert_eq!((nothing.factor * nothing.source.value(&[]), nothing.source.names().len()), (0.0, 0));
        let map: ColumnMap = "u_norm=0.25*(m1-`m 2`)".parse().unwrap();
        assert_eq!((map.source.names(), map.factor), (&["m1".to_owned(), "m 2".to_owned()][..], 0.25));
        assert_eq!(map.option_to_scale(-1.0), "--column 'u_norm=(m1-`m 2`)*-0.25'");
        let again = map.option_to_scale(1.0);
        let again = again.strip_prefix("--column '").and_then(|rest| rest.strip_suffix('\'')).unwrap();
        assert_eq!(again.parse::<ColumnMap>().unwrap(), map);
    }

    #[test]
    fn bad_maps_are_refused_with_the_way_to_write_them() {
        for (text, says) in [
            ("", "no = in it"),
            ("q_rad_s", "no = in it"),
            ("q_rad_s=", "at character 1: it ends too early"),
            ("q_rad_s=gy*", "at character 4: it ends too early"),
            ("q_rad_s=gy `gz`", "at character 4: found \"`\""),
            ("q_rad_s=gy*0", "out of range"),
            ("q_rad_s=gy/0", "out of range"),
            ("q_rad_s=3*pi", "no column of the file is named"),
            ("u_norm=0/0", "no number"),
            ("u_norm=1e300", "out of range"),
            ("section=a+b", "name one column"),
            ("speed=gy", "one of "),
            ("q_rads=gy", "one of q_rad_s,"),
        ] {
            let error = text.parse::<ColumnMap>().unwrap_err();
            assert_eq!(error.kind, ErrorKind::Options);
            assert!(error.to_string().contains(says) && error.to_string().contains("--column"), "{error}");
        }
    }

    #[test]
    fn sections_by_time() {
        let spec: SectionSpec = "IV=31.5..62".parse().unwrap();
        assert_eq!((spec.label.as_str(), spec.from, spec.to), ("IV", 31.5, 62.0));
        assert_eq!("I=..3".parse::<SectionSpec>().unwrap().from, f64::NEG_INFINITY);
        for text in ["IV", "IV=3", "IV=5..3", "=1..2", "IV=a..3", "-=1..2", "IV=NaN..2"] {
            assert!(text.parse::<SectionSpec>().unwrap_err().advice.contains("--section"), "{text}");
        }
    }
}
