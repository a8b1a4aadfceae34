//! What to fly.

use estimator_core::constants::CAMPAIGN_DWELL_S;
use estimator_core::plan::PlanConfig;
use estimator_core::prbs::PrbsConfig;
use estimator_core::supervisor::SupervisorConfig;
use estimator_core::{Config, Section};
use serde::{Deserialize, Serialize};

use crate::air::Air;
use crate::effects::Setting;
use crate::error::Error;
use crate::plant::Plant;
use crate::reading::Others;
use crate::sensors::Noise;

/// How much of the pitch rate nothing in the model causes: a band-passed moment, sized so that the true model,
/// simulated along the recorded input, reaches a given VAF in sections I to III. [`Air`] is the kind of moment; the
/// size is that for the usual one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// No moment at all; only for tests, no vehicle is like that.
    None,
    /// 98 %.
    Clean,
    /// 90 %.
    #[default]
    Lab,
    /// 75 %, as on the paper's vehicle.
    Paper,
}

impl Background {
    /// The VAF of the true model, as a share; none without a moment.
    #[must_use]
    pub const fn explainable(&self) -> Option<f64> {
        match self {
            Self::None => None,
            Self::Clean => Some(0.98),
            Self::Lab => Some(0.90),
            Self::Paper => Some(0.75),
        }
    }
}

/// One test on one aircraft.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Shortest and longest dwell of the excitation, s.
    pub dwell_s: [f32; 2],
    /// Amplitude of the excitation, rad.
    pub amplitude_rad: f32,
    /// Seed of everything random.
    pub seed: u64,
    /// The true plant.
    pub plant: Plant,
    /// What is concealed in it.
    pub effects: Vec<Setting>,
    /// Disturbance that is always there.
    pub background: Background,
    /// Kind of that disturbance.
    pub air: Air,
    /// A section in which that disturbance is so many times as strong.
    pub gusty: Option<(Section, f64)>,
    /// Time before which the effects are not there, s, and the plant from then on; none where they always are.
    pub change: Option<(f64, Plant)>,
    /// The manual reference of section IV as a share of the usual one.
    pub stick: f64,
    /// Spans of time, s, in which that disturbance is so many times as strong.
    pub gusts: Vec<([f64; 2], f64)>,
    /// Noise of the IMU.
    pub noise: Noise,
    /// Whether roll and yaw are logged even where they are clamped, as noise; where they are free they always are.
    pub roll_yaw_logged: bool,
    /// What moves and is logged beside the pitch axis, apart from what the effects need.
    pub others: Others,
    /// Durations of the sections.
    pub plan: PlanConfig,
    /// Limits that the supervisor guards.
    pub supervisor: SupervisorConfig,
}

impl Scenario {
    /// Campaign `number` (1 to 4) of the paper on the nominal plant, nothing concealed, background `Lab`.
    ///
    /// # Errors
    /// No such campaign.
    pub fn campaign(number: usize, amplitude_rad: f32, seed: u64) -> Result<Self, Error> {
        let dwell = number.checked_sub(1).and_then(|i| CAMPAIGN_DWELL_S.get(i));
        let dwell_s = *dwell.ok_or(Error::Campaign { found: number })?;
        Ok(Self {
            dwell_s,
            amplitude_rad,
            seed,
            plant: Plant::nominal(),
            effects: Vec::new(),
            background: Background::default(),
            air: Air::default(),
            gusty: None,
            change: None,
            stick: 1.0,
            gusts: Vec::new(),
            noise: Noise::default(),
            roll_yaw_logged: false,
            others: Others::default(),
            plan: PlanConfig::default(),
            supervisor: SupervisorConfig::default(),
        })
    }

    /// Conceals `effects`. The plant loses its mount where one of them brings a mount of its own.
    pub fn conceal(&mut self, effects: Vec<Setting>) {
        if effects.iter().any(|effect| effect.entry().id == "imu_mount") {
            self.plant = self.plant.rigid();
        }
        self.effects = effects;
    }

    /// Configuration of the core that flies it.
    #[must_use]
    pub fn core(&self) -> Config {
        let [dwell_min_s, dwell_max_s] = self.dwell_s;
        let prbs = PrbsConfig { amplitude_rad: self.amplitude_rad, dwell_min_s, dwell_max_s };
        let (plan, supervisor) = (self.plan, self.supervisor);
        let mut config = Config { seed: self.seed, prbs, plan, supervisor, ..Config::default() };
        let clips = self.effects.iter().any(Setting::clips);
        if clips || self.noise.q_rad_s == 0.0 || self.noise.theta_rad == 0.0 {
            // a sensor looks frozen at the end of its range, and without noise whenever the vehicle rests
            config.supervisor.frozen_samples = 0;
        }
        config
    }
}
