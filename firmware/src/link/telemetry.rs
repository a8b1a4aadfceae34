//! What a cycle reports, as MAVLink messages.
//!
//! `DEBUG_FLOAT_ARRAY` with the name `cycle`, one per cycle, carries the clock in `time_usec` and
//!
//! | place | quantity | | place | quantity |
//! | --- | --- | --- | --- | --- |
//! | 0 | tick | | 8 | excitation in u, rad |
//! | 1 | section: 0 between, 1 to 4 | | 9 | θref, rad |
//! | 2 | phase: 0 idle, 1 exciting, 2 recovering, 3 done, 4 aborted | | 10 | q − q̂, rad/s |
//! | 3 | 1 where the supervisor overrode the test | | 11 | recoveries |
//! | 4 | 1 with a usable sample | | 12 | verdict: 0 not excited, 1 converging, 2 converged |
//! | 5 | q, rad/s | | 13 | settling |
//! | 6 | θ, rad | | 14 | gain drift |
//! | 7 | u, rad | | 15 | innovation ratio |
//!
//! in full `f32`, so a recording made of them replays to the same bits (the tick is exact up to 2²⁴). The name `taps` carries
//! w in pieces of 58, the piece's number in `array_id`.
//!
//! While the monitor runs, one `NAMED_VALUE_FLOAT` a cycle, each of ten names five times a second: `ev_...` the evidence of a cause
//! over the threshold, `e_q` and `e_theta` the innovations in their identified deviations.

use estimator_core::monitor::{CAUSES, MonitorReport};
use estimator_core::{Phase, Section, Telemetry, Verdict};
use messages::board::{
    ATTITUDE_DATA, DEBUG_FLOAT_ARRAY_DATA, HIL_ACTUATOR_CONTROLS_DATA, HilActuatorControlsFlags, MavModeFlag,
    MavSeverity, NAMED_VALUE_FLOAT_DATA, STATUSTEXT_DATA,
};
use messages::types::CharArray;

use crate::servo::ServoConfig;

/// Floats in one `DEBUG_FLOAT_ARRAY`.
pub const PIECE: usize = 58;
/// The `cycle` array.
#[must_use]
pub fn cycle_array(telemetry: &Telemetry) -> DEBUG_FLOAT_ARRAY_DATA {
    let Telemetry { sample, convergence, .. } = *telemetry;
    let flag = |set: bool| if set { 1.0 } else { 0.0 };
    let values = [
        telemetry.tick as f32,
        section_code(telemetry.section),
        f32::from(phase_code(&telemetry.phase)),
        flag(telemetry.supervised),
        flag(sample.is_some()),
        sample.map_or(0.0, |s| s.q_rad_s),
        sample.map_or(0.0, |s| s.theta_rad),
        telemetry.u_rad,
        telemetry.excitation_rad,
        telemetry.theta_ref_rad,
        telemetry.prediction_error_rad_s,
        telemetry.recoveries as f32,
        match convergence.verdict {
            Verdict::NotExcited => 0.0,
            Verdict::Converging => 1.0,
            Verdict::Converged => 2.0,
        },
        convergence.settling,
        convergence.gain_drift,
        convergence.innovation_ratio,
    ];
    array("cycle", 0, telemetry.now_us, &values)
}

/// The taps in pieces.
pub fn taps_arrays(taps: &[f32], now_us: u64) -> impl Iterator<Item = DEBUG_FLOAT_ARRAY_DATA> {
    let pieces = taps.chunks(PIECE).zip(0..);
    pieces.map(move |(values, piece)| array("taps", piece, now_us, values))
}

/// An array of at most [`PIECE`] values, zeros behind them.
#[must_use]
pub fn array(name: &str, array_id: u16, time_usec: u64, values: &[f32]) -> DEBUG_FLOAT_ARRAY_DATA {
    let mut data = [0.0; PIECE];
    data.iter_mut().zip(values).for_each(|(place, &value)| *place = value);
    DEBUG_FLOAT_ARRAY_DATA { time_usec, array_id, name: name.into(), data }
}

/// Names of the monitor's values, in the order of its causes, then the innovations.
const MONITOR_NAMES: [&str; CAUSES + 2] = [
    "ev_effect",
    "ev_lag",
    "ev_trim",
    "ev_damping",
    "ev_frict",
    "ev_gy_bias",
    "ev_gy_scal",
    "ev_other",
    "e_q",
    "e_theta",
];

/// The one of the monitor's values whose turn it is.
#[must_use]
pub fn monitor_value(report: &MonitorReport, telemetry: &Telemetry) -> NAMED_VALUE_FLOAT_DATA {
    let turn = telemetry.tick as usize % MONITOR_NAMES.len();
    let mut values = report.evidence.iter().chain(&report.innovation);
    NAMED_VALUE_FLOAT_DATA {
        time_boot_ms: (telemetry.now_us / 1000) as u32,
        value: values.nth(turn).copied().unwrap_or_default(),
        name: MONITOR_NAMES.get(turn).copied().unwrap_or_default().into(),
    }
}

fn section_code(section: Section) -> f32 {
    match section {
        Section::Between => 0.0,
        Section::I => 1.0,
        Section::II => 2.0,
        Section::III => 3.0,
        Section::IV => 4.0,
    }
}

/// Number of the phase, also `custom_mode` of the heartbeat.
#[must_use]
pub const fn phase_code(phase: &Phase) -> u8 {
    match phase {
        Phase::Idle => 0,
        Phase::Exciting => 1,
        Phase::Recovering { .. } => 2,
        Phase::Done => 3,
        Phase::Aborted { .. } => 4,
    }
}

/// The command for a simulated vehicle: u in rad, then the pulses of the front and the rear rotor about their centre, −1 to 1.
#[must_use]
pub fn actuators(telemetry: &Telemetry, mode: MavModeFlag) -> HIL_ACTUATOR_CONTROLS_DATA {
    let servo = ServoConfig::default();
    let [front, rear] = servo.widths_us(telemetry.u_rad).map(|width| (width - servo.centre_us) / 500.0);
    let mut controls = [0.0; 16];
    controls[..3].copy_from_slice(&[telemetry.u_rad, front, rear]);
    let flags = HilActuatorControlsFlags::HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP;
    HIL_ACTUATOR_CONTROLS_DATA { time_usec: telemetry.now_us, flags, controls, mode }
}

/// Pitch and pitch rate; the other axes are not measured.
#[must_use]
pub fn attitude(telemetry: &Telemetry) -> ATTITUDE_DATA {
    ATTITUDE_DATA {
        time_boot_ms: (telemetry.now_us / 1000) as u32,
        pitch: telemetry.sample.map_or(0.0, |s| s.theta_rad),
        pitchspeed: telemetry.sample.map_or(0.0, |s| s.q_rad_s),
        ..ATTITUDE_DATA::default()
    }
}

/// A text in as many messages as it takes; `id` tells the ground which of them belong together.
pub fn texts(severity: MavSeverity, text: &str, id: u16) -> impl Iterator<Item = STATUSTEXT_DATA> {
    let split = text.len() > CHUNK;
    text.as_bytes().chunks(CHUNK).enumerate().map(move |(place, bytes)| {
        let mut chunk = [0; CHUNK];
        chunk.iter_mut().zip(bytes).for_each(|(place, &byte)| *place = byte);
        let id = if split { id.max(1) } else { 0 };
        STATUSTEXT_DATA { severity, text: CharArray::new(chunk), id, chunk_seq: place as u8 }
    })
}

const CHUNK: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_come_in_numbered_pieces() {
        let text =
            "aborted: pitch 0.41 rad > limit 0.40 rad after 200 recoveries, all that one test may have";
        let found: Vec<_> = texts(MavSeverity::MAV_SEVERITY_ERROR, text, 3).collect();
        assert_eq!(found.iter().map(|t| (t.id, t.chunk_seq)).collect::<Vec<_>>(), [(3, 0), (3, 1)]);
        let whole: String = found.iter().map(|t| t.text.to_str().unwrap()).collect();
        assert_eq!(whole, text);
        assert_eq!(texts(MavSeverity::MAV_SEVERITY_INFO, "started", 3).next().unwrap().id, 0);
    }

    #[test]
    fn the_pieces_hold_every_tap_once() {
        for (length, count) in [(1, 1), (58, 1), (59, 2), (60, 2), (256, 5)] {
            let taps: Vec<f32> = (0..length).map(|i| i as f32).collect();
            let pieces: Vec<_> = taps_arrays(&taps, 0).collect();
            assert_eq!(pieces.len(), count);
            let found: Vec<f32> = pieces.iter().flat_map(|piece| piece.data).take(length).collect();
            assert_eq!(found, taps);
        }
    }
}
