//! The IMU sits on a soft mount: second and fourth row of eq. 9, for a model that has it rigid.
//!
//! The mount replaces the plant's own, so leave that out (`Plant::rigid`) where the model is to be wrong by
//! this effect alone.

use super::{Effect, Entry, Parameter};
use crate::plant::{Mount, Plant};

pub(super) const ENTRY: Entry = Entry {
    id: "imu_mount",
    locus: "sensor",
    parameters: &[
        Parameter { name: "mode_hz", unit: "Hz", range: [3.0, 12.0], signed: false },
        Parameter { name: "zeta", unit: "-", range: [0.02, 0.5], signed: false },
    ],
    moderate_and_strong: [3.34, 3.0],
    near: &[],
    make: |values, _| Box::new(ImuMount(Mount::of_mode(values[0].max(0.1), values[1], INERTIA_KG_M2))),
};

/// J of a small IMU with its plate, kg m².
const INERTIA_KG_M2: f64 = 5e-4;

#[derive(Debug)]
struct ImuMount(Mount);

impl Effect for ImuMount {
    fn plant(&self, _t: f64, plant: &mut Plant) {
        plant.mount = Some(self.0);
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;
    use crate::plant::{Mount, Plant};

    #[test]
    fn it_is_the_mount_of_the_plant() {
        let soft = Setting::new("imu_mount", &[("mode_hz", 5.0), ("zeta", 0.1)]).unwrap();
        let mounted = Plant { mount: Some(Mount::of_mode(5.0, 0.1, 5e-4)), ..FREE };
        let mut concealed = Aircraft::new(FREE, &[soft], None, 0);
        let mut plain = Aircraft::new(mounted, &[], None, 0);
        for k in 0..100 {
            let u = if k / 20 % 2 == 0 { 0.015 } else { -0.015 };
            concealed.advance(u);
            plain.advance(u);
        }
        assert_eq!(concealed.state(), plain.state());
        assert!((concealed.state().theta_p - concealed.state().theta).abs() > 1e-5);
    }
}
