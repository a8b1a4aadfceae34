//! The header lines of a flight: what was set, and what its frames hold.

use super::encoding::{Encoding, Predictor};
use crate::{Error, Log, Place};

/// The longest header line that is taken as one; those with all field names have about 800 characters.
const LONGEST_LINE: usize = 1 << 14;

/// A field of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) signed: bool,
    pub(super) predictor: Predictor,
    pub(super) encoding: Encoding,
}

/// What is known before the first frame.
#[derive(Debug, Default)]
pub(super) struct Header {
    /// Fields of the frames `I`, and of `P`, which differ in predictor and encoding.
    pub(super) intra: Vec<Part>,
    pub(super) inter: Vec<Part>,
    pub(super) slow: Vec<Part>,
    pub(super) gps: Vec<Part>,
    pub(super) home: Vec<Part>,
    /// All other lines.
    pub(super) lines: Vec<(String, String)>,
}

impl Header {
    /// Reads the lines from `start`; gives the offset of the first frame.
    pub(super) fn read(bytes: &[u8], start: usize, end: usize) -> Result<(Self, usize), Error> {
        let mut header = Self::default();
        let mut at = start;
        while let Some(rest) = bytes.get(at..end).filter(|rest| rest.starts_with(b"H ")) {
            let reach = rest.len().min(LONGEST_LINE);
            let Some(length) = rest[..reach].iter().position(|&byte| byte == b'\n') else { break };
            let line = String::from_utf8_lossy(&rest[2..length]);
            if let Some((key, value)) = line.split_once(':') {
                header.lines.push((key.trim().to_owned(), value.trim().to_owned()));
            }
            at += length + 1;
        }
        header.define().map_err(|error| error.at(Place::Offset(start)))?;
        Ok((header, at))
    }

    fn define(&mut self) -> Result<(), Error> {
        let version = self.text("Data version").unwrap_or("none");
        if version != "2" {
            let advice = "log with Cleanflight 1.7, Betaflight or INAV, or later";
            return Err(Error::new(format!("data version {version}"), advice).expecting("data version 2"));
        }
        self.intra = self.parts("I", "I")?;
        self.inter = self.parts("P", "I")?;
        self.slow = self.parts("S", "S")?;
        self.gps = self.parts("G", "G")?;
        self.home = self.parts("H", "H")?;
        if self.intra.is_empty() || self.inter.is_empty() {
            return Err(Error::new("no fields of frames I and P", "log again: the header is incomplete"));
        }
        Ok(())
    }

    /// The fields of a kind of frame; names and signs may stand with another.
    fn parts(&self, frame: &str, named_in: &str) -> Result<Vec<Part>, Error> {
        let list = |frame: &str, what: &str| -> Vec<&str> {
            let text = self.text(&format!("Field {frame} {what}")).unwrap_or_default();
            text.split(',').map(str::trim).filter(|cell| !cell.is_empty()).collect()
        };
        let names = list(named_in, "name");
        let (signs, predictors, encodings) =
            (list(named_in, "signed"), list(frame, "predictor"), list(frame, "encoding"));
        if predictors.is_empty() && encodings.is_empty() {
            return Ok(Vec::new());
        }
        if names.len() != predictors.len() || names.len() != encodings.len() {
            let found = format!(
                "{} names, {} predictors, {} encodings of frame {frame}",
                names.len(),
                predictors.len(),
                encodings.len()
            );
            return Err(Error::new(found, "log again: the header is damaged").expecting("as many of each"));
        }
        let part = |index: usize, name: &str| {
            let code = |cells: &[&str]| cells.get(index).and_then(|cell| cell.parse::<u16>().ok());
            Some(Part {
                name: name.to_owned(),
                signed: signs.get(index).is_some_and(|&sign| sign == "1"),
                predictor: Predictor::of(code(&predictors)?)?,
                encoding: Encoding::of(code(&encodings)?)?,
            })
        };
        let parts: Option<Vec<Part>> =
            names.iter().enumerate().map(|(index, name)| part(index, name)).collect();
        parts.ok_or_else(|| {
            Error::new(
                format!("an unknown predictor or encoding of frame {frame}"),
                "read the log with a newer version of this program",
            )
        })
    }

    /// The value of a line.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.lines.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    /// The numbers of a line, `a,b,c`.
    pub(super) fn number(&self, key: &str, index: usize) -> Option<i64> {
        self.text(key)?.split(',').nth(index)?.trim().parse().ok()
    }

    /// Frames of every so many loop iterations: numerator and denominator of "P interval", and the distance of the
    /// frames I.
    pub(super) fn intervals(&self) -> (i64, i64, i64) {
        let intra = self.number("I interval", 0).unwrap_or(32).max(1);
        let (numerator, denominator) = match self.text("P interval").unwrap_or("1").split_once('/') {
            Some((a, b)) => (a.trim().parse().unwrap_or(1), b.trim().parse().unwrap_or(1)),
            None => (1, self.number("P interval", 0).unwrap_or(1)),
        };
        (intra, numerator.max(1), denominator.max(1))
    }

    /// What an angular rate of 1 in the log is in rad/s. Cleanflight and all after it log in units of `gyro_scale` °/s,
    /// Betaflight 4.4 and later of a tenth of it with `blackbox_high_resolution`; Baseflight's scale is in rad/µs.
    pub(super) fn gyro_scale(&self) -> f64 {
        let bits = self.text("gyro_scale").and_then(|text| {
            u32::from_str_radix(text.trim_start_matches("0x"), 16).ok().filter(|_| text.starts_with("0x"))
        });
        let scale = bits.map_or(1.0, |bits| f64::from(f32::from_bits(bits)));
        let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        if self.text("Firmware type") == Some("Baseflight") {
            return scale * 1e6;
        }
        scale.to_radians() / self.resolution()
    }

    /// What rates and set-points are multiplied by in the log.
    pub(super) fn resolution(&self) -> f64 {
        if self.number("blackbox_high_resolution", 0) == Some(1) { 10.0 } else { 1.0 }
    }

    /// Name, firmware, and all settings.
    pub(super) fn describe(&self, log: &mut Log) {
        log.vehicle = self.text("Craft name").filter(|name| !name.is_empty()).map(str::to_owned);
        log.firmware =
            self.text("Firmware revision").or_else(|| self.text("Firmware type")).map(str::to_owned);
        for (key, value) in self.lines.iter().filter(|(key, _)| !key.starts_with("Field ")) {
            let cells: Vec<Option<f64>> = value.split(',').map(number).collect();
            match cells[..] {
                [Some(number)] => log.parameters.push((key.clone(), number)),
                [_, _, ..] if cells.iter().all(Option::is_some) => {
                    let cells = cells.into_iter().flatten().enumerate();
                    log.parameters.extend(cells.map(|(i, number)| (format!("{key}[{i}]"), number)));
                }
                _ => log.info.push((key.clone(), value.clone())),
            }
        }
    }
}

fn number(text: &str) -> Option<f64> {
    match text.trim().strip_prefix("0x") {
        Some(hexadecimal) => {
            let bits = u32::from_str_radix(hexadecimal, 16).ok()?;
            Some(f64::from(f32::from_bits(bits))).filter(|value| value.is_finite())
        }
        None => text.trim().parse().ok().filter(|value: &f64| value.is_finite()),
    }
}
