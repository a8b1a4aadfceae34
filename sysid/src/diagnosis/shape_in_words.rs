//! What a term without a name says, as one sentence: where it acts, on what it depends, of what shape it is, and how large it is
//! with its 95 % interval.

use crate::catalogue::shapes::{LAGS_S, SLIPS, Shape, Signals};
use crate::dataset::Amplitudes;
use crate::estimate::{NORMAL_95, digits};
use crate::model::effect::Effect;

/// Largest size of a signal that is spoken of, in its standard deviations.
const FAR: f64 = 2.0;
/// Smallest: beyond where a sign change is smoothed.
const NEAR: f64 = 0.2;
/// A part of a curve whose root mean square is less than this share of the other's goes unsaid.
const SLIGHT: f64 = 1.0 / 3.0;
/// A curve that comes up to less than this share of its far value at one standard deviation sets in beyond it.
const NOTHING_YET: f64 = 0.15;
/// A curve whose near value is within this share of the far one is of one size.
const SAME_SIZE: f64 = 0.15;
/// A value whose interval reaches this many times further than the largest value is none.
const UNSEEN: f64 = 10.0;

/// A term without a name with its coefficients `p`.
pub struct Formula<'a> {
    /// The term.
    pub shape: &'a Shape,
    /// Its coefficients.
    pub p: &'a [f64],
    /// Standard deviation of Σ g_i p_i for these g.
    pub deviation: &'a dyn Fn(&[f64]) -> f64,
    /// Sizes of the signals.
    pub sizes: &'a Amplitudes,
    /// Unit of the input.
    pub input_unit: &'a str,
}

/// The signal that a curve is of.
struct Axis<'a> {
    size: f64,
    unit: &'a str,
    set: fn(f64) -> Signals,
    /// What an odd curve does for a negative and for a positive value at positive ones.
    odd: [&'static str; 2],
}

impl Formula<'_> {
    /// The sentence.
    pub fn in_words(&self) -> String {
        let about = self.shape.about();
        let Amplitudes { q, theta, u, duration, .. } = *self.sizes;
        let places = |places: &[(String, Signals)]| self.at_places(places);
        let told = match about.id {
            "of_q" | "of_slow_q" => {
                let set = |x| Signals { x, ..Signals::default() };
                let odd = ["against the motion", "along with the motion"];
                return self.curve(&Axis { size: q, unit: "rad/s", set, odd });
            }
            "of_theta" | "of_theta_by_side" => {
                let set = |y| Signals { y, ..Signals::default() };
                let odd = ["that pulls back", "that pushes away"];
                return self.curve(&Axis { size: theta, unit: "rad", set, odd });
            }
            "of_u" => {
                let set = |v| Signals { v, ..Signals::default() };
                let odd = ["against the command", "along with the command"];
                return self.curve(&Axis { size: u, unit: self.input_unit, set, odd });
            }
            "of_q_and_theta" => {
                let at = |y: f64| {
                    (format!("{} rad", digits(y * theta)), Signals { x: 1.0, y, ..Signals::default() })
                };
                places(&[at(-1.5), at(-0.5), at(0.5), at(1.5)])
            }
            "slipping_springs" => {
                let at = |y: f64| {
                    let memory = [y.min(SLIPS[0]), y.min(SLIPS[1]), 0.0];
                    (
                        format!("{} rad after a turn", digits(y * theta)),
                        Signals { memory, ..Signals::default() },
                    )
                };
                places(&SLIPS.map(at))
            }
            "memory_of_u" => {
                let at = |t: f64| {
                    let memory = LAGS_S.map(|time| 1.0 - f64::exp(-t / time));
                    (
                        format!("{t} s after a step of {} {}", digits(u), self.input_unit),
                        Signals { memory, ..Signals::default() },
                    )
                };
                places(&[at(0.1), at(0.5), at(2.0)])
            }
            "memory_of_motion" => {
                let at = |what: &str, memory| (what.to_owned(), Signals { memory, ..Signals::default() });
                places(&[
                    at(&format!("per {} rad/s over the last 0.2 s", digits(q)), [1.0, 0.0, 0.0]),
                    at(&format!("per {} rad over the last 0.2 s", digits(theta)), [0.0, 1.0, 0.0]),
                    at(&format!("per {} rad over the last second", digits(theta)), [0.0, 0.0, 1.0]),
                ])
            }
            "seen_by_the_gyro" => {
                let at = |v: f64| {
                    let memory = [v, v, 0.0];
                    (
                        format!("a lasting {} {}", digits(v * u), self.input_unit),
                        Signals { memory, ..Signals::default() },
                    )
                };
                places(&[at(-1.0), at(1.0)])
            }
            "moment_over_time" | "gain_over_time" | "damping_over_time" => {
                let at = |t: f64| {
                    (format!("{:.0} s", t * duration), Signals { x: 1.0, v: 1.0, t, ..Signals::default() })
                };
                let all: Vec<_> = (0..8).map(|i| at(f64::from(i) / 7.0)).collect();
                let per = if about.id == "moment_over_time" { "" } else { ", at usual rate and command" };
                places(&all) + per
            }
            _ => {
                let all = Signals { x: 1.0, y: 1.0, v: 1.0, ..Signals::default() };
                let usual = [("q", q, "rad/s"), ("theta", theta, "rad"), ("u", u, self.input_unit)]
                    .into_iter()
                    .filter(|(name, ..)| about.variable.split([' ', '|']).any(|signal| signal == *name))
                    .map(|(name, size, unit)| format!("{name} = {} {unit}", digits(size)));
                places(&[(usual.collect::<Vec<_>>().join(" and "), all)])
            }
        };
        format!("{}: {told}", about.sentence)
    }

    fn unit(&self) -> &'static str {
        self.shape.parameters(self.sizes)[0].unit
    }

    /// Half width of the interval of Σ g_i p_i.
    fn reach(&self, g: &[f64]) -> f64 {
        NORMAL_95 * (self.deviation)(g)
    }

    /// Σ g_i p_i with its interval: "0.113 ± 0.012".
    fn told(&self, g: &[f64]) -> String {
        let (value, reach) = (self.value(g), self.reach(g));
        if reach.is_finite() { format!("{} ± {}", digits(value), digits(reach)) } else { digits(value) }
    }

    fn value(&self, g: &[f64]) -> f64 {
        g.iter().zip(self.p).map(|(g, p)| g * p).sum()
    }

    /// The values at some places; none where the data say nothing of it.
    fn at_places(&self, places: &[(String, Signals)]) -> String {
        let unit = self.unit();
        let curves: Vec<Vec<f64>> = places.iter().map(|(_, signals)| self.shape.curves(signals)).collect();
        let largest = curves.iter().map(|g| self.value(g).abs()).fold(0.0, f64::max);
        // where the term is nothing by its form its reach is infinite
        let seen = |g: &[f64]| !self.reach(g).is_finite() || self.reach(g) <= UNSEEN * largest;
        let told = places.iter().zip(&curves).filter(|(_, g)| seen(g)).map(|((place, _), g)| {
            format!("{} {unit} at {place}", self.told(g)).replace(" at per ", " per ")
        });
        let told: Vec<String> = told.collect();
        if told.is_empty() { "of a size that these data do not tell".into() } else { told.join(", ") }
    }

    /// A curve of one signal: the odd part, the even part, or both sides where neither is slight.
    fn curve(&self, axis: &Axis<'_>) -> String {
        let at = |x: f64| self.shape.curves(&(axis.set)(x));
        let half = |x: f64, sign: f64| -> Vec<f64> {
            at(x).iter().zip(at(-x)).map(|(plus, minus)| 0.5 * (plus + sign * minus)).collect()
        };
        let [odd, even] = [-1.0, 1.0].map(|sign| move |x: f64| half(x, sign));
        let strength = |part: &dyn Fn(f64) -> Vec<f64>| {
            [NEAR, 1.0, FAR].iter().map(|&x| self.value(&part(x)).powi(2)).sum::<f64>().sqrt()
        };
        let (as_odd, as_even) = (strength(&odd), strength(&even));
        if as_even < SLIGHT * as_odd {
            let way = axis.odd[usize::from(self.value(&odd(FAR)) > 0.0)];
            return format!("a moment {way} {}", self.course(&odd, axis));
        }
        if as_odd < SLIGHT * as_even {
            return format!(
                "a moment that is the same both ways and {}",
                self.course(&even, axis).replacen("that ", "", 1)
            );
        }
        let sides = [-FAR, -1.0, 1.0, FAR]
            .map(|x| (format!("{} {}", digits(x * axis.size), axis.unit), (axis.set)(x)));
        format!("{}: {}", self.shape.about().sentence, self.at_places(&sides))
    }

    /// How a part of the curve goes from small signals to large ones.
    fn course(&self, part: &dyn Fn(f64) -> Vec<f64>, axis: &Axis<'_>) -> String {
        let place = |x: f64| format!("{} {}", digits(x * axis.size), axis.unit);
        let sign = self.value(&part(FAR)).signum();
        let size = |x: f64| self.told(&part(x).iter().map(|g| sign * g).collect::<Vec<f64>>());
        let [near, middle, far] = [NEAR, 1.0, FAR].map(|x| sign * self.value(&part(x)));
        let unit = self.unit();
        match () {
            () if middle.abs() < NOTHING_YET * far => {
                format!("that sets in beyond {} and is {} {unit} at {}", place(1.0), size(FAR), place(FAR))
            }
            () if (near - far).abs() < SAME_SIZE * far && (middle - far).abs() < SAME_SIZE * far => {
                format!("that is {} {unit} at any size of it", size(1.0))
            }
            () => {
                let way = if near > far { "falls" } else { "rises" };
                let [from, to] = [size(NEAR), size(FAR)];
                format!("that {way} from {from} to {to} {unit} between {} and {}", place(NEAR), place(FAR))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::shapes::SHAPES;

    const SIZES: Amplitudes = Amplitudes {
        inertia: 1.0,
        u: 0.015,
        q: 0.2,
        theta: 0.1,
        turned: 0.8,
        angles: [0.0; 3],
        moment: 0.35,
        moves: 0.0,
        step: 0.02,
        duration: 98.0,
        rate_limit: None,
    };

    fn said(id: &str, p: &[f64]) -> String {
        let shape = SHAPES.iter().find(|shape| shape.about().id == id).unwrap();
        let deviation = |g: &[f64]| 0.005 * g.iter().map(|g| g * g).sum::<f64>().sqrt();
        Formula { shape, p, deviation: &deviation, sizes: &SIZES, input_unit: "rad" }.in_words()
    }

    #[test]
    fn a_friction_that_falls_with_the_rate_is_said_as_one() {
        let text = said("of_slow_q", &[-0.06, -0.1]);
        assert!(text.starts_with("a moment against the motion that falls from 0.11"), "{text}");
        assert!(text.contains("± ") && text.ends_with("N m between 0.0400 rad/s and 0.400 rad/s"), "{text}");
    }

    #[test]
    fn odd_even_threshold_and_sides_are_told_apart() {
        assert!(said("of_q", &[-0.1, 0.0, 0.0, 0.0]).contains("against the motion that is 0.100 ± 0.0142"));
        let drag = said("of_q", &[0.0, 0.0, 0.0, -0.1]);
        assert!(drag.contains("against the motion that rises from 0.00400"), "{drag}");
        let stop = said("of_theta", &[0.0, 0.0, 0.0, -0.4]);
        assert!(stop.starts_with("a moment that pulls back that sets in beyond 0.100 rad"), "{stop}");
        let even = said("of_theta", &[0.0, 0.1, 0.0, 0.0]);
        assert!(even.starts_with("a moment that is the same both ways and rises from"), "{even}");
        let side = said("of_theta_by_side", &[0.3, 0.02]);
        assert!(side.contains("N m at -0.200 rad, ") && side.contains("nose-up from nose-down: "), "{side}");
    }

    #[test]
    fn places_that_the_data_did_not_visit_are_left_out() {
        let shape = SHAPES.iter().find(|shape| shape.about().id == "of_theta_by_side").unwrap();
        let text = |all: f64| {
            let deviation = |g: &[f64]| if g[0] < 0.0 { 1e5 } else { all };
            let p = &[0.3, 0.02];
            Formula { shape, p, deviation: &deviation, sizes: &SIZES, input_unit: "rad" }.in_words()
        };
        assert!(text(0.01).contains(" rad") && !text(0.01).contains("100000"), "{}", text(0.01));
        assert!(text(1e5).ends_with("of a size that these data do not tell"), "{}", text(1e5));
    }

    #[test]
    fn every_term_is_said_with_numbers_and_units() {
        for shape in SHAPES {
            let p = vec![0.1; shape.curves(&Signals::default()).len()];
            let text = said(shape.about().id, &p);
            assert!(text.contains("± ") && !text.contains("coefficients") && !text.contains("NaN"), "{text}");
        }
    }
}
