//! Coloured moments, on a grid of 1 ms that hangs on the seed alone.
//!
//! * Band-passed: m = 2ζω s / (s² + 2ζω s + ω²) n. With n white of intensity S the variance is σ² = ζ ω S. It
//!   has no power at zero frequency and falls off on both sides, so no first-order model describes it.
//! * Three poles: m = 2ζω s / (s² + 2ζω s + ω²) · c / (s + c) n, so with power ∝ w² / ((ω² − w²)² + (2ζω w)²) ·
//!   c² / (w² + c²) at the frequency w. The low pass leaves the share c² / (ω² + 2ζω c + c²) of the band-passed
//!   moment's variance, which is scaled back to σ². It falls off with w⁻⁴, where the band-passed moment does with w⁻².
//! * First order: T ṁ = −m + n, exactly discretised; variance σ².
//!
//! Either may wander in strength: times g, drawn anew every 0.5 s, g the modulus of Student's t with 5 degrees of
//! freedom over √(5/3). The variance of that t is 5/3, so that over a long record it is σ² again; E g⁴ = 9.
//!
//! The grid does not depend on plant, delay or effects, so two flights with the same seed meet the same moment.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

const GRID_S: f64 = 1e-3;
/// Points of the grid over which a wandering strength stays the same: 0.5 s.
const WINDOW: usize = 500;
/// Degrees of freedom of Student's t that a wandering strength is drawn from.
const FREEDOM: u32 = 5;

/// Spectrum of a moment of unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Colour {
    /// Centre ω (rad/s) and damping ratio ζ.
    BandPass {
        /// ω, rad/s.
        omega: f64,
        /// ζ.
        zeta: f64,
    },
    /// The band pass and one more pole: centre ω, damping ratio ζ, corner c of the low pass.
    ThreePoles {
        /// ω, rad/s.
        omega: f64,
        /// ζ.
        zeta: f64,
        /// c, rad/s.
        corner: f64,
    },
    /// Time constant T, s.
    FirstOrder {
        /// T, s.
        time_constant_s: f64,
    },
}

/// A moment over time.
#[derive(Clone, Debug)]
pub struct ColouredMoment {
    sigma: f64,
    colour: Colour,
    generator: Pcg64,
    strength: Strength,
    value: f64,
    passed: f64,
    integral: f64,
    grid: Vec<f64>,
}

/// Factor on a moment.
#[derive(Clone, Debug)]
enum Strength {
    /// One for all time.
    Steady,
    /// Drawn anew every half second.
    Wandering { generator: Pcg64, now: f64 },
}

impl Strength {
    /// The factor at `place` of the grid; every place is to be asked for once, in turn.
    fn at(&mut self, place: usize) -> f64 {
        match self {
            Self::Steady => 1.0,
            Self::Wandering { generator, now } => {
                if place.is_multiple_of(WINDOW) {
                    *now = student(generator).abs() / (f64::from(FREEDOM) / f64::from(FREEDOM - 2)).sqrt();
                }
                *now
            }
        }
    }
}

/// One draw of Student's t: z / √(Σ zᵢ² / ν) with ν + 1 standard normals.
fn student(generator: &mut Pcg64) -> f64 {
    let mut draw = || -> f64 { StandardNormal.sample(generator) };
    let numerator = draw();
    let squares: f64 = (0..FREEDOM).map(|_| draw().powi(2)).sum();
    numerator / (squares / f64::from(FREEDOM)).sqrt()
}

impl ColouredMoment {
    /// Moment of standard deviation `sigma` (N m), at rest at t = 0.
    #[must_use]
    pub const fn new(sigma: f64, colour: Colour, generator: Pcg64) -> Self {
        let strength = Strength::Steady;
        Self { sigma, colour, generator, strength, value: 0.0, passed: 0.0, integral: 0.0, grid: Vec::new() }
    }

    /// The same moment with a strength that wanders, drawn from `generator`.
    #[must_use]
    pub fn wandering(self, generator: Pcg64) -> Self {
        Self { strength: Strength::Wandering { generator, now: 1.0 }, ..self }
    }

    /// Makes sure that the moment is known up to `t_s`.
    pub fn extend_to(&mut self, t_s: f64) {
        let wanted = (t_s / GRID_S) as usize + 2;
        while self.grid.len() < wanted {
            let strength = self.strength.at(self.grid.len());
            self.grid.push(self.sigma * strength * self.value);
            let noise: f64 = StandardNormal.sample(&mut self.generator);
            match self.colour {
                Colour::BandPass { omega, zeta } => self.value = self.band_passed(omega, zeta, noise),
                Colour::ThreePoles { omega, zeta, corner } => {
                    let passed = self.band_passed(omega, zeta, noise);
                    let left =
                        corner.powi(2) / (omega.powi(2) + 2.0 * zeta * omega * corner + corner.powi(2));
                    self.value += (1.0 - (-GRID_S * corner).exp()) * (passed / left.sqrt() - self.value);
                }
                Colour::FirstOrder { time_constant_s } => {
                    let keep = (-GRID_S / time_constant_s).exp();
                    self.value = keep * self.value + (1.0 - keep * keep).sqrt() * noise;
                }
            }
        }
    }

    /// The next value of the band-passed moment of unit variance.
    fn band_passed(&mut self, omega: f64, zeta: f64, noise: f64) -> f64 {
        let bandwidth = 2.0 * zeta * omega;
        // intensity 1 / (ζω) gives unit variance
        let kick = bandwidth * noise * (GRID_S / (zeta * omega)).sqrt();
        self.passed += GRID_S * (-bandwidth * self.passed - omega * omega * self.integral) + kick;
        self.integral += GRID_S * self.passed;
        self.passed
    }

    /// The moment at `t_s`, N m, interpolated; 0 beyond what [`Self::extend_to`] has made.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let place = (t_s / GRID_S).max(0.0);
        let index = place as usize;
        let share = place - index as f64;
        match (self.grid.get(index), self.grid.get(index + 1)) {
            (Some(a), Some(b)) => a + share * (b - a),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, generator};

    fn moment(colour: Colour) -> ColouredMoment {
        let mut moment = ColouredMoment::new(0.2, colour, generator(1, Stream::Background));
        moment.extend_to(2000.0);
        moment
    }

    fn autocorrelation(moment: &ColouredMoment, lag_s: f64) -> f64 {
        let lag = (lag_s / GRID_S) as usize;
        let n = moment.grid.len() - lag;
        (0..n).map(|i| moment.grid[i] * moment.grid[i + lag]).sum::<f64>() / n as f64
    }

    #[test]
    fn the_band_passed_moment_has_its_variance_and_its_autocorrelation() {
        let (omega, zeta) = (5.0_f64, 0.4_f64);
        let m = moment(Colour::BandPass { omega, zeta });
        let variance = autocorrelation(&m, 0.0);
        // 2000 s are about 2 ζ ω · 2000 = 8000 independent values
        assert!((variance.sqrt() / 0.2 - 1.0).abs() < 0.05);
        // e^(−ζω t) (cos ωd t − ζ/√(1−ζ²) sin ωd t): negative at half a period, which no first-order moment is
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        for lag in [0.1_f64, 0.3, 0.6] {
            let (sine, cosine) = (damped * lag).sin_cos();
            let expected = (-zeta * omega * lag).exp() * (cosine - zeta / (1.0 - zeta * zeta).sqrt() * sine);
            assert!((autocorrelation(&m, lag) / variance - expected).abs() < 0.06, "{lag}");
        }
    }

    /// Autocorrelation over a lag of the moment of three poles, by the integral over its spectrum.
    fn of_three_poles(omega: f64, zeta: f64, corner: f64, lag_s: f64) -> f64 {
        let power = |w: f64| {
            let band = w.powi(2) / ((omega.powi(2) - w.powi(2)).powi(2) + (2.0 * zeta * omega * w).powi(2));
            band / (w.powi(2) + corner.powi(2))
        };
        let over = |f: &dyn Fn(f64) -> f64| (0..100_000).map(|i| f(0.01 * f64::from(i))).sum::<f64>();
        over(&|w| power(w) * (w * lag_s).cos()) / over(&power)
    }

    #[test]
    fn the_moment_of_three_poles_has_its_variance_and_its_autocorrelation() {
        let (omega, zeta, corner) = (5.0_f64, 0.4_f64, 7.5_f64);
        let m = moment(Colour::ThreePoles { omega, zeta, corner });
        let variance = autocorrelation(&m, 0.0);
        assert!((variance.sqrt() / 0.2 - 1.0).abs() < 0.05);
        for lag in [0.1, 0.3, 0.6] {
            let expected = of_three_poles(omega, zeta, corner, lag);
            assert!((autocorrelation(&m, lag) / variance - expected).abs() < 0.06, "{lag}");
        }
    }

    #[test]
    fn the_third_pole_makes_the_moment_smooth() {
        let (omega, zeta, corner) = (5.0, 0.4, 7.5);
        // mean square of what a moment changes by over a time: it grows with the time where the spectrum falls off
        // with w⁻², and with its square where it does with w⁻⁴
        let growth = |colour| {
            let m = moment(colour);
            let change = |lag| autocorrelation(&m, 0.0) - autocorrelation(&m, lag);
            change(0.02) / change(0.01)
        };
        let [two, three] = [Colour::BandPass { omega, zeta }, Colour::ThreePoles { omega, zeta, corner }];
        assert!((growth(two) - 2.0).abs() < 0.15, "{}", growth(two));
        assert!((growth(three) - 4.0).abs() < 0.15, "{}", growth(three));
    }

    fn wandering(sigma: f64, seed: u64) -> ColouredMoment {
        let colour = Colour::BandPass { omega: 5.0, zeta: 0.4 };
        ColouredMoment::new(sigma, colour, generator(seed, Stream::Background))
            .wandering(generator(seed, Stream::Strength))
    }

    #[test]
    fn a_wandering_strength_is_that_of_students_t_every_half_second() {
        let mut wanders = wandering(0.2, 1);
        wanders.extend_to(4000.0);
        let mut steady = ColouredMoment { strength: Strength::Steady, grid: Vec::new(), ..wandering(0.2, 1) };
        steady.extend_to(4000.0);
        let windows = wanders.grid.chunks_exact(WINDOW).zip(steady.grid.chunks_exact(WINDOW));
        let mut strengths: Vec<f64> = windows
            .map(|(wanders, steady)| {
                let factor = wanders[100] / steady[100];
                assert!(wanders.iter().zip(steady).all(|(a, b)| (a - factor * b).abs() < 1e-12));
                factor
            })
            .collect();
        let n = strengths.len() as f64;
        assert!((strengths.iter().map(|g| g * g).sum::<f64>() / n - 1.0).abs() < 0.1);
        strengths.sort_by(f64::total_cmp);
        // quantiles of |t| with 5 degrees of freedom: 50 %, 90 %, 99 %
        for (share, t) in [(0.5, 0.7267), (0.9, 2.0150), (0.99, 4.0321)] {
            let found = strengths[(share * n) as usize] * (5.0_f64 / 3.0).sqrt();
            assert!((found / t - 1.0).abs() < 0.1, "{share}: {found}");
        }
    }

    #[test]
    fn a_wandering_moment_has_its_variance_and_heavy_tails_over_half_a_second() {
        let mut heavy = wandering(0.2, 1);
        heavy.extend_to(4000.0);
        let mut plain = ColouredMoment { strength: Strength::Steady, grid: Vec::new(), ..wandering(0.2, 1) };
        plain.extend_to(4000.0);
        assert!((autocorrelation(&heavy, 0.0).sqrt() / 0.2 - 1.0).abs() < 0.1);
        // kurtosis of the means of windows: 3 of the normal, 27 of a normal times this t, in short records less
        let kurtosis = |moment: &ColouredMoment| {
            let mean = |window: &[f64]| window.iter().sum::<f64>() / window.len() as f64;
            let power = |p| {
                let windows = moment.grid.chunks_exact(WINDOW);
                windows.map(|window| mean(window).powi(p)).sum::<f64>() / (moment.grid.len() / WINDOW) as f64
            };
            power(4) / power(2).powi(2)
        };
        assert!((kurtosis(&plain) - 3.0).abs() < 0.4, "{}", kurtosis(&plain));
        assert!(kurtosis(&heavy) > 9.0, "{}", kurtosis(&heavy));
    }

    #[test]
    fn the_moment_does_not_hang_on_how_it_is_asked_for() {
        let (mut at_once, mut in_ticks) = (wandering(0.2, 7), wandering(0.4, 7));
        at_once.extend_to(20.0);
        (1..=1000).for_each(|tick| in_ticks.extend_to(0.02 * f64::from(tick)));
        for k in 0..1999 {
            let t = 0.01 * f64::from(k);
            assert_eq!(2.0 * at_once.at(t), in_ticks.at(t), "{t}");
        }
    }

    #[test]
    fn the_first_order_moment_decays_with_its_time_constant() {
        let m = moment(Colour::FirstOrder { time_constant_s: 0.5 });
        let variance = autocorrelation(&m, 0.0);
        assert!((variance.sqrt() / 0.2 - 1.0).abs() < 0.08);
        assert!((autocorrelation(&m, 0.5) / variance - (-1.0_f64).exp()).abs() < 0.08);
    }
}
