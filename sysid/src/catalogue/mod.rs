//! The catalogue: physics that a pitch model may leave out, one file each, and shapes for what has no name.

mod angle_lag;
mod angle_skew;
mod asymmetric_friction;
mod asymmetric_servo;
mod asymmetric_thrust;
mod axis_misalignment;
mod clock_skew;
mod cogging;
pub mod command_tells;
mod coulomb_friction;
mod cross_feed;
mod cubic_stiffness;
mod effectiveness_fade;
mod encoder_error;
mod end_stop;
pub mod extra_delay;
pub mod gravity_stiffness;
pub mod gust_disturbance;
mod gyro_bias;
pub(crate) mod gyro_lag;
mod gyro_saturation;
mod gyro_scale;
mod gyroscopic_coupling;
mod hysteresis;
mod imu_mount;
mod inertia_step;
mod inflow_lag;
mod legal;
pub mod linear_stiffness;
mod linkage_backlash;
pub mod model_file;
mod moment_step;
mod over_angle;
mod periodic_moment;
pub mod position_drive;
mod quadratic_drag;
pub mod rest_angle;
pub mod roll_off;
mod rotor_reaction;
pub mod scaled_shape;
mod servo_deadband;
pub(crate) mod servo_lag;
mod servo_rate_limit;
mod servo_saturation;
mod servo_second_order;
pub mod shapes;
pub mod slow_moment;
mod slung_load;
pub(crate) mod spectral_lines;
mod stribeck_friction;
mod structural_mode;
mod thrust_curve;
mod thrust_dependence;
mod thrust_offset;
pub mod trim_offset;
mod unilateral_spring;
mod voltage_droop;

use crate::model::effect::Effect;

/// All effects that a diagnosis tries, in the order of the catalogue.
pub const CATALOGUE: &[&dyn Effect] = &[
    &servo_lag::ServoLag,
    &asymmetric_servo::AsymmetricServo,
    &servo_second_order::ServoSecondOrder,
    &servo_rate_limit::ServoRateLimit,
    &servo_saturation::ServoSaturation,
    &linkage_backlash::LinkageBacklash,
    &servo_deadband::ServoDeadband,
    &trim_offset::TrimOffset,
    &thrust_curve::ThrustCurve,
    &asymmetric_thrust::AsymmetricThrust,
    &inflow_lag::InflowLag,
    &effectiveness_fade::EffectivenessFade,
    &voltage_droop::VoltageDroop,
    &thrust_dependence::ThrustDependence,
    &thrust_offset::ThrustOffset,
    &rotor_reaction::RotorReaction,
    &cross_feed::CrossFeed,
    &coulomb_friction::CoulombFriction,
    &stribeck_friction::StribeckFriction,
    &asymmetric_friction::AsymmetricFriction,
    &hysteresis::Hysteresis,
    &quadratic_drag::QuadraticDrag,
    &gravity_stiffness::GravityStiffness,
    &linear_stiffness::LinearStiffness,
    &position_drive::PositionDrive,
    &cubic_stiffness::CubicStiffness,
    &rest_angle::RestAngle,
    &cogging::Cogging,
    &end_stop::EndStop,
    &unilateral_spring::UnilateralSpring,
    &structural_mode::StructuralMode,
    &slung_load::SlungLoad,
    &gyroscopic_coupling::GyroscopicCoupling,
    &inertia_step::InertiaStep,
    &moment_step::MomentStep,
    &periodic_moment::PeriodicMoment,
    &extra_delay::ExtraDelay,
    &clock_skew::ClockSkew,
    &gyro_bias::GyroBias,
    &gyro_scale::GyroScale,
    &gyro_lag::GyroLag,
    &angle_lag::AngleLag,
    &angle_skew::AngleSkew,
    &encoder_error::EncoderError,
    &gyro_saturation::GyroSaturation,
    &imu_mount::ImuMount,
    &axis_misalignment::AxisMisalignment,
    &gust_disturbance::GustDisturbance,
];

/// The effect with this id.
pub fn find(id: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.about().id == id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::effect::{Amplitudes, Conditions, Locus};

    #[test]
    fn of_a_command_that_goes_as_much_up_as_down_only_what_tells_them_apart_leaves_a_mean() {
        let sizes =
            Amplitudes { step: 0.01, u: 0.02, moment: 0.2, q: 0.3, theta: 0.1, ..Amplitudes::default() };
        for effect in CATALOGUE {
            if effect.about().locus != Locus::Actuator {
                continue;
            }
            for p in effect.starts(&sizes) {
                let mut states = vec![0.0; effect.states()];
                // one period to settle and one to take the mean of
                let answers: Vec<f64> = (0..400)
                    .map(|k| {
                        let u = if k % 200 < 100 { 0.02 } else { -0.02 };
                        let at = Conditions { dt: 0.01, command: u, sizes, ..Conditions::default() };
                        effect.actuate(&p, &mut states, u, &at)
                    })
                    .collect();
                let mean = answers[200..].iter().sum::<f64>() / 200.0;
                assert!(effect.moves_the_mean() || mean.abs() < 1e-4 * 0.02, "{}: {mean}", effect.about().id);
            }
        }
        assert!(asymmetric_servo::AsymmetricServo.moves_the_mean() && !servo_lag::ServoLag.moves_the_mean());
    }

    #[test]
    fn lags_and_sensors_hold_nothing_aside() {
        let ids = ["gravity_stiffness", "asymmetric_friction", "unlisted", "servo_second_order", "gyro_bias"];
        let moves = ids.map(|id| find(id).is_none_or(Effect::moves_the_mean));
        assert_eq!(moves, [true, true, true, false, false]);
    }
}
