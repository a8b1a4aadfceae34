//! The on-board estimate as a file: written by `pitchid fly`, read by `pitchid identify`.

use crate::failure::Failure;
use serde::{Deserialize, Serialize};
use std::path::Path;
use sysid::identify::fir::Fir;
use sysid::identify::lms::OnBoard;

const SCHEMA: &str = "pitchid.taps/1";
const HELP: &str = "name a file that pitchid fly --taps has written";

/// What the on-board estimate came to, and how the estimator was set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TapsFile {
    /// Always `pitchid.taps/1`.
    pub schema: String,
    /// Of the taps: rad/s per rad.
    pub unit: String,
    /// Sample period.
    pub step_s: f32,
    /// Samples from an input to the response that the first tap describes.
    pub first_lag: u32,
    /// The estimator's own verdict, and the figures behind it.
    pub verdict: String,
    /// Time constants that have passed.
    pub settling: f32,
    /// Change of the gain.
    pub gain_drift: f32,
    /// Share of the power that was not predicted.
    pub innovation_ratio: f32,
    /// Step μ of the filter, where the board told it.
    pub lms_step: Option<f32>,
    /// Leakage γ, where the board told it.
    pub lms_leakage: Option<f32>,
    /// The taps.
    pub taps: Vec<f32>,
}

impl TapsFile {
    /// The schema and unit that are written.
    pub fn heads() -> [String; 2] {
        [SCHEMA.into(), "rad/s per rad".into()]
    }

    /// Reads and checks a file.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let name = path.display();
        let text = sysid::files::read_text(path, HELP)?;
        let file: Self = serde_json::from_str(&text)
            .map_err(|error| Failure::new(format!("{name}: no taps: {error}"), HELP))?;
        let sound = file.schema == SCHEMA
            && file.step_s > 0.0
            && (1..=256).contains(&file.taps.len())
            && (1..=16).contains(&file.first_lag)
            && file.taps.iter().all(|tap| tap.is_finite());
        if !sound {
            let found = format!(
                "{name}: {} with {} taps from lag {}, {} s apart; expected {SCHEMA} with 1 to 256 finite taps from lag 1 to 16",
                file.schema,
                file.taps.len(),
                file.first_lag,
                file.step_s
            );
            return Err(Failure::new(found, HELP));
        }
        Ok(file)
    }

    /// For the comparison with other methods.
    pub fn on_board(&self) -> OnBoard {
        let usual = estimator_core::lms::LmsConfig::default();
        let lms = estimator_core::lms::LmsConfig {
            step: self.lms_step.unwrap_or(usual.step),
            leakage: self.lms_leakage.unwrap_or(usual.leakage),
            input_delay: (self.first_lag - 1) as u8,
            taps: self.taps.len() as u16,
            ..usual
        };
        let fir = Fir {
            taps: self.taps.iter().map(|&tap| f64::from(tap)).collect(),
            first_lag: self.first_lag as usize,
            // a period of 0.02 s is written in single precision
            step: (f64::from(self.step_s) * 1e6).round() / 1e6,
        };
        OnBoard { fir, verdict: self.verdict.clone(), lms }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("taps.json");
        let [schema, unit] = TapsFile::heads();
        let file = TapsFile {
            schema,
            unit,
            step_s: 0.02,
            first_lag: 4,
            verdict: "converged".into(),
            settling: 9.0,
            gain_drift: 0.01,
            innovation_ratio: 0.1,
            lms_step: Some(0.1),
            lms_leakage: None,
            taps: vec![1.5, -0.25],
        };
        let write = |file: &TapsFile| std::fs::write(&path, serde_json::to_string(file).unwrap()).unwrap();
        write(&file);
        assert_eq!(TapsFile::read(&path).unwrap(), file);
        let flown = file.on_board();
        assert_eq!((flown.fir.step, flown.fir.taps[1], flown.lms.input_delay), (0.02, -0.25, 3));
        assert_eq!((flown.lms.step, flown.lms.taps), (0.1, 2));
        for broken in [TapsFile { taps: vec![], ..file.clone() }, TapsFile { first_lag: 0, ..file.clone() }] {
            write(&broken);
            assert!(TapsFile::read(&path).is_err());
        }
        std::fs::write(&path, "t_s,u_rad").unwrap();
        assert!(TapsFile::read(&path).is_err());
    }
}
