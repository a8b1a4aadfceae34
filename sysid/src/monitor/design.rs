//! The monitor's model from recordings.

use super::reduced::Linear;
use crate::dataset::{Dataset, Run};
use crate::error::{Error, ErrorKind};
use crate::likelihood::blow_up::no_likelihood;
use crate::likelihood::fit::{Fit, covariance, fit_baseline, refit_with, settled};
use crate::likelihood::problem::{Problem, Unpacked};
use crate::model::baseline::Baseline;
use crate::model::file::ModelFile;
use crate::model::plant::{THETA, THETA_IMU};
use crate::recording::Recording;
use estimator_core::constants::MAX_INPUT_DELAY;
use estimator_core::monitor::{BLOCK, Bank, CAUSES, Cause, Drive, MonitorModel, Predictor, STATES, Test};
use nalgebra::{DMatrix, Matrix2, SMatrix};

/// Lag that is tested for, s: half way on a scale of factors between one that hardly shows and one that upsets a controller.
const LAG_S: f64 = 0.035;
/// Least zero of the air's spectrum, rad/s: air that is taken to have no slow part at all lets the innovations remember a constant
/// moment for minutes, and every slow gust is one.
const SLOWEST: f64 = 0.5;
/// Least noise of the angle over that of the rate, s: an angle that is the logged rate summed up has none, and any gyro offset in
/// flight would be certain at once.
const LEAST_ANGLE_NOISE_S: f64 = 0.01;
/// Least deviation of the innovations as a share of the signals': below it lies what no model has.
const LEAST_SHARE: f64 = 2e-3;
/// Decay of an angle that nothing observes, 1/s.
const LEAK: f64 = 0.1;
/// Rows at the beginning of a run in which the predictor settles.
const SETTLING_S: f64 = 3.0;
/// Length over which scores are summed to see how far they are from those of white innovations, s.
const SPAN_S: f64 = 1.0;
/// Deviations of the identification that are no change.
const TOLERATED: f64 = 2.0;

/// A monitor's model, and what it cost to make it small.
#[derive(Clone, Debug)]
pub struct Design {
    /// The model, checked.
    pub model: MonitorModel,
    /// Sample period, s.
    pub step: f64,
    /// States that the innovations form has, and that the board runs.
    pub states: [usize; 2],
    /// Bound on what the cut states would have moved the innovations by, in their deviations, at the signals' usual sizes.
    pub reduction_error: f64,
    /// What was noticed.
    pub notes: Vec<String>,
}

/// Fits the pitch model to `recordings`, starting from `model`, with a constant moment and a gyro offset, and makes the monitor of
/// it.
///
/// # Errors
/// Recordings that do not go together, no finite likelihood, a delay beyond what the board carries.
pub fn design(recordings: &[Recording], model: Option<&ModelFile>) -> Result<Design, Error> {
    let data = Dataset::on_board(recordings, None)?;
    let baseline = Baseline { delay_free: true, ..Baseline::new(model, &data)? };
    if data.smoothing.is_some() {
        let found =
            "no monitor can be made: the outputs were smoothed both ways in time after they were measured";
        return Err(Error::new(
            ErrorKind::Column,
            found,
            "give the rate as the board has it: the monitor follows that",
        ));
    }
    if !data.has_rate {
        let found = "no monitor can be made: the pitch rate is not in the recording";
        return Err(Error::new(ErrorKind::Column, found, "record it: the monitor follows the rate"));
    }
    let problem = Problem::new(&data, &baseline, &[]);
    let no_likelihood = || no_likelihood(&problem);
    let fit = fitted(&problem).ok_or_else(no_likelihood)?;
    let mut unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    unpacked.disturbance.zero = unpacked.disturbance.zero.max(SLOWEST);
    unpacked.disturbance.angle_noise = unpacked.disturbance.angle_noise.max(LEAST_ANGLE_NOISE_S);
    let run = data.runs.iter().max_by_key(|run| run.len()).ok_or_else(no_likelihood)?;
    let residuals = problem.errors_of(&unpacked).ok_or_else(no_likelihood)?;
    let whitening = whitening(&residuals, &problem).ok_or_else(no_likelihood)?;
    let mut notes = Vec::new();
    let linear = baseline.terms.iter().filter(|term| !term.effect.is_background()).count();
    if linear > 0 {
        notes.push(format!("{linear} effects of the model are in the monitor by their linear part alone"));
    }
    let (mut made, states, reduction_error) =
        predictor(&problem, &unpacked, run, &whitening).ok_or_else(no_likelihood)?;
    let samples = f64::from(made.delay_samples);
    if samples > f64::from(MAX_INPUT_DELAY) {
        let found = format!("an input delay of {:.3} s", samples * run.step);
        return Err(Error::new(
            ErrorKind::Model,
            found,
            "identify again, or correct the clock of the recording",
        )
        .expecting(format!("at most {MAX_INPUT_DELAY} samples of {} s", run.step)));
    }
    let scores = Scores::over(&made, &data);
    let open = TOLERATED * scores.deviation(Cause::Effectiveness as usize);
    if open > MOST_OPEN_EFFECTIVENESS {
        let found = format!(
            "no monitor can be made: these recordings leave the effectiveness open by {:.0} %",
            100.0 * open
        );
        let help =
            "identify from one in which the input moves the craft throughout, as in the test of pitchid fly";
        return Err(Error::new(ErrorKind::Numerical, found, help)
            .expecting(format!("at most {:.0} %", 100.0 * MOST_OPEN_EFFECTIVENESS)));
    }
    made.specific = if model.is_none() { 1.0 } else { 0.0 };
    of_tests(&mut made, &scores, &problem, &unpacked);
    made.check().map_err(|refusal| {
        Error::new(
            ErrorKind::Model,
            format!("no monitor can be made: {refusal}"),
            "identify from a longer recording",
        )
    })?;
    Ok(Design { model: made, step: run.step, states, reduction_error, notes })
}

/// The baseline with a constant moment, and a gyro offset where the angle tells one.
fn fitted(problem: &Problem<'_>) -> Option<Fit> {
    let plain = fit_baseline(problem)?;
    let wanted = ["trim_offset"].into_iter().chain((problem.channels() == 2).then_some("gyro_bias"));
    let effects = problem.baseline.missing(wanted);
    refit_with(problem, &plain, &effects, 0).map(|fit| settled(problem, fit))
}

/// W with W S Wᵀ = I, S the innovations' covariance; of one channel in its first entry.
fn whitening(residuals: &[[f64; 2]], problem: &Problem<'_>) -> Option<Matrix2<f64>> {
    let sizes = [problem.sizes.q, problem.sizes.theta].map(|size| (LEAST_SHARE * size).powi(2));
    let s = covariance(residuals) + Matrix2::new(sizes[0], 0.0, 0.0, sizes[1]);
    if problem.channels() == 1 {
        return (s[(0, 0)] > 0.0).then(|| Matrix2::new(1.0 / s[(0, 0)].sqrt(), 0.0, 0.0, 0.0));
    }
    s.cholesky()?.l().try_inverse()
}

/// The model but for its tests; its states before and after, and the error of that.
fn predictor(
    problem: &Problem<'_>,
    unpacked: &Unpacked,
    run: &Run,
    whitening: &Matrix2<f64>,
) -> Option<(MonitorModel, [usize; 2], f64)> {
    let pitch = problem.model(unpacked, run.step)?;
    // the board has a reading in each row
    let run = &Run { unmeasured: Vec::new(), ..run.clone() };
    let gains = pitch.gain(&unpacked.disturbance, run)?;
    let innovation = pitch.innovation_filter(&gains, run);
    let n = innovation.transition.nrows();
    let channels = innovation.measured.len();
    let sizes = &problem.sizes;
    let scales: Vec<f64> = [sizes.moment, sizes.q, sizes.theta].into_iter().take(1 + channels).collect();
    let mut b = DMatrix::zeros(n, 1 + channels);
    b.set_column(0, &innovation.per_moment);
    for (place, column) in innovation.per_addition.iter().enumerate() {
        b.set_column(1 + place, column);
    }
    b *= DMatrix::from_diagonal(&nalgebra::DVector::from_vec(scales.clone()));
    let mut measured = DMatrix::zeros(2, n);
    for (channel, state) in innovation.measured.iter().enumerate() {
        measured[(channel, *state)] = 1.0;
    }
    let mut f = DMatrix::from_column_slice(n, n, innovation.transition.as_slice());
    if channels == 1 {
        for angle in [THETA, THETA_IMU] {
            f[(angle, angle)] *= 1.0 - LEAK * run.step;
        }
    }
    let whitened = DMatrix::from_fn(2, n, |i, j| (0..2).map(|k| whitening[(i, k)] * measured[(k, j)]).sum());
    let full = Linear { f, b, c: whitened };
    let (reduced, error) = full.reduced(STATES)?;
    let moved = reduced.b.ncols() as f64;
    let mut small = reduced.in_blocks()?;
    small.b *= DMatrix::from_diagonal(&nalgebra::DVector::from_vec(scales).map(|scale| 1.0 / scale));
    let kept = small.f.nrows();

    let mut f = SMatrix::<f64, STATES, STATES>::zeros();
    f.view_mut((0, 0), (kept, kept)).copy_from(&small.f);
    let mut b = SMatrix::<f64, STATES, 3>::zeros();
    b.view_mut((0, 0), (kept, small.b.ncols())).copy_from(&small.b);
    let mut c = SMatrix::<f64, 2, STATES>::zeros();
    c.view_mut((0, 0), (2, kept)).copy_from(&small.c);
    let rest = (SMatrix::<f64, STATES, STATES>::identity() - f).try_inverse()?;
    let trim = c * (rest * b.column(0));
    let bias = whitening.column(0) - c * (rest * b.column(1));
    let of = |id: &str| {
        let term = unpacked.terms.iter().find(|term| term.effect.about().id == id);
        term.and_then(|term| term.values.first()).copied().unwrap_or(0.0)
    };
    let at_rest = trim * of("trim_offset") + bias * of("gyro_bias");
    // an input that is interpolated acts half a sample before one that is held
    let early = if run.held { 0.0 } else { 0.5 };
    let samples = (innovation.delay / run.step - early).max(0.0);
    let model = MonitorModel {
        transition: core::array::from_fn(|block| {
            let at = 2 * block;
            [f[(at, at)], f[(at, at + 1)], f[(at + 1, at)], f[(at + 1, at + 1)]].map(|x| x as f32)
        }),
        moment: core::array::from_fn(|i| b[(i, 0)] as f32),
        correction: [1, 2].map(|j| core::array::from_fn(|i| b[(i, j)] as f32)),
        output: [0, 1].map(|i| core::array::from_fn(|j| c[(i, j)] as f32)),
        whitening: [whitening[(0, 0)], whitening[(1, 0)], whitening[(1, 1)]].map(|x| x as f32),
        rest: [at_rest[0] as f32, at_rest[1] as f32],
        specific: 0.0,
        gain: unpacked.plant.dm_du as f32,
        delay_samples: (samples + 1e-6).floor() as f32,
        delay_fraction: (samples - (samples + 1e-6).floor()).max(0.0) as f32,
        lag: [(1.0 - (-run.step / LAG_S).exp()) as f32, LAG_S as f32],
        friction_rate: (0.03 * sizes.q) as f32,
        trim: [trim[0] as f32, trim[1] as f32],
        bias: [bias[0] as f32, bias[1] as f32],
        tests: [Test { dead_zone: 0.0, calibration: 1.0, onset: [1.0, 0.0], sizes: [0.0; 6] }; CAUSES],
    };
    let live = full.f.row_iter().filter(|row| row.iter().any(|x| *x != 0.0)).count();
    Some((model, [live, kept], error * moved.sqrt()))
}

/// Sizes at which a cause is tested, as multiples of the unit that [`usual`] gives; the smallest is twice the least that matters.
const BOTH: [f64; 6] = [-4.0, -2.0, -1.0, 1.0, 2.0, 4.0];
/// Of what cannot be negative beside the identified; a delay may shrink a little.
const ONE_SIDED: [f64; 6] = [-1.0, 0.5, 1.0, 2.0, 4.0, 8.0];

/// Largest dead zone in the same unit: a cause that the identification leaves more open is not tested.
const MOST_OPEN: f64 = 8.0;
/// Largest dead zone of the effectiveness, a share: beyond a factor of two it is no identification.
const MOST_OPEN_EFFECTIVENESS: f64 = 0.5;
/// Dead zone, at least, in the same unit.
const WITHIN: f64 = 0.2;

/// Unit of each cause's sizes.
fn usual(cause: Cause, problem: &Problem<'_>, unpacked: &Unpacked) -> (f64, [f64; 6]) {
    let sizes = &problem.sizes;
    match cause {
        Cause::Effectiveness => (0.15, BOTH),
        Cause::GyroScale => (0.15, BOTH),
        Cause::Lag => (0.015, ONE_SIDED),
        Cause::Trim => (0.12 * sizes.moment, BOTH),
        Cause::Damping => (0.25 * (sizes.moment / sizes.q).max(unpacked.plant.dm_dq.abs()), BOTH),
        Cause::Friction => (0.15 * sizes.moment, ONE_SIDED),
        Cause::GyroBias => (0.05 * sizes.q, BOTH),
        Cause::Stiffness => (0.25 * sizes.moment / sizes.theta, BOTH),
    }
}

/// Sizes, dead zones and calibration: the last two from the identification's own recording.
fn of_tests(model: &mut MonitorModel, scores: &Scores, problem: &Problem<'_>, unpacked: &Unpacked) {
    for (place, cause) in Cause::ALL.into_iter().enumerate() {
        let (unit, sizes) = usual(cause, problem, unpacked);
        let uncertain = TOLERATED * scores.deviation(place);
        // without the angle a gyro's scale shows as effectiveness does, and its offset as a trim moment
        let hidden =
            !problem.data.has_angle && matches!(cause, Cause::GyroScale | Cause::GyroBias | Cause::Stiffness);
        // nor is what the identification tells nothing of
        if hidden || uncertain > MOST_OPEN * unit {
            continue;
        }
        let dead_zone = (WITHIN * unit).max(uncertain);
        model.tests[place] = Test {
            dead_zone: dead_zone as f32,
            calibration: scores.calibration(place) as f32,
            onset: match cause {
                Cause::Trim => onset(model, BY_MOMENT, 1.0, [0.0; 2], model.trim),
                Cause::GyroBias => {
                    let [w_qq, w_tq, _] = model.whitening;
                    onset(model, BY_RATE, -1.0, [w_qq, w_tq], model.bias)
                }
                _ => [1.0, 0.0],
            },
            sizes: sizes.map(|size| {
                let size: f64 = size * unit;
                // what the identification leaves open is added, so that every size stays beyond it
                (size + size.signum() * (dead_zone - WITHIN * unit)) as f32
            }),
        };
    }
}

/// A filter of the bank that a moment drives, and one that an addition to the rate drives.
const BY_MOMENT: usize = 0;
const BY_RATE: usize = 6;

/// How the trace of something constant grows to `lasting` from the moment on at which it begins, drives `filter` by `input` and adds
/// `direct`: what it is of it in the mean of the first block, and the pace that fits the blocks of the first 5 s best.
fn onset(model: &MonitorModel, filter: usize, input: f32, direct: [f32; 2], lasting: [f32; 2]) -> [f32; 2] {
    const BLOCKS: usize = 25;
    let size = lasting[0] * lasting[0] + lasting[1] * lasting[1];
    if size == 0.0 {
        return [1.0, 0.0];
    }
    let mut drive = Drive::default();
    drive.inputs[filter] = input;
    let mut bank = Bank::default();
    let share = |bank: &Bank| {
        let [a, b] = bank.outputs(&model.output)[filter];
        ((direct[0] + a) * lasting[0] + (direct[1] + b) * lasting[1]) / size
    };
    let shares: Vec<f64> = (0..BLOCKS)
        .map(|_| {
            let sum: f32 = (0..BLOCK)
                .map(|_| {
                    let now = share(&bank);
                    bank.advance(model, &drive);
                    now
                })
                .sum();
            f64::from(sum) / f64::from(BLOCK)
        })
        .collect();
    let first = shares[0].clamp(0.0, 1.0);
    let error = |pace: &f64| {
        let grown = |k: usize| 1.0 - (1.0 - first) * (1.0 - pace).powi(k as i32);
        shares.iter().enumerate().map(|(k, share)| (share - grown(k)).powi(2)).sum::<f64>()
    };
    let paces = (0..=200).map(|k| f64::from(k) / 200.0);
    let pace = paces.min_by(|a, b| error(a).total_cmp(&error(b))).unwrap_or(1.0);
    [first as f32, pace as f32]
}

/// Scores over the identification's own recording.
struct Scores {
    information: [f64; CAUSES],
    /// Σ Z² and Σ I over spans, cause by cause.
    spans: [[f64; 2]; CAUSES],
}

impl Scores {
    fn over(model: &MonitorModel, data: &Dataset) -> Self {
        let mut scores = Self { information: [0.0; CAUSES], spans: [[0.0; 2]; CAUSES] };
        for run in &data.runs {
            let settling = ((SETTLING_S / run.step) as usize).min(run.len() / 4);
            let length = (SPAN_S / run.step).ceil() as usize;
            let mut predictor = Predictor::default();
            let mut span = [[0.0; 2]; CAUSES];
            for (k, u) in run.u.iter().enumerate() {
                let shown = predictor.step(model, reading(run, k), *u as f32, f32::MAX);
                if k < settling {
                    continue;
                }
                let [e_q, e_t] = shown.innovation.map(f64::from);
                let traces = shown.traces.map(|trace| trace.map(f64::from));
                for (i, a) in traces.iter().enumerate() {
                    scores.information[i] += a[0] * a[0] + a[1] * a[1];
                    span[i][0] += a[0] * e_q + a[1] * e_t;
                    span[i][1] += a[0] * a[0] + a[1] * a[1];
                }
                if (k + 1 - settling).is_multiple_of(length) {
                    for (sums, own) in scores.spans.iter_mut().zip(&mut span) {
                        sums[0] += own[0] * own[0];
                        sums[1] += own[1];
                    }
                    span = [[0.0; 2]; CAUSES];
                }
            }
        }
        scores
    }

    /// Of the identified size of a cause, the others known.
    fn deviation(&self, cause: usize) -> f64 {
        (self.calibration(cause) / self.information[cause].max(f64::MIN_POSITIVE)).sqrt()
    }

    fn calibration(&self, cause: usize) -> f64 {
        let [squares, information] = self.spans[cause];
        (squares / information.max(f64::MIN_POSITIVE)).clamp(1.0, 1e3)
    }
}

/// What the monitor is given of row `k`: rate and angle.
pub(super) fn reading(run: &Run, k: usize) -> [f32; 2] {
    [&run.rate, &run.angle].map(|signal| signal.as_ref().map_or(0.0, |values| values[k] as f32))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::recording::{ReadOptions, parse};
    use std::fmt::Write as _;

    /// A minute of a square wave of `amplitude` on a craft with a spring, in turbulence.
    pub fn recording(amplitude: f64) -> Recording {
        let (mut q, mut theta, mut noise) = (0.0_f64, 0.0, 1_u32);
        let mut text = String::from("t_s,u_rad,q_rad_s,theta_rad\n");
        for k in 0..3000 {
            let mut random = || {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(noise >> 8) / 16_777_216.0 - 0.5
            };
            let u = if (k / 25 + k / 70) % 2 == 0 { amplitude } else { -amplitude };
            let t = 0.02 * f64::from(k);
            writeln!(text, "{t},{u},{},{}", q + 0.03 * random(), theta + 0.003 * random()).unwrap();
            theta += 0.02 * q;
            q += 0.02 * (-1.5 * q + 135.0 * u - 4.0 * theta + 0.6 * random());
        }
        parse("made", text.as_bytes(), &ReadOptions::default()).unwrap()
    }

    #[test]
    fn a_recording_that_tells_nothing_of_the_effectiveness_makes_no_monitor() {
        assert!(design(&[recording(0.015)], None).is_ok());
        let refusal = design(&[recording(1.5e-5)], None).unwrap_err().to_string();
        assert!(refusal.contains("leave the effectiveness open by"), "{refusal}");
    }
}
