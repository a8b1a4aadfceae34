//! The monitor's model as a file: what `pitchid identify --monitor-out` writes and `pitchid monitor` reads.

use super::Design;
use crate::error::{Error, ErrorKind};
use crate::files;
use estimator_core::monitor::{CAUSES, Cause, Column, MonitorModel, Rows, SIZES, Test, Transition};
use serde::{Deserialize, Serialize};
use std::path::Path;

const SCHEMA: &str = "pitchid.monitor/1";
const HELP: &str = "write it again with pitchid identify --monitor-out";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: String,
    /// Sample period, s.
    step_s: f64,
    #[serde(with = "PredictorSection")]
    predictor: MonitorModel,
    cause: Vec<CauseSection>,
}

/// Fields of [`MonitorModel`] but for its tests, which are kept with their names.
#[derive(Serialize, Deserialize)]
#[serde(remote = "MonitorModel", deny_unknown_fields)]
struct PredictorSection {
    transition: Transition,
    moment: Column,
    correction: [Column; 2],
    output: Rows,
    whitening: [f32; 3],
    rest: [f32; 2],
    specific: f32,
    gain: f32,
    delay_samples: f32,
    delay_fraction: f32,
    lag: [f32; 2],
    friction_rate: f32,
    trim: [f32; 2],
    bias: [f32; 2],
    #[serde(skip)]
    tests: [Test; CAUSES],
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CauseSection {
    name: String,
    dead_zone: f32,
    calibration: f32,
    onset: [f32; 2],
    sizes: [f32; SIZES],
}

impl Design {
    /// The model as TOML.
    ///
    /// # Errors
    /// None that a caller could cause.
    pub fn to_toml(&self) -> Result<String, Error> {
        let cause = Cause::ALL.iter().zip(self.model.tests).map(|(cause, test)| {
            let Test { dead_zone, calibration, onset, sizes } = test;
            CauseSection { name: cause.name().into(), dead_zone, calibration, onset, sizes }
        });
        let file =
            File { schema: SCHEMA.into(), step_s: self.step, predictor: self.model, cause: cause.collect() };
        toml::to_string(&file).map_err(|error| {
            Error::new(ErrorKind::Model, format!("the monitor's file could not be made: {error}"), HELP)
        })
    }
}

/// Reads a monitor's model: the model and its sample period, s.
///
/// # Errors
/// A file that cannot be read, that is no monitor, or that no board would run; with the line where there is one.
pub fn read_monitor(path: &Path) -> Result<(MonitorModel, f64), Error> {
    let text = files::read_text(path, HELP)?;
    parse_monitor(&text).map_err(|error| error.in_file(path.display().to_string()))
}

/// The same of the text of a file.
///
/// # Errors
/// As [`read_monitor`].
pub fn parse_monitor(text: &str) -> Result<(MonitorModel, f64), Error> {
    let refuse = |found: String| Error::new(ErrorKind::Model, found, HELP);
    let file: File = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        refuse(error.message().to_owned()).at_line(line)
    })?;
    if file.schema != SCHEMA || !(file.step_s > 0.0 && file.step_s < 1.0) {
        return Err(refuse(format!("{:?} with a step of {} s", file.schema, file.step_s))
            .expecting(format!("{SCHEMA:?} with a step between 0 and 1 s")));
    }
    let names: Vec<&str> = file.cause.iter().map(|cause| cause.name.as_str()).collect();
    if names != Cause::ALL.map(Cause::name) {
        return Err(
            refuse(format!("causes {}", names.join(", "))).expecting(Cause::ALL.map(Cause::name).join(", "))
        );
    }
    let mut model = file.predictor;
    for (test, of) in model.tests.iter_mut().zip(file.cause) {
        let CauseSection { name: _, dead_zone, calibration, onset, sizes } = of;
        *test = Test { dead_zone, calibration, onset, sizes };
    }
    model.check().map_err(|refusal| refuse(refusal.to_string()))?;
    Ok((model, file.step_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::design::{design, tests::recording};

    #[test]
    fn what_is_written_is_read_to_the_bit_and_a_broken_file_is_refused_with_its_line() {
        let design = design(&[recording(0.015)], None).unwrap();
        let text = design.to_toml().unwrap();
        assert_eq!(parse_monitor(&text).unwrap(), (design.model, design.step));
        for (from, to, told) in [
            ("pitchid.monitor/1", "pitchid.monitor/9", "expected"),
            ("gain = ", "gain = \"x\" #", "line "),
            ("name = \"lag\"", "name = \"leg\"", "leg"),
            ("dead_zone = ", "dead_zone = -", "dead_zone"),
        ] {
            let error = parse_monitor(&text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
        let mut wild = design.clone();
        wild.model.transition[0] = [1.5, 0.0, 0.0, 0.5];
        let error = parse_monitor(&wild.to_toml().unwrap()).unwrap_err().to_string();
        assert!(error.contains("not stable"), "{error}");
    }
}
