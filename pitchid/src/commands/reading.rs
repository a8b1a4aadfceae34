//! Recordings and models as arguments.

use crate::failure::Failure;
use crate::logs::recording::recording;
use crate::logs::{AxisName, Source, TimeSpan, choose, open, refuse_options};
use clap::Args;
use std::path::{Path, PathBuf};
use sysid::catalogue::model_file::read_model;
use sysid::model::file::ModelFile;
use sysid::recording::{ColumnMap, InputHold, ReadOptions, Recording, SectionSpec, read};

/// Which recordings, and how they are to be read.
#[derive(Args)]
pub struct Reading {
    /// Recordings (CSV) or flight logs of one vehicle; several are one data set
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,

    /// The simulation in use today: plant and effects. Without it, the grey-box pitch model with Iyy known
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,

    /// A column of another name, or arithmetic over columns with + - * / ( ) and pi: q_rad_s=gyro_y,
    /// 'q_rad_s=-gyro_y*pi/180', 'u_norm=0.25*(m1+m2-m3-m4)'; names with other signs than letters, digits, _ . [ ] stand
    /// between `backticks` or "quotes". Of a flight log, topic.field, or input, rate, angle for what `pitchid show`
    /// proposes: 'u_norm=-input'
    #[arg(long = "column", value_name = "NAME=EXPR", help_heading = "Reading")]
    columns: Vec<ColumnMap>,

    /// A section by time, in seconds of the file's own clock: IV=31.5..62
    #[arg(
        long = "section",
        value_name = "NAME=FROM..TO",
        help_heading = "Reading",
        conflicts_with = "splits"
    )]
    sections: Vec<SectionSpec>,

    /// A time at which a new section begins, s
    #[arg(long = "split", value_name = "T", help_heading = "Reading", allow_negative_numbers = true)]
    splits: Vec<f64>,

    /// The input between samples: held (a command) or interpolated (it was measured)
    #[arg(long, value_name = "HOLD", default_value = "held", help_heading = "Reading")]
    input: InputHold,

    /// The axis of a flight log [default: pitch]
    #[arg(long, value_name = "AXIS", help_heading = "Flight logs")]
    axis: Option<AxisName>,

    /// Which flight of a log that holds several, counted from 1
    #[arg(long, value_name = "N", help_heading = "Flight logs")]
    flight: Option<usize>,

    /// The part of it to use, in seconds of the log's own clock
    #[arg(long, value_name = "FROM..TO", help_heading = "Flight logs", allow_hyphen_values = true)]
    time: Option<TimeSpan>,
}

impl Reading {
    /// Reads all recordings, and makes recordings of flight logs.
    pub fn recordings(&self) -> Result<Vec<Recording>, Failure> {
        let options = ReadOptions {
            splits: self.splits.clone(),
            sections: self.sections.clone(),
            ..options_with(self.input, &self.columns)
        };
        let sources = open(&self.recordings, &self.columns)?;
        sources.into_iter().map(|source| self.recording(source, &options)).collect()
    }

    fn recording(&self, source: Source, options: &ReadOptions) -> Result<Recording, Failure> {
        let flights = match source {
            Source::Log(flights) => flights,
            Source::Recording(path) => {
                refuse_options(
                    &path,
                    [
                        ("--axis", self.axis.is_some()),
                        ("--flight", self.flight.is_some()),
                        ("--time", self.time.is_some()),
                    ],
                )?;
                return Ok(read(&path, options)?);
            }
        };
        let mut flight = choose(flights, self.flight)?;
        flight.cut(self.time.as_ref())?;
        let axis = self.axis.unwrap_or(AxisName::Pitch);
        recording(&flight, axis.into(), options)
    }

    /// Reads the user's model, with its name.
    pub fn model(&self) -> Result<Option<(String, ModelFile)>, Failure> {
        let read = |path: &PathBuf| Ok((path.display().to_string(), model_at(path)?));
        self.model.as_ref().map(read).transpose()
    }

    /// Names of the recordings.
    pub fn names(&self) -> Vec<String> {
        self.recordings.iter().map(|path| path.display().to_string()).collect()
    }

    /// All files that are read.
    pub fn inputs(&self) -> Vec<&Path> {
        self.recordings.iter().chain(&self.model).map(PathBuf::as_path).collect()
    }
}

/// Reads a model file.
pub fn model_at(path: &Path) -> Result<ModelFile, Failure> {
    Ok(read_model(path)?)
}

/// How recordings are read with these columns.
pub fn options_with(input_hold: InputHold, columns: &[ColumnMap]) -> ReadOptions {
    ReadOptions { input_hold, columns: columns.to_vec(), ..ReadOptions::default() }
}

/// Reads one recording that needs no options.
pub fn read_plain(path: &Path) -> Result<Recording, Failure> {
    Ok(read(path, &ReadOptions::default())?)
}
