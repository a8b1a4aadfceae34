//! One simulated vehicle of the study: identified once, then flown.

use crate::Error;
use estimator_core::monitor::Cause;
use estimator_core::plan::PlanConfig;
use host_sim::seeds::{Stream, generator};
use host_sim::{Background, Plant, Scenario, Setting, air_of, fly, fly_in};
use rand::RngExt;
use serde::Serialize;
use sysid::dataset::Dataset;
use sysid::monitor::{Design, design};
use sysid::recording::{ReadOptions, parse};

/// The air in which a vehicle is identified and flown.
pub const AIRS: [Background; 3] = [Background::Clean, Background::Lab, Background::Paper];
/// By how much the plants differ from the nominal one.
const SPREAD: f64 = 0.25;

/// A vehicle with the monitor that was made from its identification.
pub struct Vehicle {
    /// The flight that it was identified from.
    identification: Scenario,
    /// The monitor, with the errors that such an identification has.
    pub design: Design,
    /// The same from sixteen times as long an excitation: next to no errors.
    pub exact: Design,
}

/// What changes in a flight, and by how much.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Alteration {
    /// What changes.
    pub kind: Kind,
    /// By how much, in the unit of the kind.
    pub size: f64,
}

/// What can change in a flight.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// ∂M/∂u, share.
    Effectiveness,
    /// A servo lag, s.
    Lag,
    /// A delay, s.
    Delay,
    /// A constant moment, N m.
    Trim,
    /// Damping, N m s/rad.
    Damping,
    /// Dry friction, N m.
    Friction,
    /// rad/s.
    GyroBias,
    /// Share.
    GyroScale,
}

impl Alteration {
    /// The cause that it is, and its size in the monitor's units: moments per unit inertia.
    #[must_use]
    pub fn truth(self, inertia: f64) -> (Cause, f64) {
        let Self { kind, size } = self;
        match kind {
            Kind::Effectiveness => (Cause::Effectiveness, size),
            Kind::Lag | Kind::Delay => (Cause::Lag, size),
            Kind::Trim => (Cause::Trim, size / inertia),
            Kind::Damping => (Cause::Damping, size / inertia),
            Kind::Friction => (Cause::Friction, size / inertia),
            Kind::GyroBias => (Cause::GyroBias, size),
            Kind::GyroScale => (Cause::GyroScale, size),
        }
    }
}

impl Vehicle {
    /// The vehicle of a seed in one of the [`AIRS`].
    ///
    /// # Errors
    /// None but what the simulator and the identification refuse.
    pub fn new(seed: u64, air: Background) -> Result<Self, Error> {
        let mut random = generator(seed, Stream::Plant);
        let mut about = |nominal: f64| nominal * (1.0 + SPREAD * (2.0 * random.random::<f64>() - 1.0));
        let nominal = Plant::nominal();
        let plant = Plant {
            dm_dq: about(nominal.dm_dq),
            dm_du: about(nominal.dm_du),
            delay_s: about(nominal.delay_s),
            ..nominal
        };
        let identification = Scenario { plant, background: air, ..Scenario::campaign(4, 0.015, seed)? };
        let longer = PlanConfig { section_s: 400.0, ..identification.plan };
        let exact = Scenario { plan: longer, ..identification.clone() };
        let design_of = |scenario: &Scenario| -> Result<Design, Error> {
            let text = fly_in(scenario, air_of(&identification)?)?.recording();
            Ok(design(&[parse("identification", text.as_bytes(), &ReadOptions::default())?], None)?)
        };
        let text = fly(&identification)?.recording();
        let found = design(&[parse("identification", text.as_bytes(), &ReadOptions::default())?], None)?;
        Ok(Self { design: found, exact: design_of(&exact)?, identification })
    }

    /// Iyy, kg m².
    #[must_use]
    pub fn inertia(&self) -> f64 {
        self.identification.plant.inertia_kg_m2
    }

    /// An ordinary flight of `seconds`: the loop closed, the stick at `stick` of the usual, the air that of the identification.
    pub fn ordinary(&self, seed: u64, seconds: f32, stick: f64) -> Result<Scenario, Error> {
        let plan = if stick > 0.0 {
            PlanConfig { lead_in_s: 0.0, section_s: 0.02, pause_s: 0.0, closed_loop_s: seconds }
        } else {
            PlanConfig { lead_in_s: 0.0, section_s: seconds, pause_s: 0.0, closed_loop_s: 0.02 }
        };
        let plain = Scenario::campaign(4, 0.015, seed)?;
        Ok(Scenario { plan, plant: self.identification.plant, stick, ..plain })
    }

    /// Lets something change at `at_s`.
    pub fn alter(scenario: &mut Scenario, alteration: Alteration, at_s: f64) -> Result<(), Error> {
        let mut plant = scenario.plant;
        let Alteration { kind, size } = alteration;
        let effect = match kind {
            Kind::Effectiveness => {
                plant.dm_du *= 1.0 + size;
                None
            }
            Kind::Damping => {
                plant.dm_dq -= size;
                None
            }
            Kind::Delay => {
                plant.delay_s += size;
                None
            }
            Kind::Lag => Some(("servo_lag", "T")),
            Kind::Trim => Some(("trim_offset", "M0")),
            Kind::Friction => Some(("coulomb_friction", "Mc")),
            Kind::GyroBias => Some(("gyro_bias", "b")),
            Kind::GyroScale => Some(("gyro_scale", "s")),
        };
        let effect = effect.map(|(id, name)| Setting::new(id, &[(name, size)])).transpose()?;
        scenario.effects = effect.into_iter().collect();
        scenario.change = Some((at_s, plant));
        Ok(())
    }

    /// What the flight logged, as the monitor is given it.
    pub fn fly(&self, scenario: &Scenario) -> Result<Dataset, Error> {
        let text = fly_in(scenario, air_of(&self.identification)?)?.recording();
        Ok(Dataset::new(&[parse("flight", text.as_bytes(), &ReadOptions::default())?])?)
    }
}
