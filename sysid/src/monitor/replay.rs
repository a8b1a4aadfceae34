//! The board's monitor over a recording: the same code, the same numbers.

use super::design::reading;
use crate::dataset::Dataset;
use estimator_core::monitor::{Monitor, MonitorReport, Observation};

/// What the monitor said of one row.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Time stamp of the recording, s.
    pub t: f64,
    /// The report.
    pub report: MonitorReport,
}

/// Runs the monitor over every stretch of `data`, each from a fresh state.
#[must_use]
pub fn replay(monitor: &Monitor, data: &Dataset) -> Vec<Vec<Row>> {
    let one = |run: &crate::dataset::Run| {
        let mut state = monitor.initial_state();
        let rows = run.u.iter().enumerate().map(|(k, u)| {
            let observation =
                Observation { tick: k as u32, measured: Some(reading(run, k)), u_rad: *u as f32 };
            Row { t: run.time(k), report: monitor.step(&mut state, &observation) }
        });
        rows.collect()
    };
    data.runs.iter().map(one).collect()
}
