//! Pitch angle from pitch rate and accelerometer: a complementary filter.
//!
//! ```text
//! θa[k] = atan2(fx, √(fy² + fz²))                                  specific force f, body axes x forward, z down
//! θ[k]  = (1 − κ) (θ[k−1] + Ts (q[k−1] + q[k]) / 2) + κ θa[k]      κ = Ts / T
//! ```
//!
//! θa is left out (κ = 0) while |f| is off 1 g by more than a fifth, for then it is not gravity that is felt. T trades the
//! drift of the gyro (T · bias of steady error) against the accelerations of the machine. On a test-bed that frees only
//! pitch and pivots at the centre of gravity there are none, hence the short T = 1 s.
//!
//! Cost: 12 bytes, 12 operations, one arc tangent, one square root.
//! Source: Mahony, Hamel, Pflimlin, IEEE TAC 53 (2008), in one axis and without the bias estimate.

use estimator_core::constants::SAMPLE_PERIOD_S;

const GRAVITY_M_S2: f32 = 9.806_65;
/// T, s.
const TIME_CONSTANT_S: f32 = 1.0;
const KAPPA: f32 = SAMPLE_PERIOD_S / TIME_CONSTANT_S;

/// What an IMU measures, body axes x forward, y right, z down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Pitch rate q, rad/s.
    pub q_rad_s: f32,
    /// Specific force, m/s²; (0, 0, −9.81) at rest and level.
    pub force_m_s2: [f32; 3],
}

/// The estimate, θ of the last sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PitchFilter {
    last: Option<(f32, f32)>,
}

impl PitchFilter {
    /// θ\[k\], rad; it begins with θa. Not finite where `motion` is not; the next finite sample then begins anew.
    pub fn step(&mut self, motion: &Motion) -> f32 {
        let [x, y, z] = motion.force_m_s2;
        let square = x * x + y * y + z * z;
        let felt = libm::atan2f(x, libm::sqrtf(y * y + z * z));
        let share = square / (GRAVITY_M_S2 * GRAVITY_M_S2);
        let at_rest = (0.64..=1.44).contains(&share);
        let theta = match self.last {
            Some((theta, q)) => {
                let turned = theta + 0.5 * SAMPLE_PERIOD_S * (q + motion.q_rad_s);
                if at_rest { (1.0 - KAPPA) * turned + KAPPA * felt } else { turned }
            }
            None => felt,
        };
        let sound = theta.is_finite() && square.is_finite();
        self.last = sound.then_some((theta, motion.q_rad_s));
        if sound { theta } else { f32::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ahrs::{Ahrs, Mahony};
    use nalgebra::Vector3;

    fn felt(theta: f32) -> [f32; 3] {
        [GRAVITY_M_S2 * theta.sin(), 0.0, -GRAVITY_M_S2 * theta.cos()]
    }

    /// (θ, q) of a swing of 0.3 rad at 3 rad/s.
    fn swing(k: i32) -> (f32, f32) {
        let t = 0.02 * k as f32;
        (0.3 * (3.0 * t).sin(), 0.9 * (3.0 * t).cos())
    }

    #[test]
    fn follows_a_swing_as_the_ahrs_crate_does() {
        let mut filter = PitchFilter::default();
        // its axes: z up at rest, so the force has the other sign in x and z; nose up is a rotation about −y there
        let mut reference = Mahony::new(0.02_f64, 1.0, 0.0);
        let (mut worst, mut apart) = (0.0_f32, 0.0_f32);
        for k in 0..1000 {
            let (theta, q) = swing(k);
            let found = filter.step(&Motion { q_rad_s: q, force_m_s2: felt(theta) });
            let force = felt(theta).map(f64::from);
            let gyro = Vector3::new(0.0, f64::from(q), 0.0);
            let accelerometer = Vector3::new(-force[0], 0.0, -force[2]);
            let attitude = reference.update_imu(&gyro, &accelerometer).unwrap();
            let (_, pitch, _) = attitude.euler_angles();
            if k > 250 {
                worst = worst.max((found - theta).abs());
                apart = apart.max((found - pitch as f32).abs());
            }
        }
        assert!(worst < 0.002, "{worst}");
        assert!(apart < 0.02, "{apart}");
    }

    #[test]
    fn a_gyro_bias_leaves_the_closed_form_error() {
        // θ = θ + Ts b − κ θ in the steady state: θ (1 − (1 − κ)) = (1 − κ) Ts b
        let mut filter = PitchFilter::default();
        let last = (0..2000).map(|_| filter.step(&Motion { q_rad_s: 0.05, force_m_s2: felt(0.0) })).last();
        let expected = (1.0 - KAPPA) * 0.02 * 0.05 / KAPPA;
        assert!((last.unwrap() - expected).abs() < 1e-4);
    }

    #[test]
    fn a_shock_is_not_taken_for_gravity() {
        let mut filter = PitchFilter::default();
        filter.step(&Motion { q_rad_s: 0.0, force_m_s2: felt(0.1) });
        let found = filter.step(&Motion { q_rad_s: 0.0, force_m_s2: [30.0, 0.0, -GRAVITY_M_S2] });
        assert!((found - 0.1).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_number_shows_and_does_not_stay() {
        let mut filter = PitchFilter::default();
        assert!(filter.step(&Motion { q_rad_s: f32::NAN, force_m_s2: felt(0.0) }).is_finite());
        assert!(filter.step(&Motion { q_rad_s: 0.0, force_m_s2: felt(0.0) }).is_nan());
        assert!((filter.step(&Motion { q_rad_s: 0.0, force_m_s2: felt(0.2) }) - 0.2).abs() < 1e-6);
        assert!(filter.step(&Motion { q_rad_s: 0.0, force_m_s2: [f32::INFINITY, 0.0, 0.0] }).is_nan());
    }
}
