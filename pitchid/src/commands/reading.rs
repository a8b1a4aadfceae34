//! Recordings and models as arguments.

use crate::failure::Failure;
use clap::Args;
use std::path::{Path, PathBuf};
use sysid::catalogue::model_file::read_model;
use sysid::model::file::ModelFile;
use sysid::recording::{ColumnMap, InputHold, ReadOptions, Recording, SectionSpec, read};

/// Which recordings, and how they are to be read.
#[derive(Args)]
pub struct Reading {
    /// Recordings (CSV) of one vehicle; several are one data set
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,

    /// The simulation in use today: plant and effects. Without it, the grey-box pitch model with Iyy known
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,

    /// A column of another name, with a factor where the unit differs: q_rad_s=gyro_y, 'q_rad_s=gy*0.0174533'
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
}

impl Reading {
    /// Reads all recordings.
    pub fn recordings(&self) -> Result<Vec<Recording>, Failure> {
        let options = ReadOptions {
            input_hold: self.input,
            columns: self.columns.clone(),
            splits: self.splits.clone(),
            sections: self.sections.clone(),
            ..ReadOptions::default()
        };
        self.recordings.iter().map(|path| Ok(read(path, &options)?)).collect()
    }

    /// Reads the user's model, with its name.
    pub fn model(&self) -> Result<Option<(String, ModelFile)>, Failure> {
        let read = |path: &PathBuf| Ok((path.display().to_string(), read_model(path)?));
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

/// Reads one recording that needs no options.
pub fn read_plain(path: &Path) -> Result<Recording, Failure> {
    Ok(read(path, &ReadOptions::default())?)
}
