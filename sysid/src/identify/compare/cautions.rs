//! What speaks against a controller that rests on the grey box's values.

use super::MethodResult;
use crate::catalogue::spectral_lines::lines;
use crate::dataset::Dataset;
use crate::estimate::{Estimate, NORMAL_95, digits};
use crate::identify::output_error::OutputErrorFit;
use crate::identify::output_error::delay_profile::DelayProfile;
use crate::model::baseline::Baseline;

/// Two estimates lie apart where they differ by more of their joint standard deviations than this.
const APART: f64 = 3.0;
/// The grey box lacks something where it leaves more than so many times what a linear model leaves of the motion held out,
const TIMES: f64 = 2.0;
/// and that by so many points.
const POINTS: f64 = 5.0;
/// An input has one frequency where this share of its power is there.
const ONE: f64 = 0.95;
/// Fewest periods of it.
const PERIODS: f64 = 3.0;
const BEFORE: &str = "`pitchid diagnose` tells which, and no controller should rest on these values before";

/// Why the data do not determine the plant, where they do not: a gain that may as well be zero, or a damping that is only said to be
/// large.
pub(super) fn undetermined(found: &OutputErrorFit) -> Option<String> {
    let of = |name: &str| found.parameters.iter().find(|estimate| estimate.name == name);
    let gain = of("dM_du")?;
    let [low, high] = gain.ci95;
    let why = if low <= 0.0 && high >= 0.0 {
        format!("the interval of dM_du, {} to {}, holds zero", digits(low), digits(high))
    } else if found.on_bound.iter().any(|name| name == "dM_dq") && found.plant.dm_dq != 0.0 {
        format!("dM_dq runs to its bound, {}", digits(found.plant.dm_dq))
    } else {
        return None;
    };
    Some(format!(
        "these data do not determine the plant ({why}): a written model has its inertia alone, and a diagnosis estimates the rest; \
         excite the axis"
    ))
}

/// That a fit takes the longest delay there is.
pub(super) fn delay_on_bound(fits: &[&OutputErrorFit]) -> Option<String> {
    let at_it =
        |fit: &&&OutputErrorFit| fit.plant.delay > 0.0 && fit.on_bound.iter().any(|name| name == "delay");
    fits.iter().find(at_it).map(|fit| {
        format!(
            "the delay runs to its bound, {} s: what turns the phase is something else, and gain and damping are bent with it; {BEFORE}",
            digits(fit.plant.delay)
        )
    })
}

/// That the model holds a delay that the data contradict: gain and damping are bent by the difference.
pub(super) fn delay_held(baseline: &Baseline, profile: Option<&DelayProfile>) -> Option<String> {
    let held = baseline.plant.delay;
    let profile = profile.filter(|_| !baseline.delay_free)?;
    let [low, high] = profile.ci95_s;
    (held < low || held > high).then(|| {
        format!(
            "the model has a delay of {} s and holds it, the data want {} s ({} to {}): gain and damping are bent by that; leave delay_s \
             out of the model, and it is estimated",
            digits(held),
            digits(profile.best_s),
            digits(low),
            digits(high)
        )
    })
}

/// That the grey box leaves more of the motion held out than the best linear model, where it does.
pub(super) fn lacking(grey: &MethodResult, others: &[MethodResult], held_out: &[String]) -> Option<String> {
    let mean = |method: &MethodResult| {
        let all: Option<Vec<f64>> =
            held_out.iter().map(|label| method.vaf_percent.get(label).copied()).collect();
        all.filter(|all| !all.is_empty()).map(|all| all.iter().sum::<f64>() / all.len() as f64)
    };
    let own = mean(grey)?;
    let others = others.iter().filter_map(|method| Some((method, mean(method)?)));
    let (best, reached) = others.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (100.0 - own > TIMES * (100.0 - reached) && reached - own > POINTS).then(|| {
        format!(
            "the grey box tells {own:.1} % of the motion held out, {} ({}) {reached:.1} %: it lacks some physics, or the input answers \
             to the motion; {BEFORE}",
            best.name, best.detail
        )
    })
}

/// That the white and the coloured fit differ by more than their intervals allow, where they do. In open loop both come to the
/// plant, whatever the disturbance; a missing term or a feedback moves each elsewhere (Hausman, Econometrica 46, 1978).
pub(super) fn at_odds(white: &[Estimate], coloured: &[Estimate]) -> Option<String> {
    let deviation = |estimate: &Estimate| 0.5 * (estimate.ci95[1] - estimate.ci95[0]) / NORMAL_95;
    let apart = |(a, b): &(&Estimate, &Estimate)| {
        (a.value - b.value).abs() > APART * deviation(a).hypot(deviation(b))
    };
    let told = |(a, b): (&Estimate, &Estimate)| {
        format!("{} {} and {} {}", a.name, digits(a.value), digits(b.value), b.unit)
    };
    // no controller rests on the mount, whose intervals near a bound promise too much
    let plant = white.iter().zip(coloured).filter(|(a, _)| !a.name.starts_with("mount"));
    let all: Vec<String> = plant.filter(apart).map(told).collect();
    (!all.is_empty()).then(|| {
        format!(
            "the grey box with white errors and that with coloured ones differ by more than their intervals ({}): it lacks some physics, \
             or the input answers to the motion; {BEFORE}",
            all.join(", ")
        )
    })
}

/// That the input has one frequency, where it has: a gain and a phase are two numbers, which any plant with as many parameters
/// meets (an input that is persistently exciting of order two; Ljung, System Identification, 1999, chapter 13).
pub(super) fn one_frequency(data: &Dataset) -> Option<String> {
    let longest = data.runs.iter().max_by_key(|run| run.len())?;
    let f_hz = the_one_frequency(&longest.u, longest.step)?;
    Some(format!(
        "the input has one frequency, about {} Hz, of which gain and phase are all that can be known: nothing there shows a model wrong, not \
         even in its sign; excite the axis with a PRBS, steps or a sweep",
        digits(f_hz)
    ))
}

/// The frequency, Hz, at which nearly all of the signal's power is.
fn the_one_frequency(signal: &[f64], step: f64) -> Option<f64> {
    let n = signal.len() as f64;
    // below some periods a ramp and a step are one line too
    let line = lines(signal, step, PERIODS / (n * step)).into_iter().next()?;
    let mean = signal.iter().sum::<f64>() / n;
    let power = signal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    (0.5 * line.amplitude.norm_sqr() > ONE * power && power > 0.0).then_some(line.frequency)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use std::f64::consts::TAU;

    #[test]
    fn fits_that_differ_by_more_than_their_intervals_are_told() {
        let estimate = |name: &str, value, deviation| Estimate::new(name, "s", value, deviation, [-9.0, 9.0]);
        let white = [estimate("dM_dq", -1.0, 0.1), estimate("delay", 0.055, 0.003)];
        let near = [estimate("dM_dq", -1.1, 0.1), estimate("delay", 0.050, 0.001)];
        assert_eq!(at_odds(&white, &near), None);
        let far = [near[0].clone(), estimate("delay", 0.043, 0.001)];
        let told = at_odds(&white, &far).unwrap();
        assert!(told.contains("(delay 0.0550 and 0.0430 s)"), "{told}");
        assert_eq!(at_odds(&white, &[]), None, "no second fit");
    }

    #[test]
    fn a_grey_box_that_leaves_twice_what_a_linear_model_leaves_is_told() {
        let line = |name: &str, vaf: &[f64]| MethodResult {
            name: name.into(),
            detail: "n = 2".into(),
            vaf_percent: vaf.iter().enumerate().map(|(i, vaf)| (i.to_string(), *vaf)).collect(),
            remark: String::new(),
            tests: BTreeMap::new(),
            simulated: BTreeMap::new(),
            model: None,
        };
        let labels = ["0".to_owned(), "1".to_owned()];
        let others =
            [line("LMS", &[50.0, 40.0]), line("PI-MOESP", &[97.0, 95.0]), line("cut short", &[99.0])];
        let told = lacking(&line("grey", &[70.0, 90.0]), &others, &labels).unwrap();
        assert!(told.contains("80.0 %") && told.contains("PI-MOESP (n = 2) 96.0 %"), "{told}");
        assert_eq!(lacking(&line("grey", &[91.0, 92.0]), &others, &labels), None, "4.5 points");
        assert_eq!(lacking(&line("grey", &[20.0, 40.0]), &others[..1], &labels), None, "nobody tells half");
        assert_eq!(lacking(&line("grey", &[70.0, 90.0]), &others, &[]), None, "nothing held out");
    }

    #[test]
    fn a_tone_is_one_frequency_and_an_excitation_is_not() {
        let made =
            |of: &dyn Fn(f64) -> f64| -> Vec<f64> { (0..3000).map(|k| of(0.02 * f64::from(k))).collect() };
        let tone = |f: f64| move |t: f64| (TAU * f * t).sin();
        let found = the_one_frequency(&made(&|t| 5.0 + tone(0.507)(t)), 0.02).unwrap();
        assert!((found - 0.507).abs() < 0.01, "{found}");
        let two = made(&|t| tone(0.3)(t) + 0.3 * tone(1.1)(t));
        let square = made(&|t| tone(0.2)(t).signum());
        let sweep = made(&|t| tone(0.01 * t)(t));
        let step = made(&|t| f64::from(t > 20.0));
        for other in [two, square, sweep, step, vec![0.0; 3000], vec![1.0; 2], vec![]] {
            assert_eq!(the_one_frequency(&other, 0.02), None);
        }
    }
}
