//! The catalogue: physics that a pitch model may leave out, one file each, and shapes for what has no name.

mod clock_skew;
mod coulomb_friction;
mod cubic_stiffness;
mod effectiveness_fade;
mod end_stop;
mod extra_delay;
mod gravity_stiffness;
pub mod gust_disturbance;
mod gyro_bias;
mod gyro_lag;
mod gyro_saturation;
mod gyro_scale;
mod gyroscopic_coupling;
mod imu_mount;
mod inertia_step;
mod inflow_lag;
mod linkage_backlash;
pub mod model_file;
mod quadratic_drag;
pub mod roll_off;
pub mod scaled_shape;
mod servo_deadband;
mod servo_lag;
mod servo_rate_limit;
mod servo_saturation;
pub mod shapes;
pub mod slow_moment;
mod structural_mode;
mod thrust_curve;
mod trim_offset;

use crate::model::effect::Effect;

/// All effects that a diagnosis tries, in the order of the catalogue.
pub const CATALOGUE: &[&dyn Effect] = &[
    &servo_lag::ServoLag,
    &servo_rate_limit::ServoRateLimit,
    &servo_saturation::ServoSaturation,
    &linkage_backlash::LinkageBacklash,
    &servo_deadband::ServoDeadband,
    &trim_offset::TrimOffset,
    &thrust_curve::ThrustCurve,
    &inflow_lag::InflowLag,
    &effectiveness_fade::EffectivenessFade,
    &coulomb_friction::CoulombFriction,
    &quadratic_drag::QuadraticDrag,
    &gravity_stiffness::GravityStiffness,
    &cubic_stiffness::CubicStiffness,
    &end_stop::EndStop,
    &structural_mode::StructuralMode,
    &gyroscopic_coupling::GyroscopicCoupling,
    &inertia_step::InertiaStep,
    &extra_delay::ExtraDelay,
    &clock_skew::ClockSkew,
    &gyro_bias::GyroBias,
    &gyro_scale::GyroScale,
    &gyro_lag::GyroLag,
    &gyro_saturation::GyroSaturation,
    &imu_mount::ImuMount,
    &gust_disturbance::GustDisturbance,
];

/// The effect with this id.
pub fn find(id: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.about().id == id)
}
