//! The centre of gravity lies below the pivot (or above it, G < 0): M −= G sin θ.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "gravity_stiffness",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "G", unit: "N m", range: [0.05, 1.5], signed: true }],
    moderate_and_strong: [0.13, 0.205],
    near: &[],
    make: |values, _| Box::new(GravityStiffness { stiffness: values[0] }),
};

#[derive(Debug)]
struct GravityStiffness {
    stiffness: f64,
}

impl Effect for GravityStiffness {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        -self.stiffness * x.theta.sin()
    }
}
