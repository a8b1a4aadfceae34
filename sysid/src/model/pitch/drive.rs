//! What drives the motion: the delayed command, what the blades make of it, and the moments that neither command nor motion make.
//!
//! The motion has no part in it, so that models which differ in the airframe or in the noise alone share it.
//!
//! Of rows that are means of several samples the mean comes last: what makes the blades of the command (a limit, a dead band, play)
//! sees the command as it was given, and the mean over the time of a row is that of the blades.

use super::placed::{Placed, later};
use super::{OWN_STATES, Output, PitchModel, Point, at_row};
use crate::dataset::Run;
use crate::model::effect::Conditions;
use crate::model::shift::Shift;
use crate::moving_mean::{MovingMean, Track};
use core::ops::Range;

/// Parts of a row in which the blades follow the command, at most.
const MOST_NODES: usize = 4;

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
        if let Some(input) = self.as_given(run) {
            return self.means_of_samples(run, input, rows);
        }
        let mut own = [0.0; OWN_STATES];
        let mut at = self.conditions;
        let mut drives = vec![Drive::default(); rows * self.substeps];
        for (k, drives) in drives.chunks_exact_mut(self.substeps).enumerate() {
            self.drive(&mut own, run, k, &mut at, drives);
        }
        drives
    }

    /// The input of a run whose rows are means, where it is known between them and something follows it.
    fn as_given<'r>(&self, run: &'r Run) -> Option<&'r MovingMean> {
        run.known_between().filter(|_| !self.driving.is_empty())
    }

    /// The same where the rows are means, and the input between them is known.
    fn means_of_samples(&self, run: &Run, input: &MovingMean, rows: usize) -> Vec<Drive> {
        if !self.delay_moves && !self.is_impulsive && run.beside.thrust.is_none() {
            return self.before_the_delay(run, input, rows);
        }
        let wide = self.substeps;
        let half = wide.div_ceil(2) as isize;
        let weights: Vec<f64> = (-half..=half).map(|apart| share_of_row(apart, wide)).collect();
        let as_given = self.behind_the_delay(run, input, -half..(rows * wide) as isize + half);
        let mean = |window: &[Drive], of: fn(&Drive) -> f64| {
            window.iter().zip(&weights).map(|(drive, weight)| weight * of(drive)).sum()
        };
        let windows = as_given.windows(weights.len());
        let means = windows.map(|window| Drive {
            command: mean(window, |drive| drive.command),
            blades: mean(window, |drive| drive.blades),
            forced: mean(window, |drive| drive.forced),
            change: mean(window, |drive| drive.change),
            left: None,
        });
        means.take(rows * wide).collect()
    }

    /// The drives of `substeps`, counted from the first row, by the command as it was given.
    fn behind_the_delay(&self, run: &Run, input: &MovingMean, substeps: Range<isize>) -> Vec<Drive> {
        let wide = self.substeps as isize;
        let mut own = [0.0; OWN_STATES];
        let mut at = self.conditions;
        let of = |substep: isize| {
            let (row, i) = (substep.div_euclid(wide), substep.rem_euclid(wide) as usize);
            let k = usize::try_from(row).unwrap_or(0).min(run.len() - 1);
            set_beside(&mut at, run, k);
            at.t = run.elapsed(0) + row as f64 * self.step + i as f64 * at.dt;
            let shift = self.shift(i, run, &at);
            let (ends, command) = input.input_between(shift.places(row));
            self.of_command(&mut own, run, k, &mut at, (&shift, command, ends))
        };
        substeps.map(of).collect()
    }

    /// The drives of `rows` where the delay stays as it is: the blades follow the command sample by sample, in which it keeps its
    /// value, are delayed then, and the mean over the time of a row is exact.
    fn before_the_delay(&self, run: &Run, input: &MovingMean, rows: usize) -> Vec<Drive> {
        let nodes = input.per_row().min(MOST_NODES);
        let mut own = [0.0; OWN_STATES];
        let mut at = Conditions { dt: self.step / nodes as f64, ..self.conditions };
        let blades = (0..run.len() * nodes).map(|node| {
            let [from, to] = [node, node + 1].map(|node| node as f64 / nodes as f64 - 0.5);
            at.command = input.input_between([place(from), place(to)]).1;
            let acts = from + self.delay / self.step;
            set_beside(&mut at, run, (acts.max(0.0) as usize).min(run.len() - 1));
            at.t = run.elapsed(0) + acts * self.step;
            let actuate =
                |u, term: &Placed<'_>| term.effect.actuate(term.values, &mut own[term.own.clone()], u, &at);
            self.driving.iter().fold(at.command, actuate)
        });
        let blades = Track::new(blades.collect(), true);
        let mut at = self.conditions;
        let of = |substep: usize| {
            let (k, i) = (substep / self.substeps, substep % self.substeps);
            let begins = substep as f64 / self.substeps as f64 - self.delay / self.step;
            let ends = begins + 1.0 / self.substeps as f64;
            let at_nodes = [begins, ends].map(|rows| (rows + 0.5) * nodes as f64);
            set_beside(&mut at, run, k);
            at.t = run.elapsed(k) + i as f64 * at.dt;
            let command = input.between([place(begins), place(ends)]).1;
            at.command = command;
            let forced = self.driving.iter().map(|term| term.effect.forcing(term.values, &at)).sum();
            Drive { command, blades: blades.mean_of_means(at_nodes, nodes), forced, ..Drive::default() }
        };
        (0..rows * self.substeps).map(of).collect()
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
            *drive = self.of_command(own, run, k, at, (&shift, shift.mean(run, k), shift.at_ends(run, k)));
        }
    }

    /// The same over one substep in row `k`, in which the command is `command` in the mean and goes between its `ends`.
    fn of_command(
        &self,
        own: &mut [f64; OWN_STATES],
        run: &Run,
        k: usize,
        at: &mut Conditions,
        (shift, command, ends): (&Shift, f64, [f64; 2]),
    ) -> Drive {
        at.command = command;
        let mut drive = Drive { command, blades: command, ..Drive::default() };
        if self.is_impulsive {
            drive.left = self.left_after_jump(run, command, ends);
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
        if self.is_impulsive {
            drive.change += self.angle(ends[1], own, at);
        }
        drive
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

/// A row, and the share of the time to the next, so many `rows` from the first.
fn place(rows: f64) -> (isize, f64) {
    (rows.floor() as isize, rows - rows.floor())
}

/// Share of a substep's mean over the time of a row, `wide` substeps, that comes from the one so many `apart`.
fn share_of_row(apart: isize, wide: usize) -> f64 {
    // where the window's end goes through that substep, it is in half of the time, or an eighth where the ends lie between two
    let reach = 0.5 * wide as f64;
    let inside =
        |at: f64| ((at + reach).min(apart as f64 + 1.0) - (at - reach).max(apart as f64)).clamp(0.0, 1.0);
    let kinks = [0.0, 0.25, 0.5, 0.75, 1.0].map(inside);
    let simpson = |a: f64, b: f64, c: f64| (a + 4.0 * b + c) / 12.0;
    (simpson(kinks[0], kinks[1], kinks[2]) + simpson(kinks[2], kinks[3], kinks[4])) / wide as f64
}

/// The model under the input of a run.
pub struct Driven<'m, 'a> {
    model: &'m PitchModel<'a>,
    run: &'m Run,
    /// What drives it, where that has to be known before and after a row.
    drives: Option<Vec<Drive>>,
}

impl<'a> PitchModel<'a> {
    /// The model under the input of `run`.
    pub fn driven<'m>(&'m self, run: &'m Run) -> Driven<'m, 'a> {
        let drives = self.as_given(run).map(|input| self.means_of_samples(run, input, run.len()));
        Driven { model: self, run, drives }
    }
}

impl Driven<'_, '_> {
    /// One sample further, from row `k` to row k+1. `false` when the state has diverged.
    pub fn advance(&self, point: &mut Point, k: usize) -> bool {
        let Some(drives) = &self.drives else { return self.model.advance(point, self.run, k) };
        let wide = self.model.substeps;
        let mut at = self.model.conditions;
        self.model.moved(point, self.run, k, &mut at, &drives[k * wide..][..wide])
    }

    /// Free run over `rows` from `point`, the state at the first of them.
    pub fn simulate(&self, rows: Range<usize>, mut point: Point) -> Option<Vec<Output>> {
        let mut outputs = Vec::with_capacity(rows.len());
        for k in rows {
            outputs.push(self.model.output(&point));
            if !self.advance(&mut point, k) {
                return None;
            }
        }
        Some(outputs)
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
