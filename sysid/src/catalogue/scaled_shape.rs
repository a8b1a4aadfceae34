//! Terms without a name as a model file carries them: with the scales at which their shapes were fitted, so that they
//! mean the same with any other recording.
//!
//! As a candidate, an [`Shape`] term takes the sizes of the data at hand for its scales. [`ScaledShape`] is the same term
//! with σ_q, σ_θ, σ_u and the duration as its last four values ([`SCALES`]); a model file calls it `unlisted`, with the
//! candidate's id as its shape and its coefficients under names with a unit.

use crate::catalogue::shapes::{SHAPES, Shape};
use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Parameter, Scale};
use crate::model::file::{EffectEntry, SCALES};
use crate::model::pitch::{Output, Term};

/// Id of a term without a name, in answers and model files.
pub const UNLISTED: &str = "unlisted";

/// Names of coefficients in model files, by unit.
const MOMENTS: [&str; 8] = ["c1_N_m", "c2_N_m", "c3_N_m", "c4_N_m", "c5_N_m", "c6_N_m", "c7_N_m", "c8_N_m"];
const RATES: [&str; 8] =
    ["c1_rad_s", "c2_rad_s", "c3_rad_s", "c4_rad_s", "c5_rad_s", "c6_rad_s", "c7_rad_s", "c8_rad_s"];

/// A term without a name, with its own scales.
#[derive(Clone, Copy)]
pub struct ScaledShape(&'static Shape);

static ALL: [ScaledShape; SHAPES.len()] = {
    let mut all = [ScaledShape(SHAPES[0]); SHAPES.len()];
    let mut i = 0;
    while i < all.len() {
        all[i] = ScaledShape(SHAPES[i]);
        i += 1;
    }
    all
};

/// All terms without a name.
pub fn all() -> impl Iterator<Item = &'static ScaledShape> {
    ALL.iter()
}

/// The term of this shape.
pub fn find(shape: &str) -> Option<&'static ScaledShape> {
    all().find(|scaled| scaled.about().id == shape)
}

/// The term of a shape by its name in model files.
pub fn find_in_file(name: &str) -> Option<&'static ScaledShape> {
    all().find(|scaled| scaled.name_in_file() == name)
}

/// `term` as a model file can hold it: one without a name gets the scales of the data that it was fitted to, unless it
/// has its own.
pub fn carried(term: &Term, sizes: &Amplitudes) -> Term {
    let Some(scaled) = find(term.effect.about().id) else { return term.clone() };
    let mut values = term.values.clone();
    if values.len() == scaled.0.parameters(sizes).len() {
        let scales = [sizes.q, sizes.theta, sizes.u, sizes.duration];
        values.extend(scales.map(|scale| scale.max(f64::MIN_POSITIVE)));
    }
    Term { effect: scaled, values }
}

/// A term as an entry of a model file; `names` are those of its values.
pub fn entry(term: &Term, names: &[&str]) -> EffectEntry {
    let id = term.effect.about().id;
    let scaled = find(id);
    EffectEntry {
        id: if scaled.is_some() { UNLISTED } else { id }.into(),
        shape: scaled.map(|scaled| scaled.name_in_file().into()),
        parameters: names.iter().map(|&name| name.into()).zip(term.values.iter().copied()).collect(),
        remark: scaled.map(ScaledShape::remark),
    }
}

impl ScaledShape {
    /// The shape's name in model files: its id, but for the one whose name there is the id of an effect of the catalogue.
    pub fn name_in_file(&self) -> &'static str {
        match self.about().id {
            "slipping_springs" => "hysteresis",
            id => id,
        }
    }

    fn remark(&self) -> String {
        let validity = if self.0.local_in_time {
            "; its times are those of the recording it was fitted to, and it says nothing of any other"
        } else {
            ""
        };
        format!("without a name: {}{validity}", self.0.about().sentence)
    }
}

/// Coefficients and scales.
fn split(p: &[f64]) -> (&[f64], &[f64]) {
    p.split_at(p.len().saturating_sub(SCALES.len()))
}

/// Coefficients, and the conditions with the term's own scales.
fn own<'p>(p: &'p [f64], at: &Conditions) -> (&'p [f64], Conditions) {
    let (coefficients, scales) = split(p);
    let &[q, theta, u, duration] = scales else { return (coefficients, *at) };
    (coefficients, Conditions { sizes: Amplitudes { q, theta, u, duration, ..at.sizes }, ..*at })
}

impl Effect for ScaledShape {
    fn about(&self) -> About {
        self.0.about()
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let mut all = self.0.parameters(data);
        for (i, coefficient) in all.iter_mut().enumerate() {
            coefficient.name = if coefficient.unit == "N m" { MOMENTS[i] } else { RATES[i] };
        }
        let units = ["rad/s", "rad", "1", "s"];
        let bounds = |(&name, unit): (&&'static str, _)| Parameter {
            name,
            unit,
            lower: f64::MIN_POSITIVE,
            upper: f64::MAX,
            scale: Scale::Log,
        };
        all.extend(SCALES.iter().zip(units).map(bounds));
        all
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        Vec::new()
    }
    fn states(&self) -> usize {
        self.0.states()
    }
    fn within_sample(&self) -> bool {
        self.0.within_sample()
    }
    fn moment(&self, p: &[f64], s: &[f64], q: f64, theta: f64, at: &Conditions) -> f64 {
        let (coefficients, at) = own(p, at);
        self.0.moment(coefficients, s, q, theta, &at)
    }
    fn sense(&self, p: &[f64], s: &mut [f64], q: f64, theta: f64, control: f64, at: &Conditions) {
        let (coefficients, at) = own(p, at);
        self.0.sense(coefficients, s, q, theta, control, &at);
    }
    fn measure(&self, p: &[f64], s: &[f64], y: Output, roll_rate: f64) -> Output {
        self.0.measure(split(p).0, s, y, roll_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FITTED_TO: Amplitudes = Amplitudes {
        inertia: 1.0,
        u: 0.015,
        q: 0.3,
        theta: 0.1,
        turned: 0.8,
        angles: [0.0; 3],
        moment: 0.345,
        moves: 0.0,
        step: 0.02,
        duration: 90.0,
        rate_limit: None,
    };
    const OTHER: Amplitudes = Amplitudes {
        inertia: 1.0,
        u: 0.03,
        q: 0.7,
        theta: 0.4,
        turned: 2.4,
        angles: [0.0; 3],
        moment: 0.7,
        moves: 0.0,
        step: 0.01,
        duration: 30.0,
        rate_limit: None,
    };

    /// What a term does over one step from somewhere: moment, its own states after it, what is measured.
    fn act(term: &Term, sizes: Amplitudes) -> (f64, [f64; 3], Output) {
        let at = Conditions { t: 12.0, dt: 0.01, command: 0.007, sizes, ..Conditions::default() };
        let mut own = [0.1, -0.2, 0.3];
        let states = term.effect.states();
        let moment = term.effect.moment(&term.values, &own[..states], 0.2, -0.06, &at);
        term.effect.sense(&term.values, &mut own[..states], 0.2, -0.06, 1.0, &at);
        (moment, own, term.effect.measure(&term.values, &own[..states], [0.2, -0.06], 0.0))
    }

    #[test]
    fn a_carried_term_does_with_other_data_what_it_did_with_its_own() {
        for &shape in SHAPES {
            let values = (1..=shape.parameters(&FITTED_TO).len()).map(|i| 0.01 * i as f64).collect();
            let candidate = Term { effect: shape, values };
            let carried = carried(&candidate, &FITTED_TO);
            let id = shape.about().id;
            assert_eq!(act(&candidate, FITTED_TO), act(&carried, OTHER), "{id}");
            assert_ne!(act(&candidate, FITTED_TO), act(&candidate, OTHER), "{id}");
            assert_eq!(super::carried(&carried, &OTHER).values, carried.values);
            let named: Vec<&str> = carried.effect.parameters(&OTHER).iter().map(|p| p.name).collect();
            assert_eq!(named.len(), carried.values.len());
        }
    }

    #[test]
    fn an_entry_says_when_it_holds_for_one_recording_only() {
        let of = |shape: &str| {
            let scaled = find(shape).unwrap();
            entry(&Term { effect: scaled, values: vec![1.0] }, &["c1_N_m"])
        };
        assert_eq!(of("of_q").remark.unwrap(), "without a name: a moment that depends on the pitch rate");
        assert!(of("moment_over_time").remark.unwrap().contains("says nothing of any other"));
        assert_eq!((of("of_q").id.as_str(), of("of_q").shape.as_deref()), ("unlisted", Some("of_q")));
    }
}
