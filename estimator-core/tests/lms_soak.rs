//! The estimator over very long records, and with inputs that no flight has.
//!
//! `LMS_SAMPLES` is the length, a million unless it is set; the long run of 10⁸ takes some minutes.

use estimator_core::lms::{LmsConfig, LmsState, NormalizedLms};

const N: usize = 60;
const DELAY: usize = 3;
/// Standard deviation of the noise on q, rad/s.
const NOISE: f64 = 0.015;

fn samples() -> u64 {
    std::env::var("LMS_SAMPLES").map_or(1_000_000, |text| text.parse().expect("LMS_SAMPLES is a number"))
}

fn lms() -> NormalizedLms<N> {
    LmsConfig { input_delay: DELAY as u8, taps: N as u16, ..LmsConfig::default() }.build().unwrap()
}

/// Random numbers of a generator whose period is 2⁶⁴ (Steele, Lea, Flood, 2014).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Nearly normal: the sum of four uniform numbers, of unit variance.
    fn normal(&mut self) -> f64 {
        (0..4).map(|_| self.uniform() - 0.5).sum::<f64>() * 3.0_f64.sqrt()
    }
}

/// The excitation: ±0.015 rad, dwells of 0.4 to 0.8 s.
struct Excitation {
    level: f64,
    left: u64,
}

impl Excitation {
    fn next(&mut self, random: &mut Random) -> f64 {
        if self.left == 0 {
            self.level = -self.level;
            self.left = 20 + random.bits() % 21;
        }
        self.left -= 1;
        self.level
    }
}

/// The nominal airframe as it answers at the samples, behind its delay: q⁺ = a q + b u.
struct Airframe {
    q: f64,
    waiting: [f64; DELAY],
}

impl Airframe {
    fn step(&mut self, u: f64) -> f64 {
        let pole = (-0.27_f64 / 0.1705 * 0.02).exp();
        self.waiting.rotate_right(1);
        let arrives = std::mem::replace(&mut self.waiting[0], u);
        self.q = pole * self.q + 23.0 / 0.27 * (1.0 - pole) * arrives;
        self.q
    }
}

/// The same recurrence in double precision, in the order in which the equations stand.
struct Twin {
    taps: [f64; N],
    inputs: [f64; N + DELAY],
}

impl Twin {
    fn observe(&mut self, q: f64) {
        let config = LmsConfig::default();
        let [step, regularisation] = [config.step, config.regularisation_rad2].map(f64::from);
        let line = &self.inputs[DELAY..];
        let error = q - self.taps.iter().zip(line).map(|(w, x)| w * x).sum::<f64>();
        let gain = step * error / (regularisation + line.iter().map(|x| x * x).sum::<f64>());
        self.taps.iter_mut().zip(line).for_each(|(w, x)| *w += gain * x);
    }

    fn push(&mut self, u: f64) {
        self.inputs.rotate_right(1);
        self.inputs[0] = u;
    }
}

fn norm<T: Copy + Into<f64>>(taps: &[T]) -> f64 {
    taps.iter().map(|&w| w.into().powi(2)).sum::<f64>().sqrt()
}

#[test]
fn under_excitation_it_stays_beside_its_twin_in_double_precision() {
    let (lms, mut state) = (lms(), LmsState::default());
    let mut twin = Twin { taps: [0.0; N], inputs: [0.0; N + DELAY] };
    let mut random = Random(1);
    let mut excitation = Excitation { level: 0.015, left: 0 };
    let mut airframe = Airframe { q: 0.0, waiting: [0.0; DELAY] };
    let (mut q, mut furthest, mut largest) = (0.0, 0.0_f64, 0.0_f64);
    let total = samples();
    for k in 0..total {
        // both are given the number that single precision holds
        let seen = (q + NOISE * random.normal()) as f32;
        lms.observe(&mut state, seen, true);
        twin.observe(f64::from(seen));
        let u = excitation.next(&mut random) as f32;
        lms.push(&mut state, u);
        twin.push(f64::from(u));
        q = airframe.step(f64::from(u));
        if k % 1000 == 999 {
            let apart: [f64; N] = std::array::from_fn(|i| f64::from(state.taps()[i]) - twin.taps[i]);
            furthest = furthest.max(norm(&apart) / norm(&twin.taps));
            largest = largest.max(norm(state.taps()));
        }
    }
    println!("{total} samples: at most {furthest:.1e} of its norm from the twin, norm at most {largest:.1}");
    assert!(furthest < 1e-3, "{furthest}");
    assert!(largest < 40.0, "{largest}");
}

#[test]
fn without_excitation_no_bit_moves() {
    let (lms, mut state) = (lms(), LmsState::default());
    let mut random = Random(2);
    for _ in 0..2000 {
        lms.observe(&mut state, random.normal() as f32, true);
        lms.push(&mut state, 0.015 * random.normal() as f32);
    }
    // the line empties
    for _ in 0..N + DELAY {
        lms.push(&mut state, 0.0);
    }
    let before = state.taps().map(f32::to_bits);
    let total = samples();
    for _ in 0..total {
        lms.observe(&mut state, (NOISE * random.normal()) as f32, true);
        lms.push(&mut state, 0.0);
    }
    println!("{total} samples without excitation");
    assert_eq!(state.taps().map(f32::to_bits), before);
}

#[test]
fn a_constant_command_and_an_offset_move_the_taps_no_further_than_their_share() {
    // φ is constant: w moves along it alone, to where it explains the mean of q
    let (lms, mut state) = (lms(), LmsState::default());
    let mut random = Random(3);
    for _ in 0..N + DELAY {
        lms.push(&mut state, 0.01);
    }
    let total = samples();
    for _ in 0..total {
        lms.observe(&mut state, (0.3 + NOISE * random.normal()) as f32, true);
        lms.push(&mut state, 0.01);
    }
    let sum: f64 = state.taps().iter().map(|&w| f64::from(w)).sum();
    assert!((0.01 * sum - 0.3).abs() < 0.02, "{sum}");
    let mean = sum / N as f64;
    assert!(state.taps().iter().all(|&w| (f64::from(w) - mean).abs() < 0.02 * mean));
}

#[test]
fn a_burst_is_forgotten() {
    let lms = lms();
    let (mut struck, mut spared) = (LmsState::default(), LmsState::default());
    let mut random = Random(4);
    let mut excitation = Excitation { level: 0.015, left: 0 };
    let mut airframe = Airframe { q: 0.0, waiting: [0.0; DELAY] };
    let mut q = 0.0;
    let mut apart = Vec::new();
    for k in 0..90_000 {
        let seen = q + NOISE * random.normal();
        // 1 s of readings that have nothing to do with the command
        let wild = if (30_000..30_050).contains(&k) { 2.0 * random.normal() } else { 0.0 };
        lms.observe(&mut struck, (seen + wild) as f32, true);
        lms.observe(&mut spared, seen as f32, true);
        let u = excitation.next(&mut random) as f32;
        lms.push(&mut struck, u);
        lms.push(&mut spared, u);
        q = airframe.step(f64::from(u));
        if k >= 30_050 {
            let difference: [f32; N] = std::array::from_fn(|i| struck.taps()[i] - spared.taps()[i]);
            apart.push(norm(&difference));
        }
    }
    let after =
        |share: f64| apart.iter().rposition(|&d| d > share * apart[0]).map_or(0.0, |k| 0.02 * k as f64);
    println!(
        "a burst of 1 s moves the taps by {:.1} of {:.1}; half of it is left after {:.0} s, a tenth after {:.0} s",
        apart[0],
        norm(spared.taps()),
        after(0.5),
        after(0.1)
    );
    assert!(apart[0] > 1.0, "the burst is seen");
    assert!(after(0.5) < 100.0);
    assert!(apart.windows(2).all(|two| two[1] <= two[0] * 1.000_01), "the difference never grows");
}

#[test]
fn inputs_that_no_flight_has_leave_numbers() {
    let tiny = [f32::MIN_POSITIVE, 1e-40, 1e-45, -1e-42, 0.0];
    let huge = [f32::MAX, -f32::MAX, 1e30, -1e20, f32::INFINITY, f32::NAN, f32::NEG_INFINITY];
    let mut random = Random(5);
    let mut pick = |from: &[f32]| from[random.bits() as usize % from.len()];
    for (readings, inputs) in [
        (&tiny[..], &tiny[..]),
        (&huge, &[0.015, -0.015]),
        (&tiny, &[0.015, -0.015]),
        (&[1.0, -1.0], &tiny),
        (&huge, &tiny),
        (&[0.5, -0.5], &[1e18, -1e15, 1e-30]),
        (&huge, &[1e18, -1e15, 1e-30]),
    ] {
        let (lms, mut state) = (lms(), LmsState::default());
        for k in 0..20_000 {
            let update = lms.observe(&mut state, pick(readings), true);
            assert!(update.gain.is_finite());
            assert!(state.taps().iter().all(|w| w.is_finite()), "{readings:?} {inputs:?} {k}");
            lms.push(&mut state, pick(inputs));
        }
    }
}

#[test]
fn after_an_overflow_it_learns_as_before() {
    let (lms, mut state) = (lms(), LmsState::default());
    for q in [f32::MAX, f32::NAN, f32::INFINITY, -f32::MAX] {
        lms.observe(&mut state, q, true);
        lms.push(&mut state, 0.015);
    }
    let mut random = Random(6);
    let mut excitation = Excitation { level: 0.015, left: 0 };
    let mut airframe = Airframe { q: 0.0, waiting: [0.0; DELAY] };
    let mut q = 0.0;
    for _ in 0..30_000 {
        lms.observe(&mut state, (q + NOISE * random.normal()) as f32, true);
        let u = excitation.next(&mut random) as f32;
        lms.push(&mut state, u);
        q = airframe.step(f64::from(u));
    }
    let first = 23.0 / 0.27 * (1.0 - (-0.27_f64 / 0.1705 * 0.02).exp());
    let early: f64 = state.taps()[..20].iter().map(|&w| f64::from(w)).sum();
    let expected: f64 = (0..20).map(|i| first * (-0.27_f64 / 0.1705 * 0.02 * f64::from(i)).exp()).sum();
    assert!((early / expected - 1.0).abs() < 0.1, "{early} {expected}");
}
