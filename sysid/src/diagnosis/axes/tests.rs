//! Axes whose actuators lag alike, and axes that say nothing.

use super::super::data_checks::fixture::{Flight, GAIN, flight, held_in_the_air, model};
use super::super::fixture::lagging;
use super::*;
use crate::estimate::Estimate;
use std::sync::Mutex;

const LAG_S: f64 = 0.1;

fn axis(name: &str, flown: &Flight, model: Option<ModelFile>) -> AxisRecordings {
    AxisRecordings { name: name.into(), recordings: vec![flown.recording()], model }
}

fn still(flown: Flight) -> Flight {
    Flight { u: vec![0.01; flown.u.len()], ..flown }
}

/// The first `rows` rows.
fn cut(flown: &Flight, rows: usize) -> Flight {
    let mut cut = flown.clone();
    for signal in [&mut cut.u, &mut cut.q, &mut cut.theta, &mut cut.reference] {
        signal.truncate(rows);
    }
    cut.supervised.truncate(rows);
    cut
}

/// Whether the axis was found to move by its input, and whether the input is taken to come first.
fn found(axis: &AxisRecordings) -> Option<bool> {
    let data = Dataset::new(&axis.recordings).unwrap();
    let baseline = Baseline::new(axis.model.as_ref(), &data).unwrap();
    excited(axis, &data, &baseline).map(|(baseline, _)| baseline.input_first)
}

fn term(id: &'static str) -> SharedTerm {
    SharedTerm {
        id,
        sentence: "",
        axes: Vec::new(),
        not_on: Vec::new(),
        parameter: Estimate::new("T", "s", LAG_S, 0.01, [0.0, 1.0]),
        by_axis: Vec::new(),
        probability: 1.0,
        rivals: Vec::new(),
    }
}

#[test]
fn only_an_axis_that_its_input_moves_is_asked() {
    let sound = flight(1, 0.0);
    let known = || Some(model(GAIN, 0.06));
    assert_eq!(found(&axis("pitch", &sound, known())), Some(false));
    assert_eq!(found(&axis("pitch", &cut(&sound, 75), known())), None, "a second and a half");
    assert_eq!(found(&axis("pitch", &still(sound), known())), None);
    let held = |seed: u64| {
        let recordings = vec![held_in_the_air(seed)];
        found(&AxisRecordings { name: "pitch".into(), recordings, model: None })
    };
    assert_eq!(held(2), Some(true), "the controller answers within the row");
    assert_eq!(held(1), None, "and nothing else moves the input");
}

#[test]
fn axes_share_a_lag_that_both_have_and_one_axis_shares_nothing() {
    let known = || Some(model(GAIN, 0.06));
    let [roll, pitch] =
        [("roll", 1), ("pitch", 2)].map(|(name, seed)| axis(name, &lagging(seed, LAG_S), known()));
    let yaw = axis("yaw", &still(flight(3, 0.0)), known());
    let both = [roll, pitch, yaw];
    let shared = shared_by(&both).unwrap().unwrap();
    assert_eq!((shared.id, &shared.axes[..]), ("servo_lag", &["roll".to_owned(), "pitch".to_owned()][..]));
    assert!(shared.not_on.is_empty(), "yaw was not asked: {:?}", shared.not_on);
    assert!((shared.parameter.value / LAG_S - 1.0).abs() < 0.15, "{:?}", shared.parameter);
    assert!(shared_by(&both[1..]).unwrap().is_none());
}

#[test]
fn each_axis_is_told_by_its_name_and_without_an_inertia_where_it_has_no_model() {
    let known = Some(model(GAIN, 0.06));
    let [roll, pitch] = [(1, known), (2, None)].map(|(seed, model)| {
        let name = if seed == 1 { "roll" } else { "pitch" };
        axis(name, &cut(&lagging(seed, LAG_S), 1000), model)
    });
    let said = Mutex::new(Vec::new());
    let hear = |step: Step<'_>| said.lock().unwrap().push(step.what.to_owned());
    let found = diagnose_axes(&[roll, pitch], &hear).unwrap();
    assert_eq!(found.shared.unwrap().axes, ["roll", "pitch"]);
    let told = |(name, diagnosis): &(String, Diagnosis)| {
        let answer = &diagnosis.answer;
        (name.clone(), answer.notes.iter().any(|note| note == ASSUMED), answer.per_unit_inertia)
    };
    let told: Vec<_> = found.axes.iter().map(told).collect();
    assert_eq!(told, [("roll".to_owned(), false, false), ("pitch".to_owned(), true, true)]);
    let said = said.into_inner().unwrap();
    assert_eq!(said[0], "looking for what the axes share");
    for name in ["roll", "pitch"] {
        assert!(said.contains(&format!("{name}: fitting the baseline")), "{said:?}");
    }
}

#[test]
fn what_stands_for_the_same_as_a_shared_term_is_not_asked_again() {
    let ids = |id| without_kind(&term(id)).iter().map(|effect| effect.about().id).collect::<Vec<_>>();
    let rest = ids("servo_lag");
    let lags = ["servo_lag", "gyro_lag", "angle_lag", "rotor_reaction"];
    assert!(lags.iter().all(|lag| !rest.contains(lag)), "{rest:?}");
    assert!(rest.contains(&"gravity_stiffness") && rest.contains(&"imu_mount"), "{rest:?}");
    assert_eq!(ids("gravity_stiffness").len(), CATALOGUE.len(), "that of no class");
}

#[test]
fn a_model_takes_a_shared_term_beside_its_own_or_in_place_of_its_size() {
    let entry = |id: &str, name: &str, value: f64| EffectEntry {
        id: id.into(),
        shape: None,
        parameters: BTreeMap::from([(name.to_owned(), value)]),
        remark: None,
    };
    let stiff = entry("gravity_stiffness", "G", 0.4);
    let lag = |value: f64| entry("servo_lag", "T", value);
    let mut known = model(GAIN, 0.06);
    known.effects = vec![stiff.clone()];
    assert_eq!(with(Some(&known), &term("servo_lag")).effects, [stiff.clone(), lag(LAG_S)]);
    known.effects = vec![lag(0.3), stiff.clone()];
    let changed = with(Some(&known), &term("servo_lag"));
    assert_eq!((changed.effects, changed.plant), (vec![lag(LAG_S), stiff], known.plant));
    assert_eq!(
        with(None, &term("servo_lag")),
        ModelFile { effects: vec![lag(LAG_S)], ..ModelFile::unknown() }
    );
}
