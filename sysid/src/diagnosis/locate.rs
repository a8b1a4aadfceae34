//! Where the mismatch is: in which time, in which band, and on which variable the residual moment depends.

use super::answer::Dependence;
use crate::dataset::Place;
use crate::likelihood::evidence::BLOCK_S;
use crate::likelihood::fit::Fit;
use crate::likelihood::fit::weights;
use crate::likelihood::free_run::free_run;
use crate::likelihood::problem::Problem;
use nalgebra::Matrix2;

/// Classes into which a variable is cut for its dependence.
const CLASSES: usize = 12;
/// Samples of the residual moment count as independent about this far apart, s.
const CORRELATION_S: f64 = 0.3;

/// Time windows that hold most of what the extended model gains in likelihood; the whole data set if it is spread.
pub fn time_windows(problem: &Problem<'_>, baseline: &Fit, extended: &Fit) -> Vec<[f64; 2]> {
    const BLOCK_S: f64 = 1.0;
    const MOST_OF_IT: f64 = 0.85;
    const CONCENTRATED: f64 = 0.6;
    let times = counted_times(problem);
    let whole = vec![[times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0)]];
    let gains = gain_by_sample(baseline, extended);
    let mut blocks: Vec<(f64, f64, f64)> = Vec::new();
    for (&t, gain) in times.iter().zip(gains) {
        match blocks.last_mut() {
            Some((from, to, sum)) if t >= *from && t < *from + BLOCK_S => {
                *to = t;
                *sum += gain;
            }
            _ => blocks.push((t, t, gain)),
        }
    }
    let total: f64 = blocks.iter().map(|b| b.2).sum();
    if total <= 0.0 {
        return whole;
    }
    let mut shortest: Option<(usize, usize)> = None;
    for i in 0..blocks.len() {
        let mut sum = 0.0;
        for (j, block) in blocks.iter().enumerate().skip(i) {
            sum += block.2;
            if sum >= MOST_OF_IT * total {
                if shortest.is_none_or(|(a, b)| j - i < b - a) {
                    shortest = Some((i, j));
                }
                break;
            }
        }
    }
    match shortest {
        Some((i, j)) if ((j - i + 1) as f64) < CONCENTRATED * blocks.len() as f64 => {
            vec![[blocks[i].0, blocks[j].1]]
        }
        _ => whole,
    }
}

fn counted_times(problem: &Problem<'_>) -> Vec<f64> {
    let runs = problem.data.runs.iter().zip(&problem.counted);
    runs.flat_map(|(run, counted)| (0..run.len()).filter(|&k| counted[k]).map(|k| run.time(k))).collect()
}

/// What each counted sample adds to 2 log likelihood when the baseline is extended.
fn gain_by_sample(baseline: &Fit, extended: &Fit) -> Vec<f64> {
    let (a, b) = (weights(&baseline.minimum.residuals), weights(&extended.minimum.residuals));
    let offset = a.1 - b.1;
    let square = |w: &Matrix2<f64>, e: &[f64; 2]| {
        w[(0, 0)] * e[0] * e[0] + 2.0 * w[(0, 1)] * e[0] * e[1] + w[(1, 1)] * e[1] * e[1]
    };
    let pairs = baseline.minimum.residuals.iter().zip(&extended.minimum.residuals);
    pairs.map(|(x, y)| offset + square(&a.0, x) - square(&b.0, y)).collect()
}

/// Odds that a model as good as `rival` looks as much worse than `model` by chance: the gain over blocks against its own
/// spread (Vuong, Econometrica 57, 1989).
pub fn indistinct(problem: &Problem<'_>, model: &Fit, rival: &Fit) -> f64 {
    let mut blocks: Vec<((usize, usize), f64)> = Vec::new();
    for ((run, k), gain) in problem.counted_rows().zip(gain_by_sample(rival, model)) {
        let block = (run, (k as f64 * problem.data.runs[run].step / BLOCK_S) as usize);
        match blocks.last_mut() {
            Some((last, sum)) if *last == block => *sum += gain,
            _ => blocks.push((block, gain)),
        }
    }
    let n = blocks.len().max(2) as f64;
    let mean = blocks.iter().map(|b| b.1).sum::<f64>() / n;
    let spread = (blocks.iter().map(|b| (b.1 - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let score = mean * n.sqrt() / spread.max(f64::MIN_POSITIVE);
    0.5 * statrs::function::erf::erfc(score / std::f64::consts::SQRT_2)
}

/// Band [low, high] in rad/s that holds the middle 80 % of the power by which two fits' free runs differ.
pub fn band(problem: &Problem<'_>, baseline: &Fit, extended: &Fit, places: &[Place]) -> Option<[f64; 2]> {
    let run_of = |fit: &Fit| free_run(problem, &problem.unpack(&fit.effects, &fit.minimum.values), places);
    let (a, b) = (run_of(baseline)?, run_of(extended)?);
    let step = problem.sizes.step;
    let longest = places.iter().map(|p| p.rows.len()).max()? as f64 * step;
    let (low, high) = (std::f64::consts::TAU / longest, 0.5 * std::f64::consts::PI / step);
    const POINTS: usize = 80;
    let grid: Vec<f64> =
        (0..POINTS).map(|i| low * (high / low).powf(i as f64 / (POINTS - 1) as f64)).collect();
    let mut power = vec![0.0; POINTS];
    for (a, b) in a.iter().zip(&b) {
        let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        for (power, &omega) in power.iter_mut().zip(&grid) {
            // On a logarithmic grid, a line stands for a width in proportion to its frequency.
            *power += omega * fourier_power(&difference, omega * step);
        }
    }
    let total: f64 = power.iter().sum();
    if total <= 0.0 || !total.is_finite() {
        return None;
    }
    let quantile = |share: f64| {
        let mut sum = 0.0;
        let reached = |p: &f64| {
            sum += p;
            sum >= share * total
        };
        grid[power.iter().position(reached).unwrap_or(POINTS - 1)]
    };
    Some([quantile(0.1), quantile(0.9)])
}

/// |Σ x_k e^{−iωk}|² about the mean, tapered by a sine window.
fn fourier_power(x: &[f64], omega: f64) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let (mut re, mut im) = (0.0, 0.0);
    for (k, x) in x.iter().enumerate() {
        let taper = (std::f64::consts::PI * (k as f64 + 0.5) / n).sin();
        let (sin, cos) = (omega * k as f64).sin_cos();
        re += taper * (x - mean) * cos;
        im -= taper * (x - mean) * sin;
    }
    re * re + im * im
}

/// How the residual moment (the baseline's filtered estimate of the disturbance) depends on each variable, strongest
/// first.
pub fn dependences(problem: &Problem<'_>, baseline: &Fit) -> Vec<Dependence> {
    let mut moment = Vec::new();
    let mut variables = Variables::default();
    let unpacked = problem.unpack(&baseline.effects, &baseline.minimum.values);
    let delay = (unpacked.plant.delay / problem.sizes.step).round() as usize;
    let memory = (CORRELATION_S / problem.sizes.step).ceil() as usize;
    let tracked = problem.track(
        &unpacked,
        |run, k, point| {
            if problem.counted[run][k] {
                let u = &problem.data.runs[run].u;
                let now = u[k.saturating_sub(delay)];
                let before = u[k.saturating_sub(delay + memory)];
                moment.push(unpacked.disturbance.moment(&point.x));
                let (q, theta) = (point.x[0], point.x[2]);
                variables.push([now, now - before, q, theta, problem.data.runs[run].time(k)]);
            }
        },
        &mut |_, _| {},
    );
    if tracked.is_none() {
        return Vec::new();
    }
    let unit = problem.data.input_unit.symbol();
    let independent = moment.len() as f64 * problem.sizes.step / CORRELATION_S;
    let mut all: Vec<Dependence> = variables
        .named(unit)
        .into_iter()
        .map(|(name, unit, values)| dependence(name, unit, &values, &moment, independent))
        .collect();
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

#[derive(Default)]
struct Variables {
    rows: Vec<[f64; 5]>,
}

impl Variables {
    fn push(&mut self, row: [f64; 5]) {
        self.rows.push(row);
    }
    fn named(&self, unit: &str) -> Vec<(&'static str, String, Vec<f64>)> {
        let names = [
            ("u", unit.into()),
            ("u_rate", unit.into()),
            ("q", "rad/s".into()),
            ("theta", "rad".into()),
            ("t", "s".into()),
        ];
        let columns = names.into_iter().enumerate();
        columns.map(|(i, (name, unit))| (name, unit, self.rows.iter().map(|r| r[i]).collect())).collect()
    }
}

/// Correlation ratio of the moment over classes of equal number (Pearson, 1905), less what chance gives.
fn dependence(variable: &str, unit: String, values: &[f64], moment: &[f64], independent: f64) -> Dependence {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
    let n = moment.len().max(1) as f64;
    let mean = moment.iter().sum::<f64>() / n;
    let total = moment.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>();
    let mut between = 0.0;
    let mut classes = Vec::with_capacity(CLASSES);
    for class in order.chunks(order.len().div_ceil(CLASSES).max(1)) {
        let count = class.len() as f64;
        let average = class.iter().map(|&i| moment[i]).sum::<f64>() / count;
        let spread = class.iter().map(|&i| (moment[i] - average).powi(2)).sum::<f64>() / count;
        let error = (spread / (count * independent / n).max(1.0)).sqrt();
        between += count * (average - mean) * (average - mean);
        classes.push([class.iter().map(|&i| values[i]).sum::<f64>() / count, average, error]);
    }
    let chance = (CLASSES - 1) as f64 / independent.max(CLASSES as f64);
    let share = if total > 0.0 { (between / total - chance).clamp(0.0, 1.0) } else { 0.0 };
    Dependence { variable: variable.into(), unit, share, classes }
}

#[cfg(test)]
mod tests;
