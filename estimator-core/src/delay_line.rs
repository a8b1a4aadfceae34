//! Regressor of the last n inputs after an input delay, n up to a capacity N.
//!
//! φ\[k\] = (x\[k−1\], x\[k−2\], …, x\[k−n\]), x\[k\] = u\[k−d\]. Newest first. With the row convention of the
//! recordings (y\[k\] is taken before u\[k\] acts) the newest input that can show in y\[k\] is u\[k−1\].
//!
//! Each x is stored twice, n apart, so the n newest always lie in one contiguous slice and the loops over taps
//! need no wrap. Energy Σx² and sum Σx follow by adding the newest and subtracting the oldest; every n pushes
//! both are replaced by sums accumulated afresh, so rounding does not build up over more than n pushes.
//!
//! Cost: 8 N + 88 bytes; per push two stores, eight additions and multiplications, none of them over n.

use crate::constants::MAX_INPUT_DELAY;

const DELAY_SLOTS: usize = MAX_INPUT_DELAY as usize + 1;

/// The last inputs, newest first. A line serves one n from its beginning on.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayLine<const N: usize> {
    mirrored: [[f32; N]; 2],
    /// Place of the newest in the first copy, below n.
    head: usize,
    waiting: [f32; DELAY_SLOTS],
    next_slot: u8,
    energy: f32,
    sum: f32,
    fresh_energy: f32,
    fresh_sum: f32,
}

impl<const N: usize> Default for DelayLine<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> DelayLine<N> {
    /// A line that has carried zeros for ever.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(N >= 1, "an FIR has at least one tap") };
        Self {
            mirrored: [[0.0; N]; 2],
            head: 0,
            waiting: [0.0; DELAY_SLOTS],
            next_slot: 0,
            energy: 0.0,
            sum: 0.0,
            fresh_energy: 0.0,
            fresh_sum: 0.0,
        }
    }

    /// Takes u\[k\]; what enters the regressor of n = `length` inputs is u delayed by `delay` samples. A `delay` beyond
    /// [`MAX_INPUT_DELAY`] counts modulo 16; a `length` of 0 or beyond N takes nothing. Returns what has entered.
    pub fn push(&mut self, u: f32, delay: u8, length: usize) -> f32 {
        let x = self.wait(u, delay);
        let head = if self.head == 0 { length } else { self.head }.wrapping_sub(1);
        let all = self.mirrored.as_flattened_mut();
        let Some(copy) = all.get_mut(head.wrapping_add(length)) else { return x };
        *copy = x;
        let Some(place) = all.get_mut(head) else { return x };
        self.head = head;
        let oldest = core::mem::replace(place, x);
        let energy = self.energy + x * x - oldest * oldest;
        self.energy = if energy > 0.0 { energy } else { 0.0 };
        self.sum = self.sum + x - oldest;
        self.fresh_energy += x * x;
        self.fresh_sum += x;
        // the head passes here once in n pushes
        if head == 0 {
            (self.energy, self.sum) = (self.fresh_energy, self.fresh_sum);
            (self.fresh_energy, self.fresh_sum) = (0.0, 0.0);
        }
        x
    }

    fn wait(&mut self, u: f32, delay: u8) -> f32 {
        let slot = self.next_slot;
        if let Some(place) = self.waiting.get_mut(usize::from(slot & MAX_INPUT_DELAY)) {
            *place = u;
        }
        self.next_slot = slot.wrapping_add(1) & MAX_INPUT_DELAY;
        let source = usize::from(slot.wrapping_sub(delay) & MAX_INPUT_DELAY);
        self.waiting.get(source).copied().unwrap_or(0.0)
    }

    /// φ of n = `length` inputs, newest first; there always are as many for the n that the line serves.
    #[must_use]
    pub fn regressor(&self, length: usize) -> Option<&[f32]> {
        self.mirrored.as_flattened().get(self.head..)?.get(..length)
    }

    /// Σ x² over φ, rad².
    #[must_use]
    pub const fn energy(&self) -> f32 {
        self.energy
    }

    /// Σ x over φ, rad.
    #[must_use]
    pub const fn sum(&self) -> f32 {
        self.sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_the_last_inputs_newest_first_after_the_delay() {
        for delay in [0_u8, 1, 3, 15] {
            let mut line = DelayLine::<5>::new();
            for k in 1..=100 {
                line.push(k as f32, delay, 5);
                let expected: [f32; 5] =
                    core::array::from_fn(|i| (k - i as i32 - i32::from(delay)).max(0) as f32);
                assert_eq!(line.regressor(5), Some(&expected[..]));
            }
        }
    }

    #[test]
    fn energy_and_sum_do_not_drift() {
        let mut line = DelayLine::<60>::new();
        let mut x = 0.3_f32;
        for _ in 0..200_000 {
            // logistic map: a signal without a period
            x = 3.99 * x * (1.0 - x);
            line.push(x - 0.5, 2, 60);
        }
        let energy: f64 = line.regressor(60).unwrap().iter().map(|&x| f64::from(x) * f64::from(x)).sum();
        let sum: f64 = line.regressor(60).unwrap().iter().map(|&x| f64::from(x)).sum();
        assert!((f64::from(line.energy()) / energy - 1.0).abs() < 1e-5);
        assert!((f64::from(line.sum()) - sum).abs() < 1e-4);
    }

    #[test]
    fn energy_returns_to_zero_when_the_input_does() {
        let mut line = DelayLine::<7>::new();
        for k in 0..50 {
            line.push(0.01 * k as f32, 0, 7);
        }
        for _ in 0..14 {
            line.push(0.0, 0, 7);
        }
        assert_eq!((line.energy(), line.sum()), (0.0, 0.0));
    }
}
