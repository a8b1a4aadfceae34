//! Have the taps converged?
//!
//! The prediction error alone does not tell. NLMS forgets its initial error along a direction v of the
//! regressor space at the rate μ E\[(vᵀφ)² / φᵀφ\] per update: fast along the excited direction (5 rad/s),
//! which carries nearly all of the error, and slowly along the low frequencies, which carry next to none of it
//! and yet decide how the model does in closed loop. A step too small therefore shows a small error and a
//! wrong model. So three things are measured, all of them in passing:
//!
//! | figure | what | converged when |
//! | --- | --- | --- |
//! | settling | min of Σ μ ρ and Σ μ (1 − ρ) over the updates, ρ = (1ᵀφ)² / (n φᵀφ) the share of the regressor's power along the constant direction | ≥ 5: less than a tenth of the initial error is left there |
//! | gain drift | \|G − Ḡ\| / max(\|G\|, \|Ḡ\|), G = Σ w, Ḡ its mean over 5 s | ≤ 0.1 |
//! | innovation ratio | mean e² / mean q² over 5 s | ≤ 0.7: the taps explain part of what they are fed |
//!
//! and nothing is claimed while the root mean square of the input is below `min_input_rms_rad`, averaged over
//! 5 s, or before 5 s of updates (`NotExcited`).
//!
//! Odds and limits. Settling is an expectation over the initial error, not over noise; it does not see the
//! misadjustment μ/(2 − μ) that the noise leaves for ever, which the innovation ratio shows (its floor is the
//! share of q that no model explains). It looks at two directions of N: a rank test it is not; a constant
//! input fails it (ρ = 1), as does a fast one (ρ = 0), a sine does not. Nor is the constant direction an
//! eigenvector of the input's correlation, so more is left than e^−settling says. The threshold therefore
//! comes from an experiment, nominal airframe, campaign 4, N = 100, 3750 samples, 0.02 rad/s of noise:
//!
//! | μ | 0.001 | 0.003 | 0.01 | 0.03 | 0.05 | 0.1 |
//! | --- | --- | --- | --- | --- | --- | --- |
//! | settling | 0.13 | 0.39 | 1.3 | 3.9 | 6.6 | 13 |
//! | error of the static gain, % | 88 | 74 | 46 | 13 | 4.0 | 0.3 |
//! | innovation ratio | 0.47 | 0.25 | 0.065 | 0.009 | 0.005 | 0.005 |
//!
//! Cost: 32 bytes, about 35 operations per update, none of them over N.
//! Source: Haykin, *Adaptive Filter Theory*, 4th ed., section 5.4 (modes of the weight-error vector).

use crate::config_error::{ConfigError, within};
use crate::constants::SAMPLE_PERIOD_S;
use crate::lms::{NormalizedLms, Update};

/// Averaging time of the running means, s: 4 dwells of the slowest excitation and twice the longest regressor.
const AVERAGING_S: f32 = 5.0;
const FORGET: f32 = SAMPLE_PERIOD_S / AVERAGING_S;
/// Updates before a verdict: one averaging time.
const WARM_UP: u32 = 250;

/// Thresholds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvergenceConfig {
    /// Settling from which the taps count as settled, 0.1 to 100.
    pub settled: f32,
    /// Largest drift of the static gain, 0.001 to 1.
    pub max_gain_drift: f32,
    /// Largest share of the pitch rate's power that the taps may leave unexplained, 0.001 to 1.
    pub max_innovation_ratio: f32,
    /// Input below which nothing is learned, rad, 0 to 0.1. The default is a third of the paper's weakest
    /// excitation.
    pub min_input_rms_rad: f32,
}

impl Default for ConvergenceConfig {
    fn default() -> Self {
        Self { settled: 5.0, max_gain_drift: 0.1, max_innovation_ratio: 0.7, min_input_rms_rad: 0.004 }
    }
}

impl ConvergenceConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field outside its legal range.
    pub fn build(&self) -> Result<ConvergenceMeter, ConfigError> {
        within("convergence.settled", "", self.settled, [0.1, 100.0])?;
        within("convergence.max_gain_drift", "", self.max_gain_drift, [0.001, 1.0])?;
        within("convergence.max_innovation_ratio", "", self.max_innovation_ratio, [0.001, 1.0])?;
        within("convergence.min_input_rms_rad", "rad", self.min_input_rms_rad, [0.0, 0.1])?;
        Ok(ConvergenceMeter { config: *self })
    }
}

/// The measurement, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvergenceMeter {
    config: ConvergenceConfig,
}

/// Running means and sums.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConvergenceState {
    error_power: f32,
    output_power: f32,
    input_power: f32,
    settling_low: f32,
    settling_rest: f32,
    gain: f32,
    gain_mean: f32,
    updates: u32,
}

/// What the estimator can say about itself.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Verdict {
    /// Too little input, or too short.
    #[default]
    NotExcited,
    /// The taps still move, or do not explain the output.
    Converging,
    /// All three figures are within their thresholds.
    Converged,
}

/// The figures and the verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convergence {
    /// What follows from the figures.
    pub verdict: Verdict,
    /// Time constants passed along the slower of the two directions.
    pub settling: f32,
    /// Relative distance of the static gain from its mean over 5 s.
    pub gain_drift: f32,
    /// Share of the output's power that was not predicted.
    pub innovation_ratio: f32,
}

impl ConvergenceMeter {
    /// Takes one update of `lms` that met `q` (rad/s) with a regressor of the given `energy` (rad²) and `sum`
    /// (rad).
    pub fn step<const N: usize>(
        &self,
        state: &mut ConvergenceState,
        lms: &NormalizedLms<N>,
        update: Update,
        q: f32,
        [energy, sum]: [f32; 2],
    ) {
        let taps = lms.taps as f32;
        state.updates = state.updates.saturating_add(1);
        state.error_power += FORGET * (update.error * update.error - state.error_power);
        state.output_power += FORGET * (q * q - state.output_power);
        state.input_power += FORGET * (energy / taps - state.input_power);
        if energy > 0.0 {
            let low = (sum * sum / (taps * energy)).min(1.0);
            state.settling_low += lms.step * low;
            state.settling_rest += lms.step * (1.0 - low);
        }
        state.gain = lms.keep * state.gain + update.gain * sum;
        state.gain_mean += FORGET * (state.gain - state.gain_mean);
    }

    /// The figures as they stand.
    #[must_use]
    pub fn figures(&self, state: &ConvergenceState) -> Convergence {
        let c = &self.config;
        let settling = state.settling_low.min(state.settling_rest);
        let largest = state.gain.abs().max(state.gain_mean.abs());
        let gain_drift = ratio((state.gain - state.gain_mean).abs(), largest);
        let innovation_ratio = ratio(state.error_power, state.output_power);
        let silent = state.input_power < c.min_input_rms_rad * c.min_input_rms_rad;
        let within = settling >= c.settled
            && gain_drift <= c.max_gain_drift
            && innovation_ratio <= c.max_innovation_ratio;
        let verdict = match (silent || state.updates < WARM_UP, within) {
            (true, _) => Verdict::NotExcited,
            (false, false) => Verdict::Converging,
            (false, true) => Verdict::Converged,
        };
        Convergence { verdict, settling, gain_drift, innovation_ratio }
    }
}

/// part / whole, 1 where there is nothing to compare with.
fn ratio(part: f32, whole: f32) -> f32 {
    if whole > f32::MIN_POSITIVE { part / whole } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lms::{LmsConfig, LmsState};
    use crate::prbs::PrbsConfig;

    /// 75 s of campaign 4 on the nominal rigid airframe, `noise` rad/s on the rate:
    /// the figures and the relative error of the static gain over the window.
    fn learn(step: f32, noise: f32, amplitude_rad: f32) -> (Convergence, f32) {
        const N: usize = 100;
        let lms =
            LmsConfig { step, input_delay: 3, taps: N as u16, ..LmsConfig::default() }.build::<N>().unwrap();
        let meter = ConvergenceConfig::default().build().unwrap();
        let prbs = PrbsConfig { amplitude_rad, ..PrbsConfig::default() }.build().unwrap();
        let (mut taps, mut figures, mut sequence) =
            (LmsState::default(), ConvergenceState::default(), prbs.start(4, 1));
        let (a, b) = ((-1.583_f32 * 0.02).exp(), 85.2 * (1.0 - (-1.583_f32 * 0.02).exp()));
        let (mut x, mut line, mut seed) = (0.0_f32, [0.0_f32; 4], 1_u32);
        for _ in 0..3750 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let q = x + noise * 3.46 * ((seed >> 8) as f32 / 16_777_216.0 - 0.5);
            let line_figures = [taps.line().energy(), taps.line().sum()];
            let update = lms.observe(&mut taps, q, true);
            meter.step(&mut figures, &lms, update, q, line_figures);
            let u = prbs.step(&mut sequence);
            lms.push(&mut taps, u);
            line.rotate_right(1);
            line[0] = u;
            x = a * x + b * line[3];
        }
        let truth: f32 = (0..N as i32).map(|i| b * a.powi(i)).sum();
        let gain: f32 = taps.taps().iter().sum();
        (meter.figures(&figures), (gain / truth - 1.0).abs())
    }

    #[test]
    fn a_step_too_small_is_not_called_converged_though_its_error_is_small() {
        for step in [0.001, 0.003, 0.01, 0.03] {
            let (found, gain_error) = learn(step, 0.02, 0.015);
            assert_eq!(found.verdict, Verdict::Converging, "{step} {found:?}");
            assert!(gain_error > 0.1, "{step}: {gain_error}");
        }
        assert!(learn(0.01, 0.02, 0.015).0.innovation_ratio < 0.1);
    }

    #[test]
    fn an_adequate_step_is_called_converged_and_is() {
        for step in [0.05, 0.1, 0.3] {
            let (found, gain_error) = learn(step, 0.02, 0.015);
            assert_eq!(found.verdict, Verdict::Converged, "{step} {found:?}");
            assert!(gain_error < 0.1, "{step}: {gain_error}");
        }
    }

    #[test]
    fn settling_is_the_slower_of_the_constant_and_all_other_inputs() {
        let lms = LmsConfig { step: 0.1, taps: 8, ..LmsConfig::default() }.build::<8>().unwrap();
        let meter = ConvergenceConfig::default().build().unwrap();
        // the share of the energy in the constant direction is sum^2 / (8 energy)
        for (sum, share) in [(0.0, 0.0_f32), (2.0, 0.25), (3.0, 0.5625), (4.0, 1.0)] {
            let mut state = ConvergenceState::default();
            for _ in 0..100 {
                meter.step(&mut state, &lms, Update::default(), 0.0, [2.0, sum]);
            }
            let settling = meter.figures(&state).settling;
            assert!((settling - 10.0 * share.min(1.0 - share)).abs() < 1e-3, "{share}: {settling}");
        }
    }

    #[test]
    fn a_threshold_itself_is_met() {
        let config = ConvergenceConfig {
            settled: 4.0,
            max_gain_drift: 0.25,
            max_innovation_ratio: 0.5,
            min_input_rms_rad: 0.0625,
        };
        let meter = config.build().unwrap();
        let at = ConvergenceState {
            error_power: 1.0,
            output_power: 2.0,
            input_power: 0.0625 * 0.0625,
            settling_low: 4.0,
            settling_rest: 4.0,
            gain: -1.0,
            gain_mean: -0.75,
            updates: WARM_UP,
        };
        let verdict = |state| meter.figures(&state).verdict;
        assert_eq!(verdict(at), Verdict::Converged);
        for short in [
            ConvergenceState { settling_low: 4.0_f32.next_down(), ..at },
            ConvergenceState { settling_rest: 4.0_f32.next_down(), ..at },
            ConvergenceState { error_power: 1.0_f32.next_up(), ..at },
            ConvergenceState { gain_mean: -0.7499, ..at },
            // the mean may be the larger one too
            ConvergenceState { gain: -0.7499, gain_mean: -1.0, ..at },
        ] {
            assert_eq!(verdict(short), Verdict::Converging, "{short:?}");
        }
        for early in [
            ConvergenceState { input_power: at.input_power.next_down(), ..at },
            ConvergenceState { updates: WARM_UP - 1, ..at },
        ] {
            assert_eq!(verdict(early), Verdict::NotExcited, "{early:?}");
        }
    }

    #[test]
    fn nothing_settles_where_nothing_is_put_in() {
        let lms = LmsConfig { taps: 8, ..LmsConfig::default() }.build::<8>().unwrap();
        let meter = ConvergenceConfig::default().build().unwrap();
        let mut state = ConvergenceState::default();
        for _ in 0..1000 {
            meter.step(&mut state, &lms, Update::default(), 0.0, [0.0, 0.0]);
        }
        assert_eq!((state.settling_low, state.settling_rest), (0.0, 0.0));
        // with nothing to compare with, nothing is explained
        let Convergence { gain_drift, innovation_ratio, .. } = meter.figures(&state);
        assert_eq!((gain_drift, innovation_ratio), (1.0, 1.0));
    }

    #[test]
    fn without_input_nothing_is_claimed() {
        assert_eq!(learn(0.1, 0.02, 0.0).0.verdict, Verdict::NotExcited);
        assert_eq!(learn(0.1, 0.02, 0.002).0.verdict, Verdict::NotExcited);
    }

    #[test]
    fn taps_that_explain_nothing_are_not_called_converged() {
        assert_eq!(learn(0.1, 3.0, 0.015).0.verdict, Verdict::Converging);
    }

    #[test]
    fn the_tracked_gain_is_the_sum_of_the_taps() {
        let lms = LmsConfig { leakage: 0.001, taps: 8, ..LmsConfig::default() }.build::<8>().unwrap();
        let meter = ConvergenceConfig::default().build().unwrap();
        let (mut state, mut figures) = (LmsState::<8>::default(), ConvergenceState::default());
        for k in 0..500 {
            let line = [state.line().energy(), state.line().sum()];
            let update = lms.observe(&mut state, (0.3 * k as f32).sin(), true);
            meter.step(&mut figures, &lms, update, 1.0, line);
            lms.push(&mut state, 0.01 * (0.2 * k as f32).cos());
        }
        let sum: f32 = state.taps().iter().sum();
        assert!((figures.gain / sum - 1.0).abs() < 1e-4, "{} {sum}", figures.gain);
    }
}
