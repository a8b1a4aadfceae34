//! Two-level pseudo-random excitation with random dwell.
//!
//! u(t) = ±a; the interval T between two switches is drawn uniformly from [Tmin, Tmax], in whole microseconds.
//! The level is read at the 20 ms tick: u\[k\] = u(k Ts). Because T ≥ Ts no switch falls between the same two
//! ticks as another, so none is lost and the mean dwell of the sampled signal is the mean of T, also where T
//! is not a multiple of Ts (campaign 1: 0.05 to 0.1 s is 2.5 to 5 ticks, and dwells of 2, 3, 4 and 5 ticks
//! occur).
//!
//! * Draw: T = Tmin + ⌊r (Tmax − Tmin + 1) / 2³²⌋ with r the 32 bits of a PCG-XSH-RR generator (O'Neill, 2014);
//!   multiply and shift instead of a division (Lemire, 2019). A dwell of 1 µs resolution is at most
//!   (Tmax − Tmin + 1) / 2³² ≈ 1e-4 more likely than another.
//! * Spectrum: period 2 E\[T\], hence peak near π / E\[T\]: 5.2 rad/s for campaign 4.
//! * Unlike a shift-register sequence it never repeats within a test; the same seed gives the same sequence.
//! * Hold: do not call [`Prbs::step`]. The state keeps the time to the next switch, so the sequence resumes at
//!   the very place where it was left.
//!
//! Cost: 32 bytes of state, at most one draw per sample.
//! Source: Riccardi, Panizza, Lovera, ERF 2014 (intervals and amplitudes of the campaigns).

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

use crate::config_error::{ConfigError, within};
use crate::constants::{SAMPLE_PERIOD_S, TICK_US};

/// Excitation in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrbsConfig {
    /// Amplitude a, rad, 0 to 0.1.
    pub amplitude_rad: f32,
    /// Shortest dwell Tmin, s, from one sample period to 10.
    pub dwell_min_s: f32,
    /// Longest dwell Tmax, s, from Tmin to 10.
    pub dwell_max_s: f32,
}

impl Default for PrbsConfig {
    fn default() -> Self {
        Self { amplitude_rad: 0.015, dwell_min_s: 0.4, dwell_max_s: 0.8 }
    }
}

impl PrbsConfig {
    pub(crate) fn build(&self) -> Result<Prbs, ConfigError> {
        within("prbs.amplitude_rad", "rad", self.amplitude_rad, [0.0, 0.1])?;
        within("prbs.dwell_min_s", "s", self.dwell_min_s, [SAMPLE_PERIOD_S, 10.0])?;
        within("prbs.dwell_max_s", "s", self.dwell_max_s, [self.dwell_min_s, 10.0])?;
        let min_us = microseconds(self.dwell_min_s).max(TICK_US);
        let span = microseconds(self.dwell_max_s).saturating_sub(min_us).saturating_add(1);
        Ok(Prbs { amplitude_rad: self.amplitude_rad, min_us, span })
    }
}

fn microseconds(seconds: f32) -> u32 {
    libm::roundf(seconds * 1e6) as u32
}

/// Excitation, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prbs {
    amplitude_rad: f32,
    min_us: u32,
    span: u32,
}

/// Place in the sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct PrbsState {
    generator: Pcg32,
    high: bool,
    /// Time from the coming tick to the next switch, µs; never 0.
    switch_in_us: u32,
}

impl Prbs {
    /// The beginning of sequence number `stream` of `seed`. Sequences of one seed are independent of each
    /// other.
    #[must_use]
    pub fn start(&self, seed: u64, stream: u64) -> PrbsState {
        // neighbouring streams of one PCG state are correlated, so the state is scattered as well
        let scattered = split_mix(seed.wrapping_add(stream.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        let mut generator = Pcg32::new(scattered, stream);
        let high = generator.next_u32() >> 31 == 1;
        let switch_in_us = self.draw(&mut generator);
        PrbsState { generator, high, switch_in_us }
    }

    /// u\[k\] in rad, and the sequence moves on by one tick.
    pub fn step(&self, state: &mut PrbsState) -> f32 {
        let level = if state.high { self.amplitude_rad } else { -self.amplitude_rad };
        if state.switch_in_us > TICK_US {
            state.switch_in_us -= TICK_US;
        } else {
            let dwell = self.draw(&mut state.generator);
            state.high = !state.high;
            state.switch_in_us = state.switch_in_us.saturating_add(dwell).saturating_sub(TICK_US);
        }
        level
    }

    fn draw(&self, generator: &mut Pcg32) -> u32 {
        let scaled = u64::from(generator.next_u32()).wrapping_mul(u64::from(self.span)) >> 32;
        self.min_us.saturating_add(scaled as u32)
    }
}

/// Finaliser of SplitMix64 (Steele, Lea, Flood, 2014): every input bit moves every output bit.
fn split_mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn prbs(min: f32, max: f32) -> Prbs {
        PrbsConfig { amplitude_rad: 0.015, dwell_min_s: min, dwell_max_s: max }.build().unwrap()
    }

    fn sequence(prbs: &Prbs, seed: u64, stream: u64, length: usize) -> Vec<f32> {
        let mut state = prbs.start(seed, stream);
        (0..length).map(|_| prbs.step(&mut state)).collect()
    }

    fn dwells(levels: &[f32]) -> Vec<usize> {
        let switches: Vec<usize> = (1..levels.len()).filter(|&k| levels[k] != levels[k - 1]).collect();
        switches.windows(2).map(|w| w[1] - w[0]).collect()
    }

    #[test]
    fn mean_dwell_is_kept_where_it_is_no_multiple_of_the_tick() {
        for [min, max] in crate::constants::CAMPAIGN_DWELL_S {
            let found = dwells(&sequence(&prbs(min, max), 1, 0, 400_000));
            let mean = found.iter().sum::<usize>() as f32 / found.len() as f32 * 0.02;
            // standard error of the mean: (max − min) / √(12 n); five of them
            let bound = 5.0 * (max - min) / (12.0 * found.len() as f32).sqrt();
            assert!((mean - (min + max) / 2.0).abs() < bound + 1e-4, "{min} {max}: {mean}");
        }
    }

    #[test]
    fn drawn_dwells_are_uniform() {
        let prbs = prbs(0.4, 0.8);
        let mut generator = Pcg32::new(7, 0);
        let mut bins = [0_u32; 20];
        for _ in 0..100_000 {
            let dwell = prbs.draw(&mut generator);
            assert!((400_000..=800_000).contains(&dwell));
            bins[((dwell - 400_000) / 20_001) as usize] += 1;
        }
        // chi-square with 19 degrees of freedom: 43.8 is exceeded once in 1000 seeds
        let chi2: f64 = bins.iter().map(|&n| (f64::from(n) - 5000.0).powi(2) / 5000.0).sum();
        assert!(chi2 < 43.8, "{chi2}");
    }

    #[test]
    fn sampled_dwells_stay_within_a_tick_of_the_range() {
        let found = dwells(&sequence(&prbs(0.05, 0.1), 3, 0, 100_000));
        for ticks in [2, 3, 4, 5] {
            assert!(found.contains(&ticks));
        }
        assert!(found.iter().all(|d| (2..=5).contains(d)));
    }

    #[test]
    fn a_dwell_of_whole_ticks_lasts_so_many_and_the_first_too() {
        for (dwell_s, ticks) in [(0.02, 1), (0.4, 20)] {
            let levels = sequence(&prbs(dwell_s, dwell_s), 2, 0, 10 * ticks);
            for (k, level) in levels.iter().enumerate() {
                let expected = if k / ticks % 2 == 0 { levels[0] } else { -levels[0] };
                assert_eq!(*level, expected, "{dwell_s} s, tick {k}");
            }
        }
    }

    #[test]
    fn same_seed_same_sequence_and_other_streams_differ() {
        let prbs = prbs(0.05, 0.1);
        assert_eq!(sequence(&prbs, 5, 1, 2000), sequence(&prbs, 5, 1, 2000));
        let reference = sequence(&prbs, 5, 1, 20_000);
        for (seed, stream) in [(5, 2), (5, 3), (6, 1)] {
            let other = sequence(&prbs, seed, stream, 20_000);
            let correlation: f32 =
                reference.iter().zip(&other).map(|(a, b)| a * b / (0.015 * 0.015)).sum::<f32>() / 20_000.0;
            // about 20000 / 3.75 independent dwells: standard error 0.014
            assert!(correlation.abs() < 0.07, "{seed} {stream}: {correlation}");
        }
    }

    #[test]
    fn a_held_sequence_resumes_where_it_was_left() {
        let prbs = prbs(0.4, 0.8);
        let whole = sequence(&prbs, 9, 0, 1000);
        let mut state = prbs.start(9, 0);
        let mut pieces: Vec<f32> = (0..333).map(|_| prbs.step(&mut state)).collect();
        let held = state.clone();
        pieces.extend((333..1000).map(|_| prbs.step(&mut state)));
        assert_eq!(whole, pieces);
        let mut resumed = held;
        assert_eq!(prbs.step(&mut resumed), whole[333]);
    }
}
