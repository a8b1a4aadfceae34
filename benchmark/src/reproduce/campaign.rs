//! One identification campaign: three tests of rising amplitude, flown in the simulator and read back as recordings.

use crate::Error;
use crate::conceal::nominal;
use host_sim::sensors::Noise;
use host_sim::{Background, Plant, Scenario, Setting, fly};
use serde::Serialize;
use sysid::dataset::{Dataset, Place};
use sysid::held_out::Split;
use sysid::model::baseline::Baseline;
use sysid::recording::{ReadOptions, Recording, parse};

/// Amplitudes in the order in which they are joined, rad.
const AMPLITUDES: [f32; 3] = [0.012, 0.015, 0.019];
/// The test that is validated on: its closed loop and its second PRBS.
const VALIDATED: usize = 2;

/// What is flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Condition {
    /// The plant of eq. 9 and white sensor noise.
    Nominal,
    /// The same with servo lag, a band-passed moment and more noise.
    Disturbed,
    /// The same with dry friction, too.
    Realistic,
}

impl Condition {
    /// In words.
    pub fn told(self) -> &'static str {
        match self {
            Self::Nominal => "nominal: eq. 9, noise of 0.02 rad/s",
            Self::Disturbed => "disturbed: servo lag 0.04 s, a coloured moment, noise of 0.08 rad/s",
            Self::Realistic => {
                "realistic: servo lag 0.04 s, friction 0.06 N m, a coloured moment, noise of 0.08 rad/s"
            }
        }
    }

    fn scenario(self, campaign: u8, amplitude: f32, seed: u64) -> Result<Scenario, Error> {
        let plain = Scenario::campaign(campaign.into(), amplitude, seed)?;
        let noise = |q_rad_s| Noise { q_rad_s, theta_rad: 0.005, qdot_rad_s2: 0.5 };
        let mut effects = vec![Setting::new("servo_lag", &[("T", 0.04)])?];
        if self == Self::Realistic {
            effects.push(Setting::new("coulomb_friction", &[("Mc", 0.06)])?);
        }
        Ok(match self {
            Self::Nominal => Scenario { background: Background::None, noise: noise(0.02), ..plain },
            Self::Disturbed | Self::Realistic => Scenario {
                plant: Plant { delay_s: 0.05, ..plain.plant },
                effects,
                background: Background::Paper,
                noise: noise(0.08),
                ..plain
            },
        })
    }
}

/// The data of a campaign, cut as the paper cuts them.
pub struct Campaign {
    /// The recordings, as one data set.
    pub data: Dataset,
    /// Section I of each test to learn from; II and IV of the second to judge by.
    pub split: Split,
    /// The grey box to start from: no knowledge but the inertia and the mount's data sheet.
    pub baseline: Baseline,
    /// Share of the rows to learn from that the supervisor overrode.
    pub supervised: f64,
}

/// Flies the campaign of one seed.
pub fn fly_campaign(condition: Condition, campaign: u8, seed: u64) -> Result<Campaign, Error> {
    let mut recordings: Vec<Recording> = Vec::new();
    for (test, amplitude) in AMPLITUDES.into_iter().enumerate() {
        let scenario = condition.scenario(campaign, amplitude, 10 * seed + test as u64)?;
        let text = fly(&scenario)?.recording();
        recordings.push(parse("simulated test", text.as_bytes(), &ReadOptions::default())?);
    }
    let data = Dataset::new(&recordings)?;
    let places = data.places();
    let of = |keep: &dyn Fn(&str) -> bool| -> Vec<Place> {
        places.iter().filter(|p| keep(&p.label)).cloned().collect()
    };
    let split = Split {
        training: of(&|label| label.ends_with(":I")),
        held_out: of(&|label| label == prbs_label() || label == closed_loop_label()),
    };
    let rows = split.training.iter().flat_map(|p| &data.runs[p.run].supervised[p.rows.clone()]);
    let (count, overridden) =
        rows.fold((0_u32, 0_u32), |(all, some), supervised| (all + 1, some + u32::from(*supervised)));
    let mut model = nominal();
    model.plant.delay_s = None;
    let baseline = Baseline::from_model(&model, &data)?;
    Ok(Campaign { data, split, baseline, supervised: f64::from(overridden) / f64::from(count.max(1)) })
}

/// Label of the closed loop that is validated on.
pub fn closed_loop_label() -> String {
    format!("{VALIDATED}:IV")
}

/// Label of the PRBS that is validated on.
pub fn prbs_label() -> String {
    format!("{VALIDATED}:II")
}
