//! The monitor beside the core: fed with what each cycle measured and sent while the vehicle is armed, off without a model.

use estimator_core::Telemetry;
use estimator_core::monitor::{
    Monitor, MonitorConfig, MonitorModel, MonitorReport, MonitorState, Observation,
};

/// The monitor and how far it has got.
#[derive(Clone, Default)]
pub struct Watch {
    monitor: Option<Monitor>,
    state: MonitorState,
}

impl Watch {
    /// Begins anew with `model`; off without one, where nothing is watched for, and where `config` is not legal.
    #[inline(never)]
    pub fn begin(&mut self, config: &MonitorConfig, model: Option<&MonitorModel>) {
        self.monitor = model.filter(|_| config.watched != 0).and_then(|model| config.build(model).ok());
        self.state.reset();
    }

    /// One cycle of an armed vehicle.
    #[inline]
    pub fn step(&mut self, telemetry: &Telemetry) -> Option<MonitorReport> {
        let monitor = self.monitor.as_ref()?;
        let measured = telemetry.sample.map(|sample| [sample.q_rad_s, sample.theta_rad]);
        let observation = Observation { tick: telemetry.tick, measured, u_rad: telemetry.u_rad };
        Some(monitor.step(&mut self.state, &observation))
    }
}
