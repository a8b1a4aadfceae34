//! Recirculation and turbulence, a coloured moment that u does not cause: T ẇ = −w + noise, M += w.

use super::{Effect, Entry, Parameter};
use crate::disturbance::{Colour, ColouredMoment};
use crate::plant::State;
use crate::seeds::{Stream, generator};

pub(super) const ENTRY: Entry = Entry {
    id: "gust_disturbance",
    locus: "environment",
    parameters: &[
        Parameter { name: "sigma", unit: "N m", range: [0.02, 0.2], signed: false },
        Parameter { name: "T", unit: "s", range: [0.2, 3.0], signed: false },
    ],
    moderate_and_strong: [0.02, 0.026],
    near: &[],
    make: |values, seed| {
        // a time constant of nought would be white: its moment is that of the grid
        let colour = Colour::FirstOrder { time_constant_s: values[1].max(1e-3) };
        Box::new(Gust(ColouredMoment::new(values[0], colour, generator(seed, Stream::Effect))))
    },
};

#[derive(Debug)]
struct Gust(ColouredMoment);

impl Effect for Gust {
    fn prepare(&mut self, t: f64) {
        self.0.extend_to(t);
    }

    fn moment(&self, t: f64, _x: &State, _blade: f64) -> f64 {
        self.0.at(t)
    }
}
