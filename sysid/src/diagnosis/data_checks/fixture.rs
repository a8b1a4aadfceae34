//! A test flight for the tests of checks of the data: q̇ = (∂M/∂q q + ∂M/∂u u(t−3T) + disturbance)/Iyy at 50 Hz.

use crate::dataset::Dataset;
use crate::likelihood::fit::{Fit, fit_baseline};
use crate::likelihood::problem::Problem;
use crate::model::baseline::Baseline;
use crate::model::file::{ModelFile, PlantSection};
use crate::recording::{ReadOptions, Recording, parse};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub const STEP: f64 = 0.02;
const INERTIA: f64 = 0.1705;
const DAMPING: f64 = -0.27;
pub const GAIN: f64 = 23.0;

/// What was logged, to be spoilt by a test.
#[derive(Clone)]
pub struct Flight {
    pub u: Vec<f64>,
    pub q: Vec<f64>,
    pub theta: Vec<f64>,
    pub supervised: Vec<bool>,
    pub reference: Vec<f64>,
    pub section: &'static str,
}

pub fn normal(random: &mut Pcg64) -> f64 {
    (0..12).map(|_| random.random::<f64>() - 0.5).sum()
}

/// Forty seconds of PRBS, to which a controller adds −`feedback`·q, rad per rad/s; the input held between samples.
pub fn flight(seed: u64, feedback: f64) -> Flight {
    flown(seed, feedback, [0.0, 1.0])
}

/// The same; the moment over a step has these shares of the input two and three samples before.
pub fn flown(seed: u64, feedback: f64, [two, three]: [f64; 2]) -> Flight {
    const ROWS: usize = 2000;
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut level, mut left) = (0.015, 0);
    let (mut rate, mut angle, mut moment) = (0.0, 0.0, 0.0);
    let empty = || Vec::with_capacity(ROWS);
    let (mut u, mut q, mut theta) = (empty(), empty(), empty());
    for k in 0..ROWS {
        if left == 0 {
            (level, left) = (-level, random.random_range(10..30));
        }
        left -= 1;
        q.push(rate + 0.01 * normal(&mut random));
        theta.push(angle + 0.003 * normal(&mut random));
        u.push(level - feedback * q[k]);
        moment = 0.9 * moment + 0.06 * normal(&mut random);
        let delayed = if k >= 3 { two * u[k - 2] + three * u[k - 3] } else { 0.0 };
        let next = rate + STEP * (DAMPING * rate + GAIN * delayed + moment) / INERTIA;
        angle += 0.5 * STEP * (rate + next);
        rate = next;
    }
    Flight { u, q, theta, supervised: vec![false; ROWS], reference: vec![0.0; ROWS], section: "I" }
}

impl Flight {
    pub fn text(&self) -> String {
        let row = |k: usize| {
            format!(
                "{:.2},{},{},{},{},{},{}\n",
                STEP * k as f64,
                self.u[k],
                self.q[k],
                self.theta[k],
                self.section,
                u8::from(self.supervised[k]),
                self.reference[k]
            )
        };
        let header = "t_s,u_rad,q_rad_s,theta_rad,section,supervised,theta_ref_rad\n";
        header.to_owned() + &(0..self.u.len()).map(row).collect::<String>()
    }

    pub fn recording(&self) -> Recording {
        read(&self.text())
    }
}

/// Means over the rows about each, with binomial weights.
pub fn smoothed(signal: &[f64]) -> Vec<f64> {
    let once = |s: Vec<f64>| -> Vec<f64> {
        let next = |k: usize| s[(k + 1).min(s.len() - 1)];
        (0..s.len()).map(|k| 0.25 * s[k.saturating_sub(1)] + 0.5 * s[k] + 0.25 * next(k)).collect()
    };
    (0..12).fold(signal.to_vec(), |signal, _| once(signal))
}

pub fn read(text: &str) -> Recording {
    parse("flight.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
}

/// A vehicle that turbulence shakes and a controller holds, which answers to the rate within the row and follows a small
/// reference; the rate alone is logged.
pub fn held_in_the_air(seed: u64) -> Recording {
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut rate, mut moment) = (0.0, 0.0);
    let mut text = String::from("t_s,u_rad,q_rad_s,section\n");
    for k in 0..2000 {
        let measured = rate + 0.002 * normal(&mut random);
        let reference = if (k / 150) % 2 == 0 { 0.01 } else { -0.01 };
        let u = -0.1 * (measured - reference) + 0.0005 * normal(&mut random);
        text.push_str(&format!("{:.2},{u:.6},{measured:.6},closed\n", 0.02 * f64::from(k)));
        moment = 0.95 * moment + 0.1 * normal(&mut random);
        rate += 0.02 * (GAIN * u + moment) / 0.17;
    }
    read(&text)
}

/// The user's model, right but for what a test changes.
pub fn model(dm_du: f64, delay: f64) -> ModelFile {
    let plant = PlantSection {
        inertia_kg_m2: INERTIA,
        delay_s: Some(delay),
        dm_dq: Some(DAMPING),
        dm_du: Some(dm_du),
        mount_k: None,
        mount_c: None,
        mount_j: None,
    };
    ModelFile { plant, effects: Vec::new(), intervals: Default::default() }
}

/// Fits the baseline and hands everything to `ask`.
pub fn fitted<T>(
    recording: &Recording,
    model: &ModelFile,
    ask: impl FnOnce(&[Recording], &Problem<'_>, &Fit) -> T,
) -> T {
    let recordings = std::slice::from_ref(recording);
    let data = Dataset::new(recordings).unwrap();
    let baseline = Baseline::from_model(model, &data).unwrap();
    let problem = Problem::new(&data, &baseline, &[]);
    let fit = fit_baseline(&problem).unwrap();
    ask(recordings, &problem, &fit)
}
