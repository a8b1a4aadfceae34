//! The IMU sits on a soft mount, and the baseline has it rigid.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Effect, Locus, Parameter, Scale};
use crate::model::plant::{Mount, Plant};

/// Inertia that the mount carries, as a share of the airframe's: 5e-4 of 0.1705 kg m². Too small to be estimated.
const CARRIED_SHARE: f64 = 0.003;

/// J q̇P = −k (θP−θ) − c (qP−q), and its reaction on the airframe; k and c from the mode.
pub struct ImuMount;

/// Least frequency of a mount, Hz: by its own weight a softer one sags by more than g/(2π f)² = 4 cm.
const SOFTEST_HZ: f64 = 2.5;
/// Share of the rate of the rows up to which a mode is seen in them.
const SEEN_TO: f64 = 0.45;
/// Damping ratio of the softest rubber (a loss factor of 1.2): a mode that is damped more is a lag.
const MOST_DAMPING: f64 = 0.6;

impl Effect for ImuMount {
    fn about(&self) -> About {
        About {
            id: "imu_mount",
            locus: Locus::Sensor,
            sentence: "the IMU sits on a soft mount",
            equation: "J dqP/dt = -k (thetaP - theta) - c (qP - q)",
            variable: "qdot",
            condition: "as ringing after each switch of the input",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::Resonance)
    }
    fn source(&self) -> Option<&'static str> {
        Some("Riccardi, Panizza and Lovera, 2014")
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter {
                name: "mode_hz",
                unit: "Hz",
                lower: SOFTEST_HZ,
                upper: SEEN_TO / data.step,
                scale: Scale::Log,
            },
            Parameter { name: "zeta", unit: "1", lower: 0.005, upper: MOST_DAMPING, scale: Scale::Log },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let highest = 0.3 / data.step;
        [0.15, 0.3, 0.6].map(|share| vec![(share * highest).max(1.1 * SOFTEST_HZ), 0.2]).to_vec()
    }
    /// An angle alone may be an encoder's: a mount is seen by the gyro on it.
    fn applies(&self, baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate
            && baseline.plant.mount.is_none()
            && data.runs.iter().all(|run| SEEN_TO / run.step > SOFTEST_HZ)
    }
    fn rings(&self, p: &[f64]) -> Option<[f64; 2]> {
        Some([p[0], p[1]])
    }
    fn start_ringing(&self, f_hz: f64, zeta: f64) -> Option<Vec<f64>> {
        Some(vec![f_hz, zeta])
    }
    fn plant(&self, p: &[f64], plant: &mut Plant) {
        plant.mount = Some(Mount::from_mode(p[0], p[1], CARRIED_SHARE * plant.inertia));
    }
}
