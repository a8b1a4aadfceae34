//! Dry friction in the pivot: M −= Mc sign q, and it sticks at rest.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "coulomb_friction",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "Mc", unit: "N m", range: [0.01, 0.15], signed: false }],
    moderate_and_strong: [0.03, 0.04],
    near: &[],
    make: |values, _| Box::new(CoulombFriction { level: values[0] }),
};

#[derive(Debug)]
struct CoulombFriction {
    level: f64,
}

impl Effect for CoulombFriction {
    fn dry_friction(&self, _x: &State) -> [f64; 2] {
        [self.level; 2]
    }
}
