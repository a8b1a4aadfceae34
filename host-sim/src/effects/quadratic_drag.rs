//! Drag that grows with the square of the rate: M −= D q|q|.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "quadratic_drag",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "D", unit: "N m s²/rad²", range: [0.1, 1.0], signed: false }],
    moderate_and_strong: [1.0, 1.0],
    near: &[],
    make: |values, _| Box::new(QuadraticDrag { drag: values[0] }),
};

#[derive(Debug)]
struct QuadraticDrag {
    drag: f64,
}

impl Effect for QuadraticDrag {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        -self.drag * x.q * x.q.abs()
    }
}
