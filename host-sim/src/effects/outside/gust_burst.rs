//! A burst of turbulence: a coloured moment that is there from t₁ for a time, and not before or after.

use super::{Effect, Entry, Parameter};
use crate::disturbance::{Colour, ColouredMoment};
use crate::plant::State;
use crate::seeds::{Stream, generator};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "gust_burst",
    locus: "environment",
    parameters: &[
        Parameter { name: "sigma", unit: "N m", range: [0.04, 0.4], signed: false },
        Parameter { name: "from_s", unit: "s", range: [55.0, 75.0], signed: false },
        Parameter { name: "length_s", unit: "s", range: [5.0, 20.0], signed: false },
    ],
    moderate_and_strong: [0.32, 0.38],
    near: &["gust_disturbance"],
    make: |values, seed| {
        let colour = Colour::FirstOrder { time_constant_s: TIME_CONSTANT_S };
        let moment = ColouredMoment::new(values[0], colour, generator(seed, Stream::Effect));
        Box::new(GustBurst { moment, window_s: [values[1], values[1] + values[2]] })
    },
};

/// T, s.
const TIME_CONSTANT_S: f64 = 0.5;

#[derive(Debug)]
struct GustBurst {
    moment: ColouredMoment,
    window_s: [f64; 2],
}

impl Effect for GustBurst {
    fn prepare(&mut self, t: f64) {
        self.moment.extend_to(t);
    }

    fn moment(&self, t: f64, _x: &State, _blade: f64) -> f64 {
        if (self.window_s[0]..self.window_s[1]).contains(&t) { self.moment.at(t) } else { 0.0 }
    }

    fn window_s(&self) -> Option<[f64; 2]> {
        Some(self.window_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_blows_inside_its_window_only() {
        let mut burst = (ENTRY.make)(&[0.2, 30.0, 400.0], 1);
        burst.prepare(500.0);
        let power = |from: u32, to: u32| -> f64 {
            let values =
                (from * 100..to * 100).map(|k| burst.moment(f64::from(k) * 0.01, &State::default(), 0.0));
            values.map(|m| m * m).sum::<f64>() / f64::from((to - from) * 100)
        };
        assert_eq!((power(0, 30), power(430, 500)), (0.0, 0.0));
        // 400 s hold 400 independent values at T = 0.5 s
        assert!((power(30, 430).sqrt() / 0.2 - 1.0).abs() < 0.12);
        assert_eq!(burst.window_s(), Some([30.0, 430.0]));
    }
}
