//! Free play in the pitch linkage: a play operator of half-width b.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "linkage_backlash",
    locus: "actuator",
    parameters: &[Parameter { name: "b", unit: "rad", range: [0.001, 0.006], signed: false }],
    moderate_and_strong: [0.0014, 0.0021],
    near: &[],
    make: |values, _| Box::new(LinkageBacklash { half_width: values[0], follower: 0.0 }),
};

#[derive(Debug)]
struct LinkageBacklash {
    half_width: f64,
    follower: f64,
}

impl Effect for LinkageBacklash {
    /// The follower rests until the driver has crossed the play, then stays b behind it.
    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        self.follower = self.follower.clamp(u - self.half_width, u + self.half_width);
        self.follower
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cycle_encloses_four_times_amplitude_less_play_times_play() {
        // ∮ v du of a play operator driven between ±a: 4 b (a − b)
        let (a, b, steps) = (0.015, 0.004, 100_000);
        let mut play = LinkageBacklash { half_width: b, follower: 0.0 };
        let mut area = 0.0;
        let mut last = 0.0;
        for k in 0..=2 * steps {
            let u = a * (std::f64::consts::TAU * f64::from(k) / f64::from(steps)).sin();
            let v = play.blade(0.0, u, 1e-3);
            if k > steps {
                area += v * (u - last);
            }
            last = u;
        }
        assert!((area.abs() - 4.0 * b * (a - b)).abs() < 1e-7, "{area}");
    }
}
