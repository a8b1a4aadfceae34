//! Typical sizes of the signals of a data set.

use super::{Dataset, Run};

/// Autocorrelation below which samples count as other ones.
const DECORRELATED: f64 = 0.8;

/// Samples until the autocorrelation of the rate falls below 0.8.
pub fn decorrelation(rates: &[Vec<f64>]) -> usize {
    let at = |lag: usize| -> f64 {
        rates.iter().map(|r| r.iter().zip(r.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>()).sum()
    };
    let power = at(0);
    let longest = rates.iter().map(Vec::len).max().unwrap_or(1);
    (1..longest.min(1000)).find(|&lag| at(lag) < DECORRELATED * power).unwrap_or(1)
}

/// Typical sizes of the signals of a data set: what parameters' ranges and starts are scaled with.
#[derive(Clone, Copy, Debug, Default)]
pub struct Amplitudes {
    /// Moment of inertia, kg m²; 1 where moments are given per unit of it.
    pub inertia: f64,
    /// Standard deviation of the input, its unit.
    pub u: f64,
    /// Standard deviation of the pitch rate, rad/s.
    pub q: f64,
    /// Standard deviation of the pitch angle, rad.
    pub theta: f64,
    /// From the least pitch angle to the largest, rad.
    pub turned: f64,
    /// Lower and upper quartile and largest size of the measured pitch angle, rad; zeros where none was measured.
    pub angles: [f64; 3],
    /// Standard deviation of the control moment ∂M/∂u·u, N m.
    pub moment: f64,
    /// Moment that would move the rate as it moves, N m.
    pub moves: f64,
    /// Sample period, s.
    pub step: f64,
    /// End of the last sample since the start of its recording, s.
    pub duration: f64,
    /// Reading at which the rate clips, rad/s, where it shows in all that was logged.
    pub rate_limit: Option<f64>,
}

impl Amplitudes {
    /// The larger of the control moment and that which moves the rate as it moves, N m: a pendulum that swings by itself is moved by
    /// more than the command.
    #[must_use]
    pub fn acting(&self) -> f64 {
        self.moment.max(self.moves)
    }
}

impl Dataset {
    /// Typical sizes of the signals of a plant of `inertia` kg m² and `dm_du` N m per unit of the input. Where the input stands still
    /// for most of the time, moment and input are those that would move the rate as it moves.
    pub fn amplitudes(&self, inertia: f64, dm_du: f64) -> Amplitudes {
        let u = deviation(self.runs.iter().map(|r| r.u.as_slice()));
        let step = self.runs.first().map_or(0.02, |r| r.step);
        let rate: Vec<Vec<f64>> = self.runs.iter().map(Run::rate_or_slope).collect();
        let angle: Vec<Vec<f64>> = self.runs.iter().map(Run::angle_or_sum).collect();
        let q = deviation(rate.iter().map(Vec::as_slice));
        let theta = deviation(angle.iter().map(Vec::as_slice));
        let all = angle.iter().flatten();
        let (least, largest) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &angle| {
            (low.min(angle), high.max(angle))
        });
        let turned = (largest - least).max(0.0);
        let angles = self.angles();
        let duration = self.runs.iter().map(|run| run.elapsed(run.len())).fold(step, f64::max);
        let rate_limit =
            self.runs.iter().map(|run| run.rate_limit).reduce(f64::max).filter(|l| l.is_finite());
        let quickness = DECORRELATED.acos() / (decorrelation(&rate) as f64 * step);
        let moves = (inertia * q * quickness).max(f64::MIN_POSITIVE);
        let [u, moment] = if self.input_goes_on() {
            [u, (dm_du * u).abs().max(f64::MIN_POSITIVE)]
        } else {
            [moves / dm_du.abs().max(f64::MIN_POSITIVE), moves]
        };
        Amplitudes { inertia, u, q, theta, turned, angles, moment, moves, step, duration, rate_limit }
    }

    fn angles(&self) -> [f64; 3] {
        let mut angles: Vec<f64> =
            self.runs.iter().filter_map(|run| run.angle.as_deref()).flatten().copied().collect();
        if angles.is_empty() {
            return [0.0; 3];
        }
        let mut quartile = |share: f64| {
            let place = (share * (angles.len() - 1) as f64) as usize;
            *angles.select_nth_unstable_by(place, f64::total_cmp).1
        };
        let quartiles = [quartile(0.25), quartile(0.75)];
        let largest = angles.iter().fold(0.0, |largest: f64, angle| largest.max(angle.abs()));
        [quartiles[0], quartiles[1], largest]
    }
}

/// Standard deviation over all pieces, each about its own mean; a tiny positive number for a signal that never moves.
fn deviation<'a>(pieces: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for piece in pieces {
        let mean = piece.iter().sum::<f64>() / piece.len().max(1) as f64;
        sum += piece.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        count += piece.len();
    }
    (sum / count.max(1) as f64).sqrt().max(1e-12)
}
