//! Attitude controller: recoveries, pauses between the sections, section IV.
//!
//! ```text
//! e[k] = θref[k] − θ[k]
//! v[k] = Kp e[k] − Kd q[k] + z[k]            u[k] = clamp(v[k], −umax, umax)
//! z[k+1] = clamp(z[k] + Ki Ts e[k], −umax, umax)  unless v is beyond ±umax and e would drive it further
//! ```
//!
//! u collective difference, rad; θ pitch, rad; q pitch rate, rad/s. Positive u raises the nose (∂M/∂u > 0).
//! The rate acts on the measurement alone, so a step of the reference does not kick. The integrator z is the
//! trim; it is kept while the controller is off.
//!
//! Gains: the nominal plant θ/u = 135 e^(−0.07 s) / (s (s + 1.58)) (∂M/∂u / Iyy = 23 / 0.1705, −∂M/∂q / Iyy,
//! delay 0.06 s and half a sample of hold) is given ωn = 2.85 rad/s, ζ = 1: Kp = ωn² / 135 = 0.06,
//! Kd = (2 ζ ωn − 1.58) / 135 = 0.031. Gain crossover 4.3 rad/s, phase margin 69°, which bears 0.28 s of
//! further delay. Ki = Kp / 5 s removes a steady moment and costs 1° at the crossover. Chosen by experiment,
//! the best of nine tunings on 120 simulated vehicles (∂M/∂q, ∂M/∂u ±30 %, 0.11 s of servo lag or 0.09 s of extra
//! delay, strongest excitation and disturbance). On 120 others 1 test was aborted, for a recovery beyond 5 s; with
//! Kp = 0.09, Kd = 0.03 (ζ = 0.8) 18 were.
//!
//! Cost: 4 bytes of state, 5 multiplications.

use crate::config_error::{ConfigError, within};
use crate::constants::SAMPLE_PERIOD_S;

/// Gains and limits in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeConfig {
    /// Kp, rad of command per rad of attitude error, 0 to 10.
    pub angle_gain: f32,
    /// Ki, 1/s, 0 to 10.
    pub integral_gain_per_s: f32,
    /// Kd, s, 0 to 10.
    pub rate_gain_s: f32,
    /// Output limit umax, rad, 0 to 0.2.
    pub output_limit_rad: f32,
    /// Largest reference that section IV follows, rad, 0 to 1; beyond it the reference is clipped.
    pub reference_limit_rad: f32,
}

impl Default for AttitudeConfig {
    fn default() -> Self {
        Self {
            angle_gain: 0.06,
            integral_gain_per_s: 0.012,
            rate_gain_s: 0.031,
            output_limit_rad: 0.04,
            reference_limit_rad: 0.3,
        }
    }
}

impl AttitudeConfig {
    pub(crate) fn build(&self) -> Result<Attitude, ConfigError> {
        within("attitude.angle_gain", "", self.angle_gain, [0.0, 10.0])?;
        within("attitude.integral_gain_per_s", "1/s", self.integral_gain_per_s, [0.0, 10.0])?;
        within("attitude.rate_gain_s", "s", self.rate_gain_s, [0.0, 10.0])?;
        within("attitude.output_limit_rad", "rad", self.output_limit_rad, [0.0, 0.2])?;
        within("attitude.reference_limit_rad", "rad", self.reference_limit_rad, [0.0, 1.0])?;
        Ok(Attitude { config: *self })
    }
}

/// Controller, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attitude {
    config: AttitudeConfig,
}

/// What the controller remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AttitudeState {
    /// Integrator z, rad.
    pub trim_rad: f32,
}

impl Attitude {
    /// The reference that the controller follows for a wish of `theta_ref_rad`: clipped, and level if it is no
    /// number.
    #[must_use]
    pub fn reference(&self, theta_ref_rad: f32) -> f32 {
        let limit = self.config.reference_limit_rad;
        if theta_ref_rad.is_finite() { theta_ref_rad.max(-limit).min(limit) } else { 0.0 }
    }

    /// u\[k\] in rad for a finite θ\[k\] (rad) and q\[k\] (rad/s).
    pub fn step(&self, state: &mut AttitudeState, reference_rad: f32, theta_rad: f32, q_rad_s: f32) -> f32 {
        let AttitudeConfig { angle_gain, integral_gain_per_s, rate_gain_s, output_limit_rad: limit, .. } =
            self.config;
        let error = reference_rad - theta_rad;
        let wanted = angle_gain * error - rate_gain_s * q_rad_s + state.trim_rad;
        let driven_further = wanted.abs() > limit && wanted * error > 0.0;
        if !driven_further {
            let trim = state.trim_rad + integral_gain_per_s * SAMPLE_PERIOD_S * error;
            state.trim_rad = trim.max(-limit).min(limit);
        }
        wanted.max(-limit).min(limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nominal airframe with a moment `trim` (rad/s²), delay of three samples: (θ, largest |u|) after `ticks`.
    fn close_the_loop(
        mut theta: f32,
        mut q: f32,
        reference: f32,
        trim: f32,
        ticks: usize,
    ) -> (f32, f32, f32) {
        let attitude = AttitudeConfig::default().build().unwrap();
        let mut state = AttitudeState::default();
        let mut line = [0.0_f32; 4];
        let (mut largest, mut peak) = (0.0_f32, theta);
        for _ in 0..ticks {
            line.rotate_right(1);
            line[0] = attitude.step(&mut state, reference, theta, q);
            largest = largest.max(line[0].abs());
            for _ in 0..20 {
                q += 1e-3 * (-1.583 * q + 134.9 * line[3] + trim);
                theta += 1e-3 * q;
            }
            peak = peak.max(theta);
        }
        (theta, largest, peak)
    }

    #[test]
    fn recovers_from_the_limit_within_two_seconds() {
        let (theta, largest, peak) = close_the_loop(0.4, 0.8, 0.0, 0.0, 100);
        assert!(theta.abs() < 0.05, "{theta}");
        assert!(largest <= 0.04);
        assert!(peak < 0.65, "{peak}");
    }

    #[test]
    fn a_steady_moment_leaves_no_steady_error() {
        let (theta, ..) = close_the_loop(0.0, 0.0, 0.2, 0.3, 1500);
        assert!((theta - 0.2).abs() < 1e-3, "{theta}");
    }

    #[test]
    fn a_step_of_the_reference_overshoots_by_less_than_a_quarter() {
        let (_, _, peak) = close_the_loop(0.0, 0.0, 0.2, 0.0, 400);
        assert!(peak < 0.25, "{peak}");
    }

    #[test]
    fn the_integrator_does_not_wind_up() {
        let attitude = AttitudeConfig::default().build().unwrap();
        let mut state = AttitudeState::default();
        for _ in 0..5000 {
            assert_eq!(attitude.step(&mut state, 0.3, -3.0, 0.0), 0.04);
        }
        assert_eq!(state.trim_rad, 0.0);
    }

    /// Gains of 1 and a limit of 1/8: all values are exact.
    fn of_ones() -> Attitude {
        let config = AttitudeConfig {
            angle_gain: 1.0,
            integral_gain_per_s: 1.0,
            rate_gain_s: 1.0,
            output_limit_rad: 0.125,
            reference_limit_rad: 1.0,
        };
        config.build().unwrap()
    }

    #[test]
    fn the_integrator_rests_only_beyond_the_limit_and_outward() {
        let moved = |theta_rad, q_rad_s| {
            let mut state = AttitudeState::default();
            (of_ones().step(&mut state, 0.0, theta_rad, q_rad_s), state.trim_rad)
        };
        assert_eq!(moved(-0.125, 0.0), (0.125, 0.125 * SAMPLE_PERIOD_S), "on the limit");
        assert_eq!(moved(-0.125_f32.next_up(), 0.0), (0.125, 0.0));
        assert_eq!(moved(0.125_f32.next_up(), 0.0), (-0.125, 0.0));
        // beyond the limit by the rate alone, and the angle asks for less
        assert_eq!(moved(0.25, -1.0), (0.125, -0.25 * SAMPLE_PERIOD_S));
    }

    #[test]
    fn the_trim_ends_at_the_limit_of_the_output() {
        for side in [-1.0, 1.0] {
            let mut state = AttitudeState::default();
            // the rate takes the angle's part away: the command is the trim
            (0..200).for_each(|_| {
                of_ones().step(&mut state, 0.0, -0.5 * side, 0.5 * side);
            });
            assert_eq!(state.trim_rad, 0.125 * side);
        }
    }

    #[test]
    fn the_reference_is_clipped() {
        let attitude = AttitudeConfig::default().build().unwrap();
        assert_eq!(attitude.reference(7.0), 0.3);
        assert_eq!(attitude.reference(f32::NAN), 0.0);
    }
}
