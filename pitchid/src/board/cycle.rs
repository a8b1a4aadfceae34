//! What the board reports of each cycle: `DEBUG_FLOAT_ARRAY` with the name `cycle`, laid out as the image's
//! `link::telemetry` tells.

use messages::board::DEBUG_FLOAT_ARRAY_DATA;
use std::fmt;

/// Where the supervisor stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    Idle,
    Exciting,
    Recovering,
    Done,
    Aborted,
}

impl Phase {
    /// True while a test runs.
    pub const fn runs(self) -> bool {
        matches!(self, Self::Exciting | Self::Recovering)
    }
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Idle => "idle",
            Self::Exciting => "running",
            Self::Recovering => "recovering",
            Self::Done => "done",
            Self::Aborted => "aborted",
        })
    }
}

/// One cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleReport {
    /// The board's clock, µs.
    pub time_us: u64,
    /// Number of the cycle, exact up to 2²⁴.
    pub tick: u32,
    /// Label of the section, as in recordings.
    pub section: &'static str,
    pub phase: Phase,
    pub supervised: bool,
    /// q in rad/s and θ in rad, where there was a usable sample.
    pub sample: Option<[f32; 2]>,
    pub u_rad: f32,
    pub excitation_rad: f32,
    pub theta_ref_rad: f32,
    /// q − q̂, rad/s.
    pub error_rad_s: f32,
    /// What the estimator says of itself, in words.
    pub verdict: &'static str,
    /// Settling, gain drift, innovation ratio.
    pub figures: [f32; 3],
}

const SECTIONS: [&str; 5] = ["-", "I", "II", "III", "IV"];
const PHASES: [Phase; 5] = [Phase::Idle, Phase::Exciting, Phase::Recovering, Phase::Done, Phase::Aborted];
const VERDICTS: [&str; 3] = ["not excited", "converging", "converged"];

impl CycleReport {
    /// Reads one; none where the array is another's.
    pub fn read(array: &DEBUG_FLOAT_ARRAY_DATA) -> Option<Self> {
        if array.name.to_str() != Ok("cycle") {
            return None;
        }
        let [
            tick,
            section,
            phase,
            supervised,
            sampled,
            q,
            theta,
            u,
            excitation,
            reference,
            error,
            _,
            verdict,
            a,
            b,
            c,
        ] = *array.data.first_chunk()?;
        let numbers = [q, theta, u, excitation, reference, error, a, b, c];
        numbers.iter().all(|number| number.is_finite()).then_some(Self {
            time_us: array.time_usec,
            tick: tick as u32,
            section: *SECTIONS.get(section as usize)?,
            phase: *PHASES.get(phase as usize)?,
            supervised: supervised != 0.0,
            sample: (sampled != 0.0).then_some([q, theta]),
            u_rad: u,
            excitation_rad: excitation,
            theta_ref_rad: reference,
            error_rad_s: error,
            verdict: VERDICTS.get(verdict as usize)?,
            figures: [a, b, c],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimator_core::{Command, Config, Input, Sample};

    #[test]
    fn what_the_image_writes_is_what_is_read() {
        let cycle = Config::default().build::<60>().unwrap();
        let mut state = cycle.initial_state();
        let sample = Sample { time_us: 40_000, q_rad_s: 0.25, theta_rad: -0.25 };
        let input = Input {
            tick: 2,
            now_us: 40_000,
            sample: Some(sample),
            theta_ref_rad: 0.0,
            command: Command::Start,
        };
        let told = cycle.step(&mut state, &input);
        let read = CycleReport::read(&firmware::link::telemetry::cycle_array(&told)).unwrap();
        assert_eq!((read.time_us, read.tick, read.section), (40_000, 2, "-"));
        assert_eq!((read.phase, read.supervised), (Phase::Exciting, told.supervised));
        assert_eq!(read.sample, Some([0.25, -0.25]));
        assert_eq!(
            (read.u_rad, read.excitation_rad, read.theta_ref_rad),
            (told.u_rad, told.excitation_rad, 0.0)
        );
        assert_eq!(read.error_rad_s, told.prediction_error_rad_s);
        let figures = told.convergence;
        assert_eq!(read.figures, [figures.settling, figures.gain_drift, figures.innovation_ratio]);
        assert_eq!(read.verdict, "not excited");
    }

    #[test]
    fn other_arrays_and_other_layouts_are_left_alone() {
        let mut array = DEBUG_FLOAT_ARRAY_DATA { name: "taps".into(), ..DEBUG_FLOAT_ARRAY_DATA::default() };
        assert_eq!(CycleReport::read(&array), None);
        array.name = "cycle".into();
        assert!(CycleReport::read(&array).is_some());
        array.data[2] = 9.0;
        assert_eq!(CycleReport::read(&array), None);
        array.data[2] = 0.0;
        array.data[7] = f32::NAN;
        assert_eq!(CycleReport::read(&array), None);
    }
}
