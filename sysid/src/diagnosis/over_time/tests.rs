//! A moment that acts for eight seconds.

use super::super::fixture::{asked, effects, extended, flight_with};
use super::*;

#[test]
fn a_moment_of_a_while_is_seen_in_its_while() {
    let acts = 800..1200;
    let flown = flight_with(1, |k, _, _| if acts.contains(&k) { 0.3 } else { 0.0 });
    asked(&flown, |problem, baseline| {
        let shown = residual_moments(problem, baseline, baseline);
        let [run] = shown.as_slice() else { panic!("one run") };
        assert!(run.extended.is_none() && run.recording == 0);
        assert_eq!((run.t.len(), run.baseline.len()), (1950, 1950));
        assert!((run.t[0] - 1.0).abs() < 1e-9, "from the first counted sample on");
        let mean = |from: f64, to: f64| {
            let within = run.t.iter().zip(&run.baseline).filter(|(t, _)| (from..to).contains(*t));
            let all: Vec<f64> = within.map(|(_, moment)| *moment).collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        let (during, before, after) = (mean(17.0, 24.0), mean(2.0, 16.0), mean(27.0, 40.0));
        assert!((0.15..0.4).contains(&during), "{during}");
        assert!(before.abs() < 0.1 && after.abs() < 0.1, "{before} {after}");
    });
}

#[test]
fn an_extended_model_shows_what_it_leaves() {
    asked(&flight_with(1, |_, _, theta| -1.5 * theta.sin()), |problem, baseline| {
        let after = extended(problem, baseline, &effects(&["gravity_stiffness"]));
        let shown = residual_moments(problem, baseline, &after);
        let extended = shown[0].extended.as_ref().unwrap();
        assert_eq!(extended.len(), shown[0].t.len());
        let power = |moment: &[f64]| moment.iter().map(|m| m * m).sum::<f64>();
        assert!(power(extended) < 0.5 * power(&shown[0].baseline));
    });
}
