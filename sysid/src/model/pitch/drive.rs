//! What drives the motion: the delayed command, what the blades make of it, and the moments that neither command nor motion make.
//!
//! The motion has no part in it, so that models which differ in the airframe or in the noise alone share it.

use super::placed::later;
use super::{OWN_STATES, PitchModel, at_row};
use crate::dataset::Run;
use crate::model::effect::Conditions;
use crate::model::shift::Shift;

/// What drives the motion over one substep.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drive {
    /// The delayed command u_c, its unit.
    pub command: f64,
    /// What the blades do, u_a, the same unit.
    pub blades: f64,
    /// Moment that the motion has no part in, N m.
    pub forced: f64,
    /// By how much the blades' angle changes; zero where no term asks.
    pub change: f64,
    /// The share of the substep that is left when it jumps; `None` where it moves all the while.
    pub left: Option<f64>,
}

impl PitchModel<'_> {
    /// All that [`drives`](Self::drives) depend on beside the run and the terms' kinds.
    pub fn driven_by(&self) -> Vec<f64> {
        let mut all = vec![self.step, self.plant.delay, self.plant.inertia];
        all.extend(self.driving.iter().flat_map(|term| term.values));
        all
    }

    /// What drives the motion over the first `rows` of `run`, substep by substep.
    pub fn drives(&self, run: &Run, rows: usize) -> Vec<Drive> {
        let mut own = [0.0; OWN_STATES];
        let mut at = self.conditions;
        let mut drives = vec![Drive::default(); rows * self.substeps];
        for (k, drives) in drives.chunks_exact_mut(self.substeps).enumerate() {
            self.drive(&mut own, run, k, &mut at, drives);
        }
        drives
    }

    /// The same over one sample, where the terms' own states are `own`; `at` are the conditions of any row.
    pub(super) fn drive(
        &self,
        own: &mut [f64; OWN_STATES],
        run: &Run,
        k: usize,
        at: &mut Conditions,
        drives: &mut [Drive],
    ) {
        set_beside(at, run, k);
        for (i, drive) in drives.iter_mut().enumerate() {
            at.t = run.elapsed(k) + i as f64 * at.dt;
            let shift = self.shift(i, run, at);
            at.command = shift.mean(run, k);
            *drive = Drive { command: at.command, blades: at.command, ..Drive::default() };
            let ends = self.is_impulsive.then(|| shift.at_ends(run, k));
            if let Some(ends) = ends {
                drive.left = self.left_after_jump(run, at.command, ends);
                drive.change = -self.angle(ends[0], own, at);
            }
            if let Some(thrust) = &run.beside.thrust {
                at.thrust = shift.over(thrust, k);
                for term in self.driving.iter().filter(|term| !term.collective.is_empty()) {
                    let carried = &mut own[term.collective.clone()];
                    at.thrust = term.effect.actuate(term.values, carried, at.thrust, at);
                }
            }
            for term in &self.driving {
                drive.blades = term.effect.actuate(term.values, &mut own[term.own.clone()], drive.blades, at);
                drive.forced += term.effect.forcing(term.values, at);
            }
            if let Some(ends) = ends {
                drive.change += self.angle(ends[1], own, at);
            }
        }
    }

    /// What the blades' angle is under the command `u` at the moment at which the terms' own states are `own`.
    fn angle(&self, u: f64, own: &[f64; OWN_STATES], at: &Conditions) -> f64 {
        let on_angle = self.driving.iter().filter(|term| !term.effect.of_thrust());
        on_angle.fold(u, |u, term| term.effect.blades(term.values, &own[term.own.clone()], u, at))
    }

    /// The share of a substep that is left when its command `mean` jumps from one of its `ends` to the other, and the blades with it.
    fn left_after_jump(&self, run: &Run, mean: f64, [from, to]: [f64; 2]) -> Option<f64> {
        let follow = self.driving.iter().any(|term| !term.effect.of_thrust() && !term.own.is_empty());
        (run.held && !follow && from != to).then(|| (mean - from) / (to - from))
    }

    /// Where the input of substep `i` stands under the conditions `at`.
    fn shift(&self, i: usize, run: &Run, at: &Conditions) -> Shift {
        if self.delay_moves {
            let delay = self.plant.delay + later(&self.terms, at);
            if delay != self.delay {
                return Shift::new(delay, i, self.substeps, self.step, run.held);
            }
        }
        self.shifts[i][usize::from(run.held)]
    }
}

/// Conditions that were logged beside the pitch axis in row `k`.
pub(super) fn set_beside(at: &mut Conditions, run: &Run, k: usize) {
    if let Some(rows) = &run.beside.roll_and_yaw {
        (at.roll_rate, at.yaw_rate) = (rows[k].p, rows[k].r);
    }
    at.roll_command = at_row(&run.beside.roll_command, k);
    at.voltage = at_row(&run.beside.voltage, k);
}
