//! What every method takes: the runs of one or more recordings, each on a uniform grid without a gap.

mod amplitudes;
mod command_news;
mod input;
mod motion;
mod smoothed;
mod thinning;

pub use amplitudes::{Amplitudes, decorrelation};

use crate::error::{Error, ErrorKind};
use crate::moving_mean::MovingMean;
use crate::recording::{InputHold, InputUnit, Recording, Section, WHOLE};
use core::ops::Range;
pub(crate) use input::{has_two_levels, median_size};
use std::borrow::Cow;

/// One stretch of uniformly sampled signals without a gap.
#[derive(Clone, Debug)]
pub struct Run {
    /// Index of the recording it comes from.
    pub recording: usize,
    /// Time stamp of the recording's first sample, s.
    pub origin: f64,
    /// Time stamp of the first sample, s.
    pub start: f64,
    /// Sample period, s.
    pub step: f64,
    /// Whether the input is held over each step (otherwise it is interpolated linearly).
    pub held: bool,
    /// Input, in its unit.
    pub u: Vec<f64>,
    /// What it does between the rows, where several samples were averaged into one.
    pub between: Option<MovingMean>,
    /// Whether that is a cause of what the rows show, and no answer to it: it keeps a value for longer than a row, or the craft
    /// answers a row later.
    pub leads: bool,
    /// What is new in the command, of the standard deviation of the first sensor's noise, where a controller makes it and that was asked.
    pub command_news: Option<Vec<f64>>,
    /// Measured outputs: pitch rate in rad/s and pitch angle in rad, each if the data set has it.
    pub rate: Option<Vec<f64>>,
    /// See `rate`.
    pub angle: Option<Vec<f64>>,
    /// Reading at which the rate clips, rad/s: the largest, where it recurs; infinite where it does not.
    pub rate_limit: f64,
    /// What was logged beside the pitch axis.
    pub beside: Beside,
    /// Where the supervisor overrode the excitation.
    pub supervised: Vec<bool>,
    /// Rows in which neither rate nor angle was measured; empty where there are none.
    pub unmeasured: Vec<bool>,
    /// Sections, and the rows of this run that they cover.
    pub sections: Vec<(String, Range<usize>)>,
}

impl Run {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.u.len()
    }
    /// Whether the run has no samples.
    pub fn is_empty(&self) -> bool {
        self.u.is_empty()
    }
    /// Whether something was measured in row `k`.
    pub fn is_measured(&self, k: usize) -> bool {
        self.unmeasured.get(k) != Some(&true)
    }
    /// Rows in which something was measured once, in the mean.
    pub fn measured_every(&self) -> usize {
        let unmeasured = self.unmeasured.iter().filter(|unmeasured| **unmeasured).count();
        (self.len() as f64 / (self.len() - unmeasured).max(1) as f64).round() as usize
    }
    /// Time stamp of row `k`, s, by the clock of the file.
    pub fn time(&self, k: usize) -> f64 {
        self.start + k as f64 * self.step
    }
    /// Time of row `k` since the start of the recording, s.
    pub fn elapsed(&self, k: usize) -> f64 {
        self.time(k) - self.origin
    }
}

/// Roll and yaw in one row, and what they make of the angle: θ̇ = q cos φ − r sin φ. Where the roll angle φ was not measured, it
/// is taken to be zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollAndYaw {
    /// Roll rate p, rad/s.
    pub p: f64,
    /// Yaw rate r, rad/s.
    pub r: f64,
    /// cos φ − 1.
    pub shortening: f64,
    /// −r sin φ, rad/s.
    pub carried: f64,
}

/// What was logged beside the pitch axis, row by row, each where it was.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beside {
    /// Roll and yaw, where both rates were measured.
    pub roll_and_yaw: Option<Vec<RollAndYaw>>,
    /// Roll rate, rad/s.
    pub roll_rate: Option<Vec<f64>>,
    /// Command of the roll axis, in its unit.
    pub roll_command: Option<Vec<f64>>,
    /// Collective thrust T relative to its mean over the data set: (T − T̄)/T̄.
    pub thrust: Option<Vec<f64>>,
    /// Supply voltage V relative to its mean over the data set: (V − V̄)/V̄.
    pub voltage: Option<Vec<f64>>,
}

/// The runs of one vehicle's recordings.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// All runs, recording by recording.
    pub runs: Vec<Run>,
    /// Unit of the input.
    pub input_unit: InputUnit,
    /// Whether the pitch rate was measured.
    pub has_rate: bool,
    /// Whether the pitch angle was measured.
    pub has_angle: bool,
    /// Number of logged samples that were averaged into one.
    pub thinned: usize,
    /// The outputs that were smoothed both ways in time; `None` where none was.
    pub smoothing: Option<Smoothing>,
    /// Whether the logged input has two values and no third: every curve of it is then a gain and a constant.
    pub two_levels: bool,
    /// Whether a recording has its largest rate in several rows: what clips, reads exactly that.
    pub rate_clips: bool,
}

/// Outputs that were smoothed both ways in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Smoothing {
    /// What is left out for it, in words.
    pub left_out: Option<&'static str>,
    /// Whether what is used is smoothed as well.
    pub in_use: bool,
}

/// A section: where it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Label; with several recordings "2:IV" is section IV of the second.
    pub label: String,
    /// Index of the run.
    pub run: usize,
    /// Rows of that run.
    pub rows: Range<usize>,
}

/// The rows `wanted`, counted over runs of `lengths` one after the other: the index of each run that has some, and its rows.
pub fn pieces(
    lengths: impl IntoIterator<Item = usize>,
    wanted: Range<usize>,
) -> impl Iterator<Item = (usize, Range<usize>)> {
    let mut before = 0;
    let within = move |(run, length): (usize, usize)| {
        let at = |row: usize| row.clamp(before, before + length) - before;
        let rows = at(wanted.start)..at(wanted.end);
        before += length;
        (run, rows)
    };
    lengths.into_iter().enumerate().map(within).filter(|(_, rows)| !rows.is_empty())
}

impl Dataset {
    /// Puts the recordings of one vehicle together. All must have the same input unit; a channel is used when all
    /// recordings have it.
    pub fn new(recordings: &[Recording]) -> Result<Self, Error> {
        let mut data = Self::as_it_is(recordings)?;
        data.thin();
        Ok(data)
    }

    /// The readings as a board has them that runs every `step` s, or as slowly as the motion allows: sampled, not averaged.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn on_board(recordings: &[Recording], step: Option<f64>) -> Result<Self, Error> {
        let mut data = Self::as_it_is(recordings)?;
        let own = data.runs.first().map(|run| run.step);
        let wanted = step.zip(own).map(|(step, own)| (step / own).round() as usize);
        let factor = wanted.unwrap_or_else(|| data.rows_to_one());
        data.sample(factor);
        Ok(data)
    }

    fn as_it_is(recordings: &[Recording]) -> Result<Self, Error> {
        let Some(first) = recordings.first() else {
            return Err(Error::new(
                ErrorKind::Options,
                "no recording was given",
                "name one or more CSV files",
            ));
        };
        let has_rate = recordings.iter().all(|r| r.q.is_some());
        let has_angle = recordings.iter().all(|r| r.theta.is_some());
        if !has_rate && !has_angle {
            return Err(Error::new(
                ErrorKind::Column,
                "some of the recordings have only q_rad_s, others only theta_rad",
                "use them apart, or add the column that is missing",
            ));
        }
        if let Some(other) = recordings.iter().find(|r| r.u_unit != first.u_unit) {
            return Err(Error::new(
                ErrorKind::Column,
                format!(
                    "{} has {}, {} has {}",
                    first.name,
                    first.u_unit.column(),
                    other.name,
                    other.u_unit.column()
                ),
                "convert one of them by a factor, e.g. --column 'u_rad=u_pct*0.0012'",
            )
            .expecting("one input unit for all recordings of a vehicle"));
        }
        let thrust = mean(recordings.iter().map(|r| r.thrust.as_deref()));
        let voltage = mean(recordings.iter().map(|r| r.battery.as_deref()));
        let mut runs = Vec::new();
        for (index, recording) in recordings.iter().enumerate() {
            for segment in &recording.segments {
                let cut = |signal: &[f64]| signal[segment.clone()].to_vec();
                runs.push(Run {
                    recording: index,
                    origin: recording.t[0],
                    start: recording.t[segment.start],
                    step: recording.step,
                    held: recording.input_hold == InputHold::Held,
                    u: cut(&recording.u),
                    between: None,
                    command_news: None,
                    leads: false,
                    rate: recording.q.as_deref().filter(|_| has_rate).map(cut),
                    angle: recording.theta.as_deref().filter(|_| has_angle).map(cut),
                    rate_limit: recording.q.as_deref().map_or(f64::INFINITY, rate_limit),
                    beside: Beside {
                        roll_and_yaw: roll_and_yaw(recording, segment),
                        roll_rate: recording.p.as_deref().map(cut),
                        roll_command: recording.u_roll.as_deref().map(cut),
                        thrust: relative(recording.thrust.as_deref().map(cut), thrust),
                        voltage: relative(recording.battery.as_deref().map(cut), voltage),
                    },
                    supervised: recording.supervised[segment.clone()].to_vec(),
                    unmeasured: recording.unmeasured.get(segment.clone()).unwrap_or_default().to_vec(),
                    sections: sections_within(recording, segment, (recordings.len() > 1).then_some(index)),
                });
            }
        }
        let two_levels = has_two_levels(runs.iter().flat_map(|run| &run.u));
        let rate_clips = runs.iter().any(|run| run.rate_limit.is_finite());
        Ok(Self {
            runs,
            input_unit: first.u_unit,
            has_rate,
            has_angle,
            thinned: 1,
            smoothing: None,
            two_levels,
            rate_clips,
        })
    }

    /// What was noticed about the recordings, and what was done to them here.
    pub fn notes(&self, recordings: &[Recording]) -> Vec<String> {
        let mut notes: Vec<String> =
            recordings.iter().flat_map(|r| r.notes.iter().map(|note| note.text.clone())).collect();
        if let Some(left_out) = self.smoothing.and_then(|smoothing| smoothing.left_out) {
            notes.push(format!(
                "{left_out} is not used: it was smoothed both ways in time after it was measured"
            ));
        }
        if self.thinned > 1 {
            let rate = 1.0 / self.runs.first().map_or(1.0, |run| run.step);
            let why = match self.is_smoothed() {
                true => format!(
                    "the motion was smoothed both ways in time, and {rate:.0} Hz hold what is left of it"
                ),
                false => format!("the motion is slow against the sampling, and {rate:.0} Hz show it"),
            };
            notes.push(format!("{} samples were averaged into one: {why}", self.thinned));
        }
        if self.two_levels {
            let note = "the input has two values: a limit, a dead band, play or a curve of its effect cannot be told from its gain; a third value would show them";
            notes.push(note.into());
        }
        notes
    }

    /// Whether the outputs know of later inputs, and hold nothing as quick as their rows.
    pub fn is_smoothed(&self) -> bool {
        self.smoothing.is_some_and(|smoothing| smoothing.in_use)
    }

    /// Where the clock of the first recording stands at its start, s: moments in time are counted from there in the model.
    pub fn origin(&self) -> f64 {
        self.runs.first().map_or(0.0, |run| run.origin)
    }

    /// Whether every run has `column` beside the pitch axis, and it varies in one of them at least.
    pub fn varies(&self, column: impl Fn(&Beside) -> Option<&[f64]>) -> bool {
        let moves = |values: &[f64]| values.iter().any(|value| Some(value) != values.first());
        let columns = || self.runs.iter().map(|run| column(&run.beside));
        columns().all(|values| values.is_some()) && columns().flatten().any(moves)
    }

    /// Number of samples of all runs.
    pub fn samples(&self) -> usize {
        self.runs.iter().map(Run::len).sum()
    }

    /// All sections, in the order of time; a section that a gap cuts is several places with the same label.
    pub fn places(&self) -> Vec<Place> {
        self.runs
            .iter()
            .enumerate()
            .flat_map(|(run, r)| {
                r.sections.iter().map(move |(label, rows)| Place {
                    label: label.clone(),
                    run,
                    rows: rows.clone(),
                })
            })
            .collect()
    }

    /// The measured signal that models are judged by in `place`: the pitch rate, or the angle where no rate was measured.
    pub fn judged(&self, place: &Place) -> &[f64] {
        let run = &self.runs[place.run];
        let signal = run.rate.as_ref().or(run.angle.as_ref());
        signal.map_or(&[], |y| &y[place.rows.clone()])
    }

    /// Those of `values`, row by row of `place`, where something was measured.
    pub fn where_measured<'v>(&self, place: &Place, values: &'v [f64]) -> Cow<'v, [f64]> {
        let run = &self.runs[place.run];
        if run.unmeasured.is_empty() {
            return Cow::Borrowed(values);
        }
        let rows = place.rows.clone().zip(values);
        Cow::Owned(rows.filter(|(k, _)| run.is_measured(*k)).map(|(_, value)| *value).collect())
    }

    /// Σ (y − ȳ)² of the signal that models are judged by, about its mean in each of `places`, where it was measured.
    pub fn motion(&self, places: &[Place]) -> f64 {
        let of = |place: &Place| {
            let y = self.where_measured(place, self.judged(place));
            let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
            y.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>()
        };
        places.iter().map(of).sum()
    }

    /// Mean of the angle over all samples, rad; `None` where a recording lacks it.
    pub fn mean_angle(&self) -> Option<f64> {
        let angles: Option<Vec<&[f64]>> = self.runs.iter().map(|run| run.angle.as_deref()).collect();
        Some(mean_of_all(&angles?))
    }

    /// Mean of the input over all samples.
    pub fn mean_input(&self) -> f64 {
        let inputs: Vec<&[f64]> = self.runs.iter().map(|run| run.u.as_slice()).collect();
        mean_of_all(&inputs)
    }
}

impl Run {
    /// Takes `level` off the input.
    pub fn lower_input(&mut self, level: f64) {
        self.u.iter_mut().for_each(|u| *u -= level);
        self.between = self.between.as_ref().map(|mean| mean.less(level));
    }

    /// The measured rate; where there is none, central differences of the angle.
    pub fn rate_or_slope(&self) -> Vec<f64> {
        let slope = || self.slope_of_angle().unwrap_or_else(|| vec![0.0; self.len()]);
        self.rate.clone().unwrap_or_else(slope)
    }

    /// Central differences of the measured angle.
    fn slope_of_angle(&self) -> Option<Vec<f64>> {
        let angle = self.angle.as_ref()?;
        let last = angle.len().checked_sub(1)?;
        let slope = |k: usize| {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
            (angle[b] - angle[a]) / ((b - a).max(1) as f64 * self.step)
        };
        Some((0..=last).map(slope).collect())
    }

    /// The measured angle; where there is none, the sum of the rate less its mean.
    pub fn angle_or_sum(&self) -> Vec<f64> {
        if let Some(angle) = &self.angle {
            return angle.clone();
        }
        let rate = self.rate_or_slope();
        let mean = rate.iter().sum::<f64>() / rate.len() as f64;
        rate.iter()
            .scan(0.0, |sum, q| {
                *sum += (q - mean) * self.step;
                Some(*sum)
            })
            .collect()
    }
}

/// The largest magnitude of a signal where several samples have exactly that, infinite where they do not.
fn rate_limit(signal: &[f64]) -> f64 {
    const RECURS: usize = 5;
    let largest = signal.iter().fold(0.0, |m: f64, q| m.max(q.abs()));
    let at_it = signal.iter().filter(|q| q.abs() == largest).count();
    if at_it >= RECURS { largest } else { f64::INFINITY }
}

fn mean_of_all(columns: &[&[f64]]) -> f64 {
    let count = columns.iter().map(|column| column.len()).sum::<usize>().max(1);
    columns.iter().map(|column| column.iter().sum::<f64>()).sum::<f64>() / count as f64
}

/// Mean over all samples of a column; `None` where a recording lacks it, or it is not positive in the mean.
fn mean<'a>(columns: impl Iterator<Item = Option<&'a [f64]>>) -> Option<f64> {
    let mean = mean_of_all(&columns.collect::<Option<Vec<_>>>()?);
    (mean.is_finite() && mean > 0.0).then_some(mean)
}

/// The values relative to their mean.
fn relative(values: Option<Vec<f64>>, mean: Option<f64>) -> Option<Vec<f64>> {
    let (mut values, mean) = (values?, mean?);
    for value in &mut values {
        *value = *value / mean - 1.0;
    }
    Some(values)
}

fn roll_and_yaw(recording: &Recording, segment: &Range<usize>) -> Option<Vec<RollAndYaw>> {
    let (p, r) = (recording.p.as_deref()?, recording.r.as_deref()?);
    let row = |k: usize| {
        let (sine, cosine) = recording.phi.as_ref().map_or(0.0, |phi| phi[k]).sin_cos();
        RollAndYaw { p: p[k], r: r[k], shortening: cosine - 1.0, carried: -r[k] * sine }
    };
    Some(segment.clone().map(row).collect())
}

/// The sections inside `segment`. One that a gap cuts keeps its name on both sides, and the stretches of a file that names none are
/// one.
fn sections_within(
    recording: &Recording,
    segment: &Range<usize>,
    index: Option<usize>,
) -> Vec<(String, Range<usize>)> {
    let mut whole = "";
    let mut sections = Vec::new();
    let mut before: Option<&Section> = None;
    for section in &recording.sections {
        let goes_on = before.is_some_and(|before| {
            before.file_label == section.file_label
                && (before.rows.end == section.rows.start || section.file_label == WHOLE)
        });
        if !goes_on {
            whole = &section.label;
        }
        before = Some(section);
        let begin = section.rows.start.max(segment.start);
        let end = section.rows.end.min(segment.end);
        if begin < end {
            let label = index.map_or_else(|| whole.to_owned(), |index| format!("{}:{whole}", index + 1));
            sections.push((label, begin - segment.start..end - segment.start));
        }
    }
    sections
}
