//! The sampled pitch model against closed forms, and its parameters found again.

use sysid::catalogue::find;
use sysid::dataset::{Amplitudes, RollAndYaw, Run};
use sysid::model::noise::Disturbance;
use sysid::model::pitch::{PitchModel, Term};
use sysid::model::plant::Plant;
use sysid::optim::levenberg_marquardt::{Coordinate, Effort, covariance, minimize};

const STEP: f64 = 0.02;
const PLANT: Plant = Plant { inertia: 0.1705, dm_dq: -0.27, dm_du: 23.0, delay: 0.05, mount: None };
const QUIET: Disturbance = Disturbance {
    intensity: 1.0,
    frequency: 2.2,
    damping: 2.4,
    zero: 1.0,
    angle_noise: 1.0,
    third: None,
    corrects: None,
};
const SIZES: Amplitudes = Amplitudes {
    inertia: 1.0,
    u: 0.015,
    q: 0.3,
    theta: 0.2,
    turned: 0.8,
    angles: [0.0; 3],
    moment: 0.345,
    moves: 0.0,
    step: STEP,
    duration: 4.0,
    rate_limit: None,
};

fn run(u: Vec<f64>) -> Run {
    Run {
        recording: 0,
        origin: 0.0,
        start: 0.0,
        step: STEP,
        held: true,
        between: None,
        command_news: None,
        leads: false,
        rate: Some(vec![0.0; u.len()]),
        angle: Some(vec![0.0; u.len()]),
        rate_limit: f64::INFINITY,
        beside: Default::default(),
        supervised: vec![false; u.len()],
        unmeasured: Vec::new(),
        sections: Vec::new(),
        u,
    }
}

fn free_run(plant: &Plant, terms: &[Term], u: Vec<f64>) -> Vec<[f64; 2]> {
    let run = run(u);
    let model = PitchModel::new(plant, terms, &QUIET, STEP, &SIZES).expect("the model is finite");
    model.simulate(&run, 0..run.len(), model.start(&run)).expect("the run stays finite")
}

/// A step of 0.01 rad at row 10.
fn step_input() -> Vec<f64> {
    (0..200).map(|k| if k < 10 { 0.0 } else { 0.01 }).collect()
}

#[test]
fn the_rigid_plant_answers_a_delayed_step_in_closed_form() {
    let simulated = free_run(&PLANT, &[], step_input());
    let decay = PLANT.dm_dq / PLANT.inertia;
    for (k, y) in simulated.iter().enumerate() {
        let t = (k as f64 * STEP - 10.0 * STEP - PLANT.delay).max(0.0);
        let q = PLANT.dm_du * 0.01 / -PLANT.dm_dq * (1.0 - (decay * t).exp());
        // A delay of two samples and a half: within a step the mean of the input stands for its course.
        assert!((y[0] - q).abs() < 2e-4, "row {k}: {} for {q}", y[0]);
    }
}

#[test]
fn the_thrust_answers_the_angle_that_the_servo_reaches_whichever_term_was_found_first() {
    let term = |id: &str, value: f64| Term {
        effect: find(id).expect("it is in the catalogue"),
        values: vec![value],
    };
    let (stop, curve) = (0.006, 20.0);
    let found = [term("thrust_curve", curve), term("servo_saturation", stop)];
    let other_way = [term("servo_saturation", stop), term("thrust_curve", curve)];
    let simulated = free_run(&PLANT, &found, step_input());
    assert_eq!(simulated, free_run(&PLANT, &other_way, step_input()));
    let reached = stop * (1.0 + curve * stop);
    let u: Vec<f64> = step_input().iter().map(|u| if *u > 0.0 { reached } else { 0.0 }).collect();
    let expected = free_run(&PLANT, &[], u);
    assert!(simulated.iter().zip(&expected).all(|(a, b)| (a[0] - b[0]).abs() < 1e-12));
}

#[test]
fn a_servo_lag_answers_a_step_in_closed_form() {
    let plant = Plant { delay: 0.06, ..PLANT };
    let lag = 0.1;
    let terms = [Term { effect: find("servo_lag").expect("it is in the catalogue"), values: vec![lag] }];
    let simulated = free_run(&plant, &terms, step_input());
    let (a, b) = (-plant.dm_dq / plant.inertia, 1.0 / lag);
    for (k, y) in simulated.iter().enumerate() {
        let t = (k as f64 * STEP - 10.0 * STEP - plant.delay).max(0.0);
        let rise = 1.0 - (b * (-a * t).exp() - a * (-b * t).exp()) / (b - a);
        let q = plant.dm_du * 0.01 / -plant.dm_dq * rise;
        assert!((y[0] - q).abs() < 5e-4, "row {k}: {} for {q}", y[0]);
    }
}

#[test]
fn rotors_turn_the_body_back_as_their_own_speed_follows_the_command() {
    let (lag, reaction) = (0.08, 1.5);
    let term = |id: &str, value: f64| Term {
        effect: find(id).expect("it is in the catalogue"),
        values: vec![value],
    };
    let plant = Plant { dm_dq: 0.0, delay: 0.06, ..PLANT };
    let simulated =
        free_run(&plant, &[term("rotor_reaction", reaction), term("servo_lag", lag)], step_input());
    for (k, y) in simulated.iter().enumerate() {
        let t = (k as f64 * STEP - 10.0 * STEP - plant.delay).max(0.0);
        let risen = 1.0 - (-t / lag).exp();
        let q = 0.01 / plant.inertia * (plant.dm_du * (t - lag * risen) + reaction * risen);
        assert!((y[0] - q).abs() < 1e-12, "row {k}: {} for {q}", y[0]);
    }
}

#[test]
fn rotors_that_follow_at_once_kick_the_body_where_the_command_jumps() {
    let reaction =
        Term { effect: find("rotor_reaction").expect("it is in the catalogue"), values: vec![1.5] };
    // two samples and a quarter: within a substep
    let plant = Plant { dm_dq: 0.0, dm_du: 0.0, delay: 0.045, ..PLANT };
    let simulated = free_run(&plant, &[reaction], step_input());
    let jump = 1.5 * 0.01 / plant.inertia;
    assert!(
        simulated.iter().enumerate().all(|(k, y)| (y[0] - if k < 13 { 0.0 } else { jump }).abs() < 1e-12)
    );
    // and the angle shows when: three quarters of a sample before row 13
    assert!((simulated[13][1] - 0.75 * STEP * jump).abs() < 1e-9, "{}", simulated[13][1]);
}

#[test]
fn a_spring_keeps_its_period() {
    let plant = Plant { dm_dq: 0.0, delay: 0.0, ..PLANT };
    let k3 = find("gravity_stiffness").expect("it is in the catalogue");
    let terms = [Term { effect: k3, values: vec![2.0] }];
    let mut run = run(vec![0.0; 500]);
    run.angle = Some(vec![0.01; 500]);
    let model = PitchModel::new(&plant, &terms, &QUIET, STEP, &SIZES).expect("the model is finite");
    let simulated = model.simulate(&run, 0..500, model.start(&run)).expect("the run stays finite");
    let omega = (2.0f64 / plant.inertia).sqrt();
    for (k, y) in simulated.iter().enumerate() {
        let expected = 0.01 * (omega * k as f64 * STEP).cos();
        assert!((y[1] - expected).abs() < 1e-4, "row {k}: {} for {expected}", y[1]);
    }
}

/// Rates of a body without inertia to speak of (Mc/J = 80 rad/s²) over which a friction of 14 N m acts.
fn rubbed(id: &str, values: &[f64], moment: impl Fn(usize) -> f64) -> Vec<f64> {
    let plant = Plant { dm_dq: 0.0, dm_du: 1.0, delay: 0.0, ..PLANT };
    let terms = [Term { effect: find(id).expect("it is in the catalogue"), values: values.to_vec() }];
    let run = run((0..200).map(moment).collect());
    let sizes = Amplitudes { q: 1.0, moment: 20.0, ..SIZES };
    let model = PitchModel::new(&plant, &terms, &QUIET, STEP, &sizes).expect("the model is finite");
    model.simulate(&run, 0..200, model.start(&run)).expect("it stays finite").iter().map(|y| y[0]).collect()
}

#[test]
fn dry_friction_holds_at_rest_and_never_turns_the_motion_round() {
    let pulse = |k: usize| if k < 10 { 20.0 } else { 13.9 };
    let rates = rubbed("coulomb_friction", &[14.0], pulse);
    for (k, rate) in rates.iter().take(11).enumerate() {
        let expected = 6.0 / 0.1705 * k as f64 * STEP;
        assert!((rate - expected).abs() < 1e-9, "row {k}: {rate} for {expected}");
    }
    let fall = 0.1 / 0.1705 * STEP;
    assert!(rates.windows(2).skip(10).all(|w| (w[1] - (w[0] - fall).max(0.0)).abs() < 1e-9));
    let against = |k: usize| if k < 2 { 20.0 } else { -13.9 };
    let rates = rubbed("coulomb_friction", &[14.0], against);
    assert!(rates.iter().all(|q| *q >= 0.0) && rates[10..].iter().all(|q| *q == 0.0), "{:?}", &rates[..12]);
}

#[test]
fn stiction_breaks_away_at_its_own_moment_and_slides_at_another() {
    let stiction = [10.0, 14.0, 0.2];
    assert!(rubbed("stribeck_friction", &stiction, |_| 13.9).iter().all(|q| *q == 0.0));
    let sliding = rubbed("stribeck_friction", &stiction, |_| 14.1);
    let fast = (sliding[199] - sliding[198]) / STEP;
    assert!((fast - 4.1 / 0.1705).abs() < 1e-9, "{fast}");
    let asymmetric = |moment: f64| rubbed("asymmetric_friction", &[3.0, 5.0], |_| moment)[199];
    assert_eq!((asymmetric(2.9), asymmetric(-4.9)), (0.0, 0.0));
    assert!(asymmetric(3.1) > 0.0 && asymmetric(-5.1) < 0.0);
}

#[test]
fn least_squares_finds_a_line_and_its_covariance() {
    let x: Vec<f64> = (0..400).map(|k| f64::from(k) / 400.0).collect();
    // A deterministic stand-in for white noise of variance 1/12.
    let noise: Vec<f64> = (0..400).map(|k| (f64::from(k) * 0.618_033_988_749_895).fract() - 0.5).collect();
    let residuals = |p: &[f64]| {
        Some(x.iter().zip(&noise).map(|(x, e)| [2.0 + 3.0 * x + e - p[0] - p[1] * x, 0.0]).collect())
    };
    let free = |name: &str| Coordinate {
        name: name.into(),
        unit: "1".into(),
        bounds: [-100.0, 100.0],
        log: false,
        unit_step: 1.0,
        prior: None,
    };
    let coordinates = [free("offset"), free("slope")];
    let effort = Effort { iterations: 30, tolerance: 1e-9 };
    let minimum = minimize(&residuals, 1, &coordinates, &[0.0, 0.0], effort).expect("it is finite");
    assert!(
        (minimum.values[0] - 2.0).abs() < 0.05 && (minimum.values[1] - 3.0).abs() < 0.1,
        "{:?}",
        minimum.values
    );
    let found = covariance(&residuals, 1, &coordinates, &minimum.values, 0).expect("it is regular");
    let slope = (1.0 / 12.0) / (400.0 / 12.0);
    assert!((found[(1, 1)] / slope - 1.0).abs() < 0.1, "{} for {slope}", found[(1, 1)]);
}

/// Banked by φ at a yaw rate r, θ̇ = q cos φ − r sin φ, and the rate is as in a vehicle that is level.
#[test]
fn a_banked_turn_carries_the_angle_and_leaves_the_rate() {
    let (sine, cosine) = 0.4_f64.sin_cos();
    let mut banked = run(step_input());
    let turn = RollAndYaw { p: 0.0, r: 0.7, shortening: cosine - 1.0, carried: -0.7 * sine };
    banked.beside.roll_and_yaw = Some(vec![turn; banked.len()]);
    let friction = find("coulomb_friction").expect("it is in the catalogue");
    // with a term that cuts samples into substeps, and without
    for terms in [Vec::new(), vec![Term { effect: friction, values: vec![0.02] }]] {
        let level = free_run(&PLANT, &terms, step_input());
        let model = PitchModel::new(&PLANT, &terms, &QUIET, STEP, &SIZES).expect("the model is finite");
        let simulated =
            model.simulate(&banked, 0..banked.len(), model.start(&banked)).expect("it stays finite");
        let mut angle = 0.0;
        for k in 0..simulated.len() {
            assert_eq!(simulated[k][0], level[k][0]);
            assert!((simulated[k][1] - angle).abs() < 2e-5, "{k}: {:?} {angle}", simulated[k]);
            // the level vehicle's angle is the integral of q
            let pitched = level.get(k + 1).map_or(0.0, |next| next[1] - level[k][1]);
            angle += pitched * cosine - 0.7 * sine * STEP;
        }
    }
}

#[test]
fn the_collective_thrust_is_a_command_and_comes_as_late_as_the_other() {
    const LAG: f64 = 0.08;
    const K: f64 = 1.5;
    let term = |id: &str, values: &[f64]| Term { effect: find(id).unwrap(), values: values.to_vec() };
    let of = |thrust: f64| {
        let mut flown = run(vec![0.01; 100]);
        let mut above = vec![0.0; 100];
        above[20..].fill(thrust);
        flown.beside.thrust = Some(above);
        let terms = [term("servo_lag", &[LAG]), term("thrust_dependence", &[K])];
        let model = PitchModel::new(&PLANT, &terms, &QUIET, STEP, &SIZES).unwrap();
        model.drives(&flown, 100)
    };
    let (with, without) = (of(0.2), of(0.0));
    let substeps = with.len() / 100;
    for (i, (with, without)) in with.iter().zip(&without).enumerate().skip(1) {
        // the mean over the substep of what a lag makes of a step that comes a delay later
        let dt = STEP / substeps as f64;
        let since = i as f64 * dt - 20.0 * STEP - PLANT.delay;
        let lagged = if since < -1e-9 {
            0.0
        } else {
            1.0 - (-since / LAG).exp() * (1.0 - (-dt / LAG).exp()) * LAG / dt
        };
        let grown = with.blades / without.blades - 1.0;
        assert!((grown - K * 0.2 * lagged).abs() < 1e-9, "{i}: {grown} {lagged}");
    }
}
