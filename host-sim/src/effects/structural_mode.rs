//! A bending mode of arm or frame, seen by the gyro: η̈ + 2ζω η̇ + ω² η = g (∂M/∂u) ua / Iyy,
//! q_meas = q + η̇, θ_meas = θ + η.

use super::oscillator::Oscillator;
use super::{Effect, Entry, Motion, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "structural_mode",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "gain", unit: "-", range: [0.05, 2.5], signed: true },
        Parameter { name: "omega", unit: "rad/s", range: [10.0, 60.0], signed: false },
        Parameter { name: "zeta", unit: "-", range: [0.01, 0.2], signed: false },
    ],
    moderate_and_strong: [0.81, 0.895],
    near: &[],
    make: |values, _| {
        Box::new(StructuralMode { gain: values[0], mode: Oscillator::new(values[1], values[2]) })
    },
};

#[derive(Debug)]
struct StructuralMode {
    gain: f64,
    mode: Oscillator,
}

impl Effect for StructuralMode {
    fn follow(&mut self, motion: &Motion) {
        let plant = motion.plant;
        self.mode.advance(self.gain * plant.dm_du * motion.blade / plant.inertia_kg_m2, motion.dt);
    }

    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.theta += self.mode.position;
        reading.q += self.mode.velocity;
        reading.q_dot += self.mode.acceleration;
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;

    #[test]
    fn the_gyro_sees_the_closed_form_of_a_step_beside_the_rigid_motion() {
        let (gain, omega, zeta) = (0.5, 20.0, 0.1);
        let mode = Setting::new("structural_mode", &[("gain", gain), ("omega", omega), ("zeta", zeta)]);
        let mut aircraft = Aircraft::new(FREE, &[mode.unwrap()], None, 0);
        (0..30).for_each(|_| aircraft.advance(0.01));
        // the command arrives after 0.06 s
        let t = 0.6 - 0.06;
        let b = 23.0 * 0.01 / 0.1705;
        let damped = omega * (1.0_f64 - zeta * zeta).sqrt();
        let rate = gain * b / damped * (-zeta * omega * t).exp() * (damped * t).sin();
        assert!((aircraft.read().q - (b * t + rate)).abs() < 1e-9);
    }
}
