//! Recordings and models as arguments.

use crate::axes::{AxisChoice, Readable};
use crate::failure::Failure;
use crate::input;
use crate::logs::{TimeSpan, open};
use crate::vehicle::{Vehicle, Wanted};
use clap::Args;
use flight_logs::axes::Axis;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use sysid::catalogue::model_file::read_model;
use sysid::model::file::ModelFile;
use sysid::recording::{ColumnMap, InputHold, ReadOptions, Recording, SectionSpec, read};

/// Which recordings, and how they are to be read.
#[derive(Args, Clone)]
pub struct Reading {
    /// Recordings (CSV) or flight logs of one vehicle; several are one data set; - is standard input
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,

    /// The simulation in use today: plant and effects, with sections roll, pitch, yaw where axes differ. Without it, the grey-box
    /// pitch model with moments per unit inertia
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,

    /// A column of another name, or arithmetic over columns with + - * / ( ) and pi: q_rad_s=gyro_y,
    /// 'q_rad_s=-gyro_y*pi/180', 'u_norm=0.25*(m1+m2-m3-m4)', 'u_pct=limit(u,-100,100)' where an actuator limits it; names with
    /// other signs than letters, digits, blanks, _ . [ ] stand between `backticks` or "quotes". Of a flight log, topic.field, or
    /// input, rate, angle for what `pitchid show` proposes: 'u_norm=-input'. Where nothing was commanded: u_norm=0
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
    /// [default: held]
    #[arg(long, value_name = "HOLD", help_heading = "Reading")]
    input: Option<InputHold>,

    /// The axis of a flight log, or of a recording with columns of several [default: pitch]
    #[arg(long, value_name = "AXIS", help_heading = "Reading")]
    axis: Option<AxisChoice>,

    /// The part to use, in seconds of the file's own clock
    #[arg(long, value_name = "FROM..TO", help_heading = "Reading", allow_hyphen_values = true)]
    time: Option<TimeSpan>,

    /// Which flight of a log that holds several, counted from 1
    #[arg(long, value_name = "N", help_heading = "Flight logs")]
    flight: Option<usize>,

    #[command(flatten)]
    wanted: Wanted,

    #[arg(skip)]
    vehicle: Option<Vehicle>,
}

/// The recordings of one axis that a question is about, and the model of it.
pub struct Asked {
    /// The recordings.
    pub recordings: Arc<[Recording]>,
    /// What they are called.
    pub names: Vec<String>,
    /// Their axis.
    pub axis: Axis,
    /// The user's model, with its name.
    pub model: Option<(String, ModelFile)>,
}

/// The recordings of each axis that could be read, and why others could not.
#[derive(Default)]
pub struct ByAxis {
    /// Axis and its recordings.
    pub read: Vec<(Axis, Vec<Recording>)>,
    /// Why not.
    pub refused: Vec<Failure>,
}

impl Reading {
    /// The same with what the vehicle's file says of what the command line leaves open.
    pub fn resolved(&self) -> Result<Self, Failure> {
        let mut all = self.clone();
        let Some(vehicle) = self.wanted.find()? else { return Ok(all) };
        vehicle.say();
        all.columns.extend(vehicle.columns_beside(&self.columns));
        if self.sections.is_empty() && self.splits.is_empty() {
            all.sections.clone_from(&vehicle.sections);
        }
        all.axis = self.axis.or(vehicle.axis);
        all.input = self.input.or(vehicle.input);
        all.model = self.model.clone().or_else(|| vehicle.model.clone());
        all.vehicle = Some(vehicle);
        Ok(all)
    }

    /// Reads one axis of a source.
    fn read(
        &self,
        source: &Readable,
        axis: Option<Axis>,
        of_several: bool,
        options: &ReadOptions,
    ) -> Result<Recording, Failure> {
        let mut recording = source.recording(axis, of_several, options)?;
        if let Some(vehicle) = &self.vehicle {
            vehicle.complete(&mut recording);
        }
        Ok(recording)
    }

    /// Reads all recordings, and makes recordings of flight logs, of one axis.
    pub fn recordings(&self) -> Result<Vec<Recording>, Failure> {
        let axis = self.axis.map(AxisChoice::single).transpose()?;
        let options = self.options();
        self.sources()?.iter().map(|source| self.read(source, axis, false, &options)).collect()
    }

    /// The recordings of one axis, and what is said of them.
    pub fn asked(&self) -> Result<Asked, Failure> {
        // a mistake in the model is told before the recordings are read
        let model = self.model()?;
        let recordings = self.recordings()?.into();
        Ok(Asked { recordings, names: self.names(), axis: self.axis(), model })
    }

    /// The axis that is meant, where it is one.
    pub fn axis(&self) -> Axis {
        self.axis.and_then(AxisChoice::one).unwrap_or(Axis::Pitch)
    }

    /// Whether all axes are asked for.
    pub fn all_axes(&self) -> bool {
        self.axis == Some(AxisChoice::All)
    }

    /// The recordings of every axis that all sources have; of the others, why not.
    pub fn recordings_by_axis(&self) -> Result<ByAxis, Failure> {
        let (sources, options) = (self.sources()?, self.options());
        let axes: Vec<Vec<Axis>> = sources.iter().map(|source| source.axes(&options)).collect();
        let mut all = ByAxis::default();
        for axis in Axis::ALL.into_iter().filter(|axis| axes.iter().all(|own| own.contains(axis))) {
            let read = sources.iter().map(|source| self.read(source, Some(axis), true, &options));
            match read.collect::<Result<Vec<Recording>, Failure>>() {
                Ok(recordings) => all.read.push((axis, recordings)),
                Err(refusal) => all.refused.push(refusal),
            }
        }
        if all.read.is_empty() && all.refused.is_empty() {
            let what = format!("{}: no columns of several axes", self.names().join(", "));
            let help = "name them u_roll_norm (or another unit) and p_rad_s, u_pitch_norm and q_rad_s, u_yaw_norm and \
                        r_rad_s, or leave --axis out";
            return Err(Failure::new(what, help));
        }
        Ok(all)
    }

    /// Says which of the recordings are large, before they are read.
    pub fn say_what_is_large(&self) {
        input::say_what_is_large(self.recordings.iter().map(PathBuf::as_path));
    }

    fn sources(&self) -> Result<Vec<Readable>, Failure> {
        let of = |source| Readable::new(source, self.flight, self.time.as_ref());
        open(&self.recordings, &self.columns)?.into_iter().map(of).collect()
    }

    fn options(&self) -> ReadOptions {
        ReadOptions {
            splits: self.splits.clone(),
            sections: self.sections.clone(),
            ..options_with(self.input.unwrap_or_default(), &self.columns)
        }
    }

    /// Reads the user's model of the axis that is meant, with its name.
    pub fn model(&self) -> Result<Option<(String, ModelFile)>, Failure> {
        let axis = self.axis.and_then(AxisChoice::one);
        match &self.model {
            Some(path) => Ok(Some((path.display().to_string(), model_at(path, axis)?))),
            None => Ok(self.vehicle.as_ref().and_then(Vehicle::inertia_model)),
        }
    }

    /// Reads the user's model of an axis.
    pub fn model_of(&self, axis: Option<Axis>) -> Result<Option<ModelFile>, Failure> {
        self.model.as_deref().map(|path| model_at(path, axis)).transpose()
    }

    /// Whether a model was named.
    pub const fn has_model(&self) -> bool {
        self.model.is_some()
    }

    /// Names of the recordings.
    pub fn names(&self) -> Vec<String> {
        self.recordings.iter().map(|path| input::name_of(path)).collect()
    }

    /// All files that are read.
    pub fn inputs(&self) -> Vec<&Path> {
        let vehicle = self.vehicle.as_ref().map(|vehicle| &vehicle.path);
        self.recordings.iter().chain(&self.model).chain(vehicle).map(PathBuf::as_path).collect()
    }
}

/// Samples that are told before the work on them begins.
const MANY: usize = 100_000;

/// What is said of recordings that are long.
pub fn long(recordings: &[Recording]) -> Option<String> {
    let samples: usize = recordings.iter().map(|recording| recording.t.len()).sum();
    let minutes =
        recordings.iter().map(|recording| recording.t.len() as f64 * recording.step).sum::<f64>() / 60.0;
    let told =
        || format!("{samples} samples over {minutes:.0} min take a while; --time FROM..TO takes a part");
    (samples >= MANY).then(told)
}

/// Reads the model of an axis in a model file.
pub fn model_at(path: &Path, axis: Option<Axis>) -> Result<ModelFile, Failure> {
    Ok(read_model(path, axis.map(|axis| axis.to_string()).as_deref())?)
}

/// These columns as options of a command, each with a space before it.
pub fn as_options(columns: &[ColumnMap]) -> String {
    columns.iter().map(|map| format!(" {}", map.option_to_scale(1.0))).collect()
}

/// How recordings are read with these columns.
pub fn options_with(input_hold: InputHold, columns: &[ColumnMap]) -> ReadOptions {
    ReadOptions { input_hold, columns: columns.to_vec(), ..ReadOptions::default() }
}

/// Reads one recording that needs no options.
pub fn read_plain(path: &Path) -> Result<Recording, Failure> {
    Ok(read(path, &ReadOptions::default())?)
}
