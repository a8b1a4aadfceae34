//! The vehicle is out of trim, its centre of gravity ahead of the pivot: M += M0.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "trim_offset",
    locus: "actuator",
    parameters: &[Parameter { name: "M0", unit: "N m", range: [0.005, 0.15], signed: true }],
    moderate_and_strong: [0.15, 0.15],
    near: &[],
    make: |values, _| Box::new(TrimOffset { moment: values[0] }),
};

#[derive(Debug)]
struct TrimOffset {
    moment: f64,
}

impl Effect for TrimOffset {
    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        self.moment
    }
}
