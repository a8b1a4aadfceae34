//! The loop delay is not what the model says: u(t − τ − Δ).

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "extra_delay",
    locus: "timing",
    parameters: &[Parameter { name: "Delta", unit: "s", range: [0.01, 0.1], signed: true }],
    moderate_and_strong: [0.055, 0.086],
    near: &[],
    make: |values, _| Box::new(ExtraDelay { delay_s: values[0] }),
};

#[derive(Debug)]
struct ExtraDelay {
    delay_s: f64,
}

impl Effect for ExtraDelay {
    fn delay_s(&self, _t: f64) -> f64 {
        self.delay_s
    }
}
