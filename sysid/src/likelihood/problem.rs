//! One estimation problem: the data, the baseline, and which samples count; its unknowns and its residuals.

use crate::catalogue::extra_delay::ExtraDelay;
use crate::catalogue::find;
use crate::catalogue::gust_disturbance::GustDisturbance;
use crate::catalogue::model_file::model_file;
use crate::catalogue::scaled_shape::carried;
use crate::dataset::{Amplitudes, Dataset, Place, Run};
use crate::likelihood::first_counted::first_counted;
use crate::likelihood::known_drives::KnownDrives;
use crate::model::baseline::Baseline;
use crate::model::effect::{Effect, Locus, Parameter, ResidualMoment, Scale};
use crate::model::file::ModelFile;
use crate::model::noise::Disturbance;
use crate::model::pitch::{Gains, Output, PitchModel, Point, Term};
use crate::model::plant::{Mount, Plant, THETA};
use crate::optim::levenberg_marquardt::Coordinate;

/// The data with what is counted of them.
pub struct Problem<'a> {
    /// The data.
    pub data: &'a Dataset,
    /// The baseline.
    pub baseline: &'a Baseline,
    /// Sizes of the signals.
    pub sizes: Amplitudes,
    /// Whether the angle keeps to one side of its zero: then what pulls back to zero is held by another moment.
    pub hangs_aside: bool,
    /// For every run, which rows count in the criterion.
    pub counted: Vec<Vec<bool>>,
    /// All data, where these are stretches of them.
    whole: Option<&'a Dataset>,
}

/// A full set of values in the forms that the model takes.
pub struct Unpacked {
    /// The plant.
    pub plant: Plant,
    /// The noise model.
    pub disturbance: Disturbance,
    /// The baseline's terms and then the effects under test.
    pub terms: Vec<Term>,
}

impl Unpacked {
    /// The model that this is, as a file. Terms without a name were fitted to the data of `problem`.
    pub fn to_model_file(&self, problem: &Problem<'_>) -> ModelFile {
        let physics = self.terms.iter().filter(|term| !term.effect.is_background());
        let mut terms: Vec<Term> = physics.map(|term| carried(term, &problem.sizes)).collect();
        let mut plant = self.plant;
        if plant.delay < 0.0 {
            // No loop answers before it is asked: the stamps do, and a file says so.
            match terms.iter_mut().find(|term| term.effect.about().id == ExtraDelay.about().id) {
                Some(known) => known.values[0] += plant.delay,
                None => terms.push(Term { effect: &ExtraDelay, values: vec![plant.delay] }),
            }
            plant.delay = 0.0;
        }
        model_file(&plant, &terms, problem.data.origin())
    }
}

/// Samples by which a measurement may be stamped before the input that moved it: a row and half a hold.
const STAMPED_EARLY: f64 = 1.5;
/// Longest loop delay, s.
pub const LONGEST_DELAY: f64 = 0.3;
/// Mean angle from which its zero matters, as a share of the angle's spread.
const ASIDE: f64 = 0.5;
/// Standard deviation of the prior on ln(mount frequency): the user's model may be off by half.
const MOUNT_MODE_PRIOR: f64 = 0.4;
/// How far the mount's frequency may lie from the user's model, as factors: a mode that leaves this range is no mount
/// any more, but stands for a lag or a delay that the model lacks.
const MOUNT_MODE_RANGE: [f64; 2] = [0.5, 2.2];
/// Damping ratios that an elastomer mount has.
const MOUNT_DAMPING_RANGE: [f64; 2] = [0.03, 1.0];
/// Least damping ratio of the disturbance's poles: narrower it is a line, and no turbulence.
const LEAST_DAMPING: f64 = 0.2;
/// Standard deviation of the prior on ln(damping ratio of the mount).
const MOUNT_DAMPING_PRIOR: f64 = 0.7;

impl<'a> Problem<'a> {
    /// Counts all rows in which something was measured but those of the places in `held_out`, and the first second of every run; of one that begins at rest, what comes
    /// before its input first moves.
    pub fn new(data: &'a Dataset, baseline: &'a Baseline, held_out: &[Place]) -> Self {
        let sizes = data.amplitudes(baseline.plant.inertia, baseline.plant.dm_du);
        let mut counted: Vec<Vec<bool>> = data
            .runs
            .iter()
            .map(|run| {
                let first = first_counted(run, &sizes);
                (0..run.len()).map(|k| k >= first && run.is_measured(k)).collect()
            })
            .collect();
        for place in held_out {
            counted[place.run][place.rows.clone()].fill(false);
        }
        let hangs_aside = data.mean_angle().is_some_and(|angle| angle.abs() > ASIDE * sizes.theta);
        Self { data, baseline, sizes, hangs_aside, counted, whole: None }
    }

    /// The same problem on stretches of the data; the signals have the sizes of all data.
    pub fn in_part<'b>(&self, stretches: &'b Dataset) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem {
            sizes: self.sizes,
            hangs_aside: self.hangs_aside,
            whole: Some(self.data),
            ..Problem::new(stretches, self.baseline, &[])
        }
    }

    /// Number of residual channels.
    pub fn channels(&self) -> usize {
        usize::from(self.data.has_rate) + usize::from(self.data.has_angle)
    }

    /// Number of numbers that the criterion counts.
    pub fn count(&self) -> usize {
        self.channels() * self.counted.iter().flatten().filter(|&&c| c).count()
    }

    /// Run and row of every number that the criterion counts, in the order of a fit's residuals.
    pub fn counted_rows(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let rows = |(run, counted): (usize, &'_ Vec<bool>)| -> Vec<(usize, usize)> {
            (0..counted.len()).filter(|&k| counted[k]).map(|k| (run, k)).collect()
        };
        self.counted.iter().enumerate().flat_map(rows)
    }

    /// Number of unknowns of the plant and of the effects that the baseline has; they come first.
    pub fn plant_unknowns(&self) -> usize {
        self.known_range().end
    }

    /// Where the parameters of the effects stand that the baseline has.
    pub fn known_range(&self) -> core::ops::Range<usize> {
        let first = self.mount_range().end;
        let count = self.baseline.terms.iter().map(|term| term.values.len()).sum::<usize>();
        first..first + count
    }

    /// Number of unknowns of the noise model; they follow the plant's.
    pub fn noise_unknowns(&self) -> usize {
        3 + self.channels()
    }

    /// Where the unknowns of the noise model stand.
    pub fn noise_range(&self) -> core::ops::Range<usize> {
        self.plant_unknowns()..self.plant_unknowns() + self.noise_unknowns()
    }

    /// Where the unknowns of the mount stand; empty where the IMU is rigid.
    pub fn mount_range(&self) -> core::ops::Range<usize> {
        let first = 2 + usize::from(self.baseline.delay_free);
        first..first + 2 * usize::from(self.baseline.plant.mount.is_some())
    }

    /// The unknowns: plant, noise model, then the parameters of `effects`.
    pub fn coordinates(&self, effects: &[&'static dyn Effect]) -> Vec<Coordinate> {
        let mut all = self.plant_coordinates();
        all.extend(self.baseline.terms.iter().flat_map(|term| self.known_coordinates(term)));
        all.extend(self.noise_coordinates());
        for &effect in effects {
            all.extend(effect.parameters(&self.sizes).iter().map(|p| self.coordinate_in(effect, p)));
        }
        all
    }

    /// The coordinate of a parameter of `effect`; what is of the command is in its unit.
    fn coordinate_in(&self, effect: &dyn Effect, p: &Parameter) -> Coordinate {
        let mut coordinate = coordinate_of(p);
        if effect.about().locus == Locus::Actuator {
            coordinate.unit = self.data.input_unit.in_place_of_rad(p.unit);
        }
        coordinate
    }

    /// Unknowns of an effect that the baseline has. A moment in time, a term without a name and the background are as the
    /// user has them.
    fn known_coordinates(&self, term: &Term) -> Vec<Coordinate> {
        let id = term.effect.about().id;
        let held = self.baseline.held.contains(&id) || find(id).is_none() || id == GustDisturbance.about().id;
        let parameters = term.effect.parameters(&self.sizes).into_iter().zip(&term.values).enumerate();
        let known = |(i, (p, &value)): (usize, (Parameter, &f64))| {
            let mut coordinate = self.coordinate_in(term.effect, &p);
            coordinate.name = format!("{id}.{}", p.name);
            coordinate.log &= value > 0.0;
            coordinate.bounds = if held || term.effect.moments().any(|moment| moment == i) {
                [value; 2]
            } else {
                [coordinate.bounds[0].min(value), coordinate.bounds[1].max(value)]
            };
            coordinate
        };
        parameters.map(known).collect()
    }

    fn plant_coordinates(&self) -> Vec<Coordinate> {
        let plant = &self.baseline.plant;
        let damping = (self.sizes.moment / self.sizes.q).max(plant.dm_dq.abs());
        let gain = plant.dm_du.abs();
        let mut all = vec![
            coordinate("dM_dq", "N m s/rad", [-1e3 * damping, 0.0], false, 0.1 * damping),
            coordinate(
                "dM_du",
                self.data.input_unit.gain_unit(),
                [-1e3 * gain, 1e3 * gain],
                false,
                0.1 * gain,
            ),
        ];
        if !self.data.input_changes() {
            all[1].bounds = [plant.dm_du; 2];
        }
        if self.baseline.delay_free {
            all.push(coordinate("delay", "s", [self.earliest(), LONGEST_DELAY], false, self.sizes.step));
        }
        if let Some(mount) = plant.mount {
            let (hz, zeta) = mode_of(&mount);
            let mut mode = coordinate(
                "mount_mode",
                "Hz",
                [MOUNT_MODE_RANGE[0] * hz, MOUNT_MODE_RANGE[1] * hz],
                true,
                1.0,
            );
            mode.prior = Some((hz, MOUNT_MODE_PRIOR));
            let mut damping = coordinate("mount_zeta", "1", MOUNT_DAMPING_RANGE, true, 1.0);
            damping.prior = Some((zeta, MOUNT_DAMPING_PRIOR));
            all.extend([mode, damping]);
        }
        all
    }

    fn noise_coordinates(&self) -> Vec<Coordinate> {
        // Bounds are those of 50 Hz sampling, stretched for faster sampling.
        let faster = (0.02 / self.sizes.step).max(1.0);
        let unit = self.intensity_unit();
        let mut all = vec![
            coordinate("disturbance_intensity", "1", [1e-4 * unit, 1e5 * unit], true, 1.0),
            coordinate("disturbance_frequency", "rad/s", [0.1, 60.0 * faster], true, 1.0),
            coordinate("disturbance_damping", "1", [LEAST_DAMPING, 30.0 * faster.sqrt()], true, 1.0),
            coordinate("disturbance_zero", "rad/s", [0.01, 100.0 * faster], true, 1.0),
        ];
        if self.channels() == 2 {
            let ratio = self.sizes.theta / self.sizes.q;
            all.push(coordinate("angle_noise", "s", [1e-4 * ratio, 1e3 * ratio], true, 1.0));
        }
        all
    }

    /// Least delay that stamps can give, s; none below 0 where the input is known to come first.
    pub fn earliest(&self) -> f64 {
        if self.baseline.input_first {
            return 0.0;
        }
        -STAMPED_EARLY * self.sizes.step / self.data.thinned as f64
    }

    /// Intensity of a disturbance that moves the first channel within a second about as much as its noise does, if
    /// that noise is a hundredth of the signal.
    fn intensity_unit(&self) -> f64 {
        let signal = if self.data.has_rate { self.sizes.q } else { self.sizes.theta };
        0.1 * self.sizes.moment / (0.01 * signal)
    }

    /// Noise parameters to begin with, for a disturbance `share` times as strong as one that moves the signal within a
    /// second by about the sensor's noise.
    pub fn noise_start(&self, share: f64) -> Vec<f64> {
        let faster = (0.02 / self.sizes.step).max(1.0).sqrt().sqrt();
        let mut start = vec![share * self.intensity_unit(), 2.2 * faster, 2.3 * faster, 1.0];
        if self.channels() == 2 {
            start.push(0.3 * self.sizes.theta / self.sizes.q);
        }
        start
    }

    /// Frequency, damping and zero of a disturbance without slow parts to begin with, rad/s, 1, rad/s.
    pub fn band_pass(&self) -> [f64; 3] {
        let faster = (0.02 / self.sizes.step).max(1.0).sqrt().sqrt();
        [3.8 * faster, 1.7 * faster, 0.03]
    }

    /// The same for a disturbance that resonates.
    pub fn resonance(&self) -> [f64; 3] {
        [4.0, 0.5, 0.03]
    }

    /// Values of the plant's unknowns in the baseline.
    pub fn plant_start(&self) -> Vec<f64> {
        let plant = &self.baseline.plant;
        let mut start = vec![plant.dm_dq, plant.dm_du];
        if self.baseline.delay_free {
            start.push(plant.delay);
        }
        if let Some(mount) = plant.mount {
            let (hz, zeta) = mode_of(&mount);
            start.extend([hz, zeta]);
        }
        start.extend(self.baseline.terms.iter().flat_map(|term| &term.values));
        start
    }

    /// Values of all unknowns → plant, noise model, terms.
    pub fn unpack(&self, effects: &[&'static dyn Effect], values: &[f64]) -> Unpacked {
        let mut rest = values.iter().copied();
        let mut next = || rest.next().unwrap_or(f64::NAN);
        let mut plant = self.baseline.plant;
        plant.dm_dq = next();
        plant.dm_du = next();
        if self.baseline.delay_free {
            plant.delay = next();
        }
        if let Some(mount) = &mut plant.mount {
            *mount = Mount::from_mode(next(), next(), mount.inertia);
        }
        let mut terms = self.baseline.terms.clone();
        terms.iter_mut().flat_map(|term| &mut term.values).for_each(|value| *value = next());
        let mut disturbance = Disturbance {
            intensity: next(),
            frequency: next(),
            damping: next(),
            zero: next(),
            angle_noise: 1.0,
            third: None,
            corrects: None,
        };
        if self.channels() == 2 {
            disturbance.angle_noise = next();
        }
        for &effect in effects {
            let values: Vec<f64> = effect.parameters(&self.sizes).iter().map(|_| next()).collect();
            disturbance.third = disturbance.third.or_else(|| effect.noise(&values));
            disturbance.corrects = disturbance.corrects.or_else(|| effect.corrects(&values));
            terms.push(Term { effect, values });
        }
        Unpacked { plant, disturbance, terms }
    }

    /// One-step prediction errors of the counted rows as a function of all unknowns.
    pub fn prediction_errors<'p>(
        &'p self,
        effects: &'p [&'static dyn Effect],
    ) -> impl Fn(&[f64]) -> Option<Vec<Output>> + Sync + 'p {
        let known = KnownDrives::default();
        move |values| self.errors(&self.unpack(effects, values), &known)
    }

    /// The same of a model already made of its values.
    pub fn errors_of(&self, unpacked: &Unpacked) -> Option<Vec<Output>> {
        self.errors(unpacked, &KnownDrives::default())
    }

    fn errors(&self, unpacked: &Unpacked, known: &KnownDrives) -> Option<Vec<Output>> {
        let mut all = Vec::new();
        self.of_runs(unpacked, |index, model, gains| {
            let (run, counted) = (&self.data.runs[index], &self.counted[index]);
            let rows = counted.iter().rposition(|c| *c).map_or(0, |k| k + 1);
            let mut own = model.innovations_under(run, gains, &known.of(model, index, run, rows))?;
            // in its place: another copy of a long recording's would be tens of megabytes
            let mut is_counted = counted.iter();
            own.retain(|_| is_counted.next() == Some(&true));
            own.iter_mut().for_each(|e| *e = self.pack(*e));
            if all.is_empty() {
                all = own;
            } else {
                all.append(&mut own);
            }
            Some(())
        })?;
        Some(all)
    }

    /// Runs the predictor over all runs and hands each run's innovations to `take`.
    pub fn predict(&self, unpacked: &Unpacked, mut take: impl FnMut(usize, Vec<Output>)) -> Option<()> {
        self.track(unpacked, |_, _, _| {}, &mut take)
    }

    /// The same, showing the corrected state of every row to `visit` (run, row, point).
    pub fn track(
        &self,
        unpacked: &Unpacked,
        mut visit: impl FnMut(usize, usize, &Point),
        take: &mut dyn FnMut(usize, Vec<Output>),
    ) -> Option<()> {
        self.of_runs(unpacked, |index, model, gains| {
            let run = &self.data.runs[index];
            take(index, model.innovations(run, gains, run.len(), |k, point| visit(index, k, point))?);
            Some(())
        })
    }

    /// Hands every run's sampled model with its gains to `of_run`.
    fn of_runs(
        &self,
        unpacked: &Unpacked,
        mut of_run: impl FnMut(usize, &PitchModel<'_>, &Gains) -> Option<()>,
    ) -> Option<()> {
        let mut sampled: Option<((f64, usize), PitchModel<'_>, Gains)> = None;
        for (index, run) in self.data.runs.iter().enumerate() {
            let pace = (run.step, run.measured_every());
            if !sampled.as_ref().is_some_and(|(known, ..)| *known == pace) {
                let model = self.model(unpacked, run.step)?;
                let gain = model.gain(&unpacked.disturbance, run)?;
                sampled = Some((pace, model, gain));
            }
            let (_, model, gains) = sampled.as_ref()?;
            of_run(index, model, gains)?;
        }
        Some(())
    }

    /// The disturbance moment that the predictor with these values estimates over the longest run of all data; empty where it
    /// diverges.
    pub fn residual_moment(&self, effects: &[&'static dyn Effect], values: &[f64]) -> ResidualMoment {
        if let Some(whole) = self.whole {
            let all = Problem { sizes: self.sizes, ..Problem::new(whole, self.baseline, &[]) };
            return all.residual_moment(effects, values);
        }
        let lengths = self.data.runs.iter().map(Run::len).enumerate();
        let Some((longest, _)) = lengths.max_by_key(|(_, length)| *length) else {
            return ResidualMoment::default();
        };
        let unpacked = self.unpack(effects, values);
        let (mut start, mut moment, mut angle) = (0.0, Vec::new(), Vec::new());
        let visit = |index: usize, k: usize, point: &Point| {
            if index == longest && (!moment.is_empty() || self.counted[index][k]) {
                if moment.is_empty() {
                    start = self.data.runs[index].time(k);
                }
                moment.push(unpacked.disturbance.moment(&point.x));
                angle.push(point.x[THETA]);
            }
        };
        match self.track(&unpacked, visit, &mut |_, _| {}) {
            Some(()) => ResidualMoment { start, step: self.data.runs[longest].step, moment, angle },
            None => ResidualMoment::default(),
        }
    }

    /// The sampled model for a sample period.
    pub fn model<'u>(&self, unpacked: &'u Unpacked, step: f64) -> Option<PitchModel<'u>> {
        PitchModel::new(&unpacked.plant, &unpacked.terms, &unpacked.disturbance, step, &self.sizes)
    }

    /// The same of every run.
    pub fn models<'u>(&self, unpacked: &'u Unpacked) -> Option<Vec<PitchModel<'u>>> {
        self.data.runs.iter().map(|run| self.model(unpacked, run.step)).collect()
    }

    /// Puts the one measured channel first.
    pub fn pack(&self, e: Output) -> Output {
        if self.data.has_rate { e } else { [e[1], 0.0] }
    }
}

/// The coordinate of a parameter.
pub fn coordinate_of(p: &Parameter) -> Coordinate {
    let (log, step) = match p.scale {
        Scale::Log => (true, 1.0),
        Scale::Linear(step) => (false, step),
    };
    // At a coarse sampling a range may be empty: then the parameter is held.
    coordinate(p.name, p.unit, [p.lower, p.upper.max(p.lower)], log, step)
}

fn coordinate(name: &str, unit: &str, bounds: [f64; 2], log: bool, unit_step: f64) -> Coordinate {
    Coordinate { name: name.into(), unit: unit.into(), bounds, log, unit_step, prior: None }
}

/// Undamped frequency in Hz and damping ratio of a mount.
pub fn mode_of(mount: &Mount) -> (f64, f64) {
    let omega = (mount.stiffness / mount.inertia).sqrt();
    (omega / core::f64::consts::TAU, mount.damping / (2.0 * mount.inertia * omega))
}
