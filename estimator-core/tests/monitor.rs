//! The monitor on a plant of one state, whose predictor is known in closed form.

use estimator_core::monitor::{
    CAUSES, Cause, Monitor, MonitorConfig, MonitorModel, NUMBERS, Observation, Refusal, Test, Unable, Verdict,
};
use proptest::prelude::*;

const POLE: f32 = 0.97;
const GAIN: f32 = 2.6;
const NOISE: f32 = 0.02;
const KALMAN: f32 = 0.1;

/// q⁺ = 0.97 q + 2.6 u, measured with white noise, observed with a gain of 0.1; u acts at once.
fn model() -> MonitorModel {
    let mut model = MonitorModel {
        transition: [[POLE * (1.0 - KALMAN), 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]],
        moment: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        correction: [[POLE * KALMAN, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 6]],
        output: [[1.0 / NOISE, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 6]],
        whitening: [1.0 / NOISE, 0.0, 0.0],
        rest: [0.0; 2],
        specific: 0.0,
        gain: GAIN,
        delay_samples: 0.0,
        delay_fraction: 0.0,
        lag: [0.4, 0.035],
        friction_rate: 0.01,
        trim: [1.0 / NOISE / (1.0 - POLE * (1.0 - KALMAN)), 0.0],
        bias: [(1.0 - POLE * KALMAN / (1.0 - POLE * (1.0 - KALMAN))) / NOISE, 0.0],
        tests: [Test { dead_zone: 0.0, calibration: 1.0, onset: [1.0, 0.0], sizes: [0.0; 6] }; CAUSES],
    };
    let both = |unit: f32| [-4.0, -2.0, -1.0, 1.0, 2.0, 4.0].map(|size| size * unit);
    let units = [0.15, 0.015, 0.002, 0.02, 0.002, 0.02, 0.15, 0.02];
    for (test, unit) in model.tests.iter_mut().zip(units) {
        (test.dead_zone, test.sizes) = (0.2 * unit, both(unit));
    }
    // the rate alone does not tell them from effectiveness and trim, and there is no angle
    for place in 5..CAUSES {
        model.tests[place].sizes = [0.0; 6];
    }
    model
}

fn monitor() -> Monitor {
    MonitorConfig::default().build(&model()).unwrap()
}

struct Plant {
    q: f32,
    noise: u32,
}

impl Plant {
    fn random(&mut self) -> f32 {
        // the sum of twelve uniform numbers is nearly normal, of unit variance
        (0..12)
            .map(|_| {
                self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (self.noise >> 8) as f32 / 16_777_216.0
            })
            .sum::<f32>()
            - 6.0
    }

    fn step(&mut self, u: f32, gain: f32) -> [f32; 2] {
        let measured = self.q + NOISE * self.random();
        // the process noise for which 0.1 is the steady gain
        let driven = NOISE * 0.1 * self.random();
        self.q = POLE * self.q + gain * u + driven;
        [measured, 0.0]
    }
}

/// What is told at the end, and how often something was told, of a flight in which the gain changes at `change`.
fn fly(ticks: u32, change: u32, gain: f32, seed: u32) -> (Verdict, u32) {
    let monitor = monitor();
    let mut state = monitor.initial_state();
    let mut plant = Plant { q: 0.0, noise: seed };
    let (mut verdict, mut told) = (Verdict::AsIdentified, 0);
    for tick in 0..ticks {
        let u = if (tick / 30 + tick / 70) % 2 == 0 { 0.015 } else { -0.015 };
        let measured = Some(plant.step(u, if tick < change { GAIN } else { gain }));
        let report = monitor.step(&mut state, &Observation { tick, measured, u_rad: u });
        assert!(report.evidence.iter().all(|evidence| evidence.is_finite()));
        verdict = report.verdict;
        told += u32::from(report.changed && matches!(verdict, Verdict::Changed(_) | Verdict::OneOf(..)));
    }
    (verdict, told)
}

#[test]
fn an_hour_without_a_change_is_silent() {
    let (verdict, told) = fly(180_000, u32::MAX, GAIN, 3);
    assert_eq!((verdict, told), (Verdict::AsIdentified, 0));
}

#[test]
fn a_loss_of_effectiveness_is_told_with_its_size_and_its_beginning() {
    for seed in 1..6 {
        let (verdict, _) = fly(6000, 3000, 0.7 * GAIN, seed);
        let Verdict::Changed(change) = verdict else { panic!("seed {seed}: {verdict}") };
        assert_eq!(change.cause, Cause::Effectiveness, "seed {seed}");
        assert!((change.size + 0.3).abs() < change.interval && change.interval < 0.1, "{change}");
        assert!(change.since.abs_diff(3000) < 100, "{}", change.since);
    }
}

#[test]
fn what_the_sensors_do_wrong_is_why_nothing_is_told() {
    let monitor = monitor();
    let cases: [(Option<[f32; 2]>, Unable); 4] = [
        (None, Unable::NoSample),
        (Some([f32::NAN, 0.0]), Unable::NotFinite),
        (Some([0.1, f32::INFINITY]), Unable::NotFinite),
        (Some([0.123, 0.0]), Unable::Frozen),
    ];
    for (measured, why) in cases {
        let mut state = monitor.initial_state();
        let mut plant = Plant { q: 0.0, noise: 1 };
        let mut last = None;
        for tick in 0..1000 {
            let measured = if tick < 500 { Some(plant.step(0.0, GAIN)) } else { measured };
            let report = monitor.step(&mut state, &Observation { tick, measured, u_rad: 0.0 });
            assert!(
                !matches!(report.verdict, Verdict::Changed(_) | Verdict::OneOf(..)),
                "{}",
                report.verdict
            );
            last = Some(report.verdict);
        }
        assert_eq!(last, Some(Verdict::CannotTell(why)));
    }
}

#[test]
fn a_gust_that_sets_in_at_once_is_no_change() {
    let monitor = monitor();
    let mut state = monitor.initial_state();
    let mut plant = Plant { q: 0.0, noise: 9 };
    for tick in 0..30_000 {
        let u = if (tick / 30 + tick / 70) % 2 == 0 { 0.015 } else { -0.015 };
        let gust = if tick / 500 % 3 == 2 { 0.03 * plant.random() } else { 0.0 };
        let [q, theta] = plant.step(u, GAIN);
        plant.q += gust;
        let report = monitor.step(&mut state, &Observation { tick, measured: Some([q, theta]), u_rad: u });
        assert!(!matches!(report.verdict, Verdict::Changed(_) | Verdict::OneOf(..)), "{}", report.verdict);
    }
}

/// Errors as the identified ones are air of strength 1, whether the angle is measured or not.
#[test]
fn usual_errors_are_usual_air_with_one_channel_and_with_two() {
    for (theta_weight, theta_noise) in [(0.0, 0.0), (40.0, 1.0 / 40.0)] {
        let whitening = [1.0 / NOISE, 0.0, theta_weight];
        let still = MonitorModel { whitening, specific: 1.0, ..MonitorModel::EMPTY };
        let monitor = MonitorConfig::default().build(&still).unwrap();
        let (mut state, mut plant) = (monitor.initial_state(), Plant { q: 0.0, noise: 4 });
        let mut sum = 0.0;
        for tick in 0..10_000 {
            let measured = Some([NOISE * plant.random(), theta_noise * plant.random()]);
            sum += monitor.step(&mut state, &Observation { tick, measured, u_rad: 0.0 }).background;
        }
        // the larger of two means that scatter lies a little above
        let mean = sum / 10_000.0;
        assert!((1.0..1.15).contains(&mean), "{theta_weight}: {mean}");
    }
}

#[test]
fn a_model_is_its_numbers_and_one_that_no_board_may_run_is_refused() {
    let numbers = model().to_numbers();
    assert_eq!(MonitorModel::from_numbers(&numbers), Ok(model()));
    for place in 0..NUMBERS {
        let mut spoilt = numbers;
        spoilt[place] = f32::NAN;
        assert_eq!(MonitorModel::from_numbers(&spoilt), Err(Refusal::Number { place }));
    }
    let mut growing = model();
    growing.transition[1] = [0.9, 0.5, 0.5, 0.9];
    assert_eq!(growing.check(), Err(Refusal::Unstable { block: 1 }));
    assert!(matches!(MonitorModel { gain: 0.0, ..model() }.check(), Err(Refusal::Range { name: "gain" })));
    let config = MonitorConfig { run_length_h: f32::NAN, ..MonitorConfig::default() };
    assert!(config.build(&model()).is_err());
}

#[test]
fn a_refusal_says_what_is_wrong() {
    let mut numbers = model().to_numbers();
    numbers[17] = f32::INFINITY;
    let told =
        |numbers: [f32; NUMBERS]| MonitorModel::from_numbers(&numbers).map_err(|refusal| refusal.to_string());
    assert_eq!(told(numbers), Err("number 17 of the model is not finite or too large".into()));
    let growing = MonitorModel { transition: [[0.0; 4], [1.1, 0.0, 0.0, 0.0], [0.0; 4]], ..model() };
    assert_eq!(told(growing.to_numbers()), Err("block 1 of the predictor is not stable".into()));
    let slow = MonitorModel { lag: [0.0, 0.035], ..model() };
    assert_eq!(told(slow.to_numbers()), Err("lag share lies outside its range".into()));
}

#[test]
fn the_ends_of_a_range_belong_to_it() {
    type Set = fn(&mut MonitorModel, f32);
    let fields: [(&str, Set, [f32; 2]); 11] = [
        ("specific", |m, value| m.specific = value, [0.0, 1.0]),
        ("gain", |m, value| m.gain = value, [1e-6, 1e8]),
        ("gain", |m, value| m.gain = -value, [1e-6, 1e8]),
        ("delay_samples", |m, value| m.delay_samples = value, [0.0, 15.0]),
        ("delay_fraction", |m, value| m.delay_fraction = value, [0.0, 1.0]),
        ("lag share", |m, value| m.lag[0] = value, [1e-3, 1.0]),
        ("lag length", |m, value| m.lag[1] = value, [1e-3, 10.0]),
        ("friction_rate", |m, value| m.friction_rate = value, [1e-6, 1e8]),
        ("dead_zone", |m, value| m.tests[7].dead_zone = value, [0.0, 1e8]),
        ("calibration", |m, value| m.tests[0].calibration = value, [0.1, 1e3]),
        ("onset", |m, value| m.tests[3].onset[1] = value, [0.0, 1.0]),
    ];
    for (name, set, [low, high]) in fields {
        let with = |value| {
            let mut model = model();
            set(&mut model, value);
            model.check()
        };
        assert_eq!((with(low), with(high)), (Ok(()), Ok(())), "{name}");
        assert_eq!(with(low.next_down()), Err(Refusal::Range { name }));
        // beyond 10⁸ it is no number of a model, whatever it means
        let beyond = with(high.next_up());
        assert!(
            matches!(beyond, Err(Refusal::Range { name: told }) if told == name)
                || high == 1e8 && matches!(beyond, Err(Refusal::Number { .. })),
            "{name}: {beyond:?}"
        );
    }
}

/// A block is stable where both of its poles lie within the unit circle, wherever in it.
#[test]
fn a_block_is_refused_from_the_unit_circle_on() {
    let check = |block: [f32; 4]| MonitorModel { transition: [[0.0; 4], [0.0; 4], block], ..model() }.check();
    let refused = Err(Refusal::Unstable { block: 2 });
    for (first, second) in [(0.9_f32, -0.9_f32), (0.99, 0.99), (-0.99, -0.99), (0.99, 0.0), (-0.5, 0.25)] {
        // poles on the diagonal, and the same poles in companion form
        let (sum, product) = (first + second, first * second);
        for scale in [1.0_f32, 1.02] {
            let expected = if scale * first.abs().max(second.abs()) < 1.0 { Ok(()) } else { refused };
            assert_eq!(
                check([scale * first, 0.0, 0.0, scale * second]),
                expected,
                "{first} {second} {scale}"
            );
            let companion = [scale * sum, -scale * scale * product, 1.0, 0.0];
            assert_eq!(check(companion), expected, "{first} {second} {scale}");
        }
    }
    // a pair r e^(±iφ)
    for angle in [0.3_f32, 1.5, 2.8] {
        let turned = |r: f32| [r * angle.cos(), -r * angle.sin(), r * angle.sin(), r * angle.cos()];
        assert_eq!((check(turned(0.99)), check(turned(1.01))), (Ok(()), refused));
    }
    for pole in [1.0, -1.0] {
        assert_eq!(check([pole, 0.0, 0.0, 0.0]), refused);
        assert_eq!(check([pole, 0.0, 0.0, pole]), refused);
    }
    assert_eq!(check([0.0, -1.0, 1.0, 0.0]), refused);
}

proptest! {
    #[test]
    fn no_input_makes_it_panic_or_say_what_is_no_number(
        rows in prop::collection::vec((any::<f32>(), any::<f32>(), any::<f32>(), any::<bool>()), 1..600),
    ) {
        let monitor = monitor();
        let mut state = monitor.initial_state();
        for (tick, (q, theta, u, present)) in rows.into_iter().enumerate() {
            let observation =
                Observation { tick: tick as u32, measured: present.then_some([q, theta]), u_rad: u };
            let report = monitor.step(&mut state, &observation);
            prop_assert!(report.evidence.iter().chain(&report.innovation).all(|x| x.is_finite()));
            prop_assert!(report.background.is_finite());
        }
    }

    #[test]
    fn however_large_the_readings_it_stays_bounded(
        rows in prop::collection::vec((-99.0_f32..99.0, -99.0_f32..99.0, -99.0_f32..99.0), 200..800),
    ) {
        let monitor = monitor();
        let mut state = monitor.initial_state();
        for (tick, (q, theta, u)) in rows.into_iter().enumerate() {
            let observation = Observation { tick: tick as u32, measured: Some([q, theta]), u_rad: u };
            let report = monitor.step(&mut state, &observation);
            prop_assert!(report.evidence.iter().chain(&report.innovation).all(|x| x.is_finite()));
            if let Verdict::Changed(change) = report.verdict {
                prop_assert!(change.size.is_finite() && change.interval.is_finite());
            }
        }
    }
}

#[test]
fn what_is_not_watched_for_has_no_evidence() {
    for place in 0..4 {
        let monitor =
            MonitorConfig { watched: 1 << place, ..MonitorConfig::default() }.build(&model()).unwrap();
        let (mut state, mut plant) = (monitor.initial_state(), Plant { q: 0.0, noise: 5 });
        let mut seen = [false; CAUSES];
        for tick in 0..2000 {
            let u = if (tick / 30 + tick / 70) % 2 == 0 { 0.015 } else { -0.015 };
            let measured = Some(plant.step(u, if tick < 500 { GAIN } else { 0.4 * GAIN }));
            let report = monitor.step(&mut state, &Observation { tick, measured, u_rad: u });
            seen.iter_mut().zip(report.evidence).for_each(|(seen, evidence)| *seen |= evidence > 0.0);
        }
        assert!(seen.iter().enumerate().all(|(i, seen)| *seen == (i == place)), "{place}: {seen:?}");
        assert_ne!(state, monitor.initial_state());
        state.reset();
        assert_eq!(state, monitor.initial_state());
    }
}

#[test]
fn a_model_has_the_numbers_that_the_link_and_the_flash_have_room_for() {
    assert_eq!(NUMBERS, 138);
    assert_eq!(model().to_numbers().len(), NUMBERS);
    let last = model().to_numbers()[NUMBERS - 1];
    assert_eq!(last, model().tests[CAUSES - 1].sizes[5]);
}
