//! The port between the core and the world. Board, simulated aircraft and replay implement it.

use crate::cycle::{Cycle, CycleState};
use crate::supervisor::Phase;
use crate::telemetry::{Input, Telemetry};

/// A vehicle that can be tested.
pub trait Vehicle {
    /// The newest measurement, the clock, and what the operator wants in this tick.
    fn sense(&mut self, tick: u32) -> Input;

    /// Moves the servo: u in rad, held until the next call.
    fn actuate(&mut self, u_rad: f32);

    /// Takes the report of the cycle just done.
    fn emit(&mut self, telemetry: &Telemetry);
}

/// One cycle on the vehicle, to be called every 20 ms.
pub fn turn<const N: usize>(
    cycle: &Cycle<N>,
    state: &mut CycleState<N>,
    vehicle: &mut impl Vehicle,
    tick: u32,
) -> Phase {
    let input = vehicle.sense(tick);
    let telemetry = cycle.step(state, &input);
    vehicle.actuate(telemetry.u_rad);
    vehicle.emit(&telemetry);
    telemetry.phase
}

/// Flies one whole test and returns how it ended. Waits for the start as long as the vehicle does not send it.
pub fn fly<const N: usize>(cycle: &Cycle<N>, state: &mut CycleState<N>, vehicle: &mut impl Vehicle) -> Phase {
    let mut tick = 0_u32;
    loop {
        let phase = turn(cycle, state, vehicle, tick);
        if phase.ended() {
            return phase;
        }
        tick = tick.wrapping_add(1);
    }
}
