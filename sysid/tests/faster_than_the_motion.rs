//! A rig that is logged at 100 Hz, faster than it moves: rows are averaged, the actuator sees the command as it was given, and a controller
//! has readings that are not in the log.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use sysid::diagnosis::answer::{Answer, Verdict};
use sysid::identify::compare::identify;
use sysid::recording::{ReadOptions, Recording, parse};

const STEP: f64 = 0.01;
const FINE: usize = 10;
/// ∂M/∂u, ∂M/∂q per unit inertia, and the delay in rows.
const GAIN: f64 = 300.0;
const DAMPING: f64 = 2.5;
const DELAY: usize = 3;

fn normal(random: &mut Pcg64) -> f64 {
    (0..12).map(|_| random.random::<f64>() - 0.5).sum()
}

/// Ninety seconds of a rigid body in coloured air. `commanded` makes the command of a row of the time, the reading that the
/// controller has of rate and angle, and a random number in -0.5..0.5; `acts` moves the blades, so much in a step, to what is commanded.
fn flown(
    seed: u64,
    mut commanded: impl FnMut(f64, [f64; 2], f64) -> f64,
    acts: impl Fn(f64, f64, f64) -> f64,
) -> Recording {
    let mut random = Pcg64::seed_from_u64(seed);
    let dt = STEP / FINE as f64;
    let (mut rate, mut angle, mut blades, mut air) = (0.0, 0.0, 0.0, [0.0; 2]);
    let mut on_the_way = vec![0.0; DELAY];
    let mut text = "t_s,u_rad,q_rad_s,theta_rad\n".to_owned();
    for k in 0..9000 {
        let reading = |random: &mut Pcg64| [rate + 0.02 * normal(random), angle + 0.002 * normal(random)];
        let own = reading(&mut random);
        let draw = random.random::<f64>() - 0.5;
        let command = commanded(STEP * k as f64, own, draw);
        let [q, theta] = reading(&mut random);
        text += &format!("{:.2},{command:.6},{q:.5},{theta:.5}\n", STEP * k as f64);
        on_the_way.push(command);
        let delayed = on_the_way.remove(0);
        for _ in 0..FINE {
            blades = acts(blades, delayed, dt);
            air[0] += dt * -12.6 * air[0] + (25.2 * dt).sqrt() * normal(&mut random);
            air[1] += dt * 12.6 * (air[0] - air[1]);
            rate += dt * (GAIN * blades - DAMPING * rate + 0.33 * air[1]);
            angle += dt * rate;
        }
    }
    parse("rig.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
}

/// A random command of two levels that keeps the angle in bounds.
fn excited(time: f64, [q, theta]: [f64; 2], draw: f64, level: &mut f64) -> f64 {
    if theta.abs() > 0.4 {
        return -0.012 * theta.signum() - 0.01 * q;
    }
    if ((time / STEP).round() as usize).is_multiple_of(10) {
        *level = 0.01_f64.copysign(draw);
    }
    *level
}

fn diagnosed(recording: Recording) -> Answer {
    sysid::diagnosis::diagnose(&[recording], None, &|_| {}).unwrap().answer
}

fn interval(answer: &Answer, name: &str) -> [f64; 2] {
    answer.told().parameters.iter().find(|p| p.name == name).unwrap().ci95
}

fn holds([low, high]: [f64; 2], truth: f64) -> bool {
    low < truth && truth < high
}

#[test]
fn a_controller_with_readings_of_its_own_is_no_free_play() {
    let mut within = 0;
    for seed in 1..=3 {
        let mut sum = 0.0;
        let pid = |time: f64, [q, theta]: [f64; 2], _: f64| {
            let target = 0.25 * [0.0, 1.0, 0.0, -1.0, 0.5, -0.5, 1.0, -1.0, 0.0][(time / 4.0) as usize % 9];
            sum += STEP * (target - theta);
            0.08 * (target - theta) + 0.02 * sum - 0.025 * q
        };
        let answer = diagnosed(flown(seed, pid, |_, command, _| command));
        let names: Vec<&str> = answer.effects.iter().map(|effect| effect.id.as_str()).collect();
        assert!(names.iter().all(|name| *name == "gust_disturbance"), "{}", answer.summary);
        assert!(matches!(answer.verdict, Verdict::NoMismatch | Verdict::Named), "{}", answer.summary);
        within += usize::from(holds(interval(&answer, "dM_du"), GAIN));
    }
    assert!(within >= 2, "{within} of 3 intervals hold the gain");
}

#[test]
fn a_servo_that_slews_is_found_with_its_limit_although_rows_are_averaged() {
    let mut level = 0.01;
    let slews = |blades: f64, command: f64, dt: f64| blades + (command - blades).clamp(-0.25 * dt, 0.25 * dt);
    let recording = flown(4, |time, own, draw| excited(time, own, draw, &mut level), slews);
    let answer = diagnosed(recording);
    assert_eq!(answer.verdict, Verdict::Named, "{}", answer.summary);
    assert_eq!(answer.effects[0].id, "servo_rate_limit", "{}", answer.summary);
    assert!((answer.effects[0].parameters[0].value / 0.25 - 1.0).abs() < 0.03, "{}", answer.summary);
    assert!(holds(interval(&answer, "delay"), 0.03), "{}", answer.summary);
}

#[test]
fn what_is_identified_of_averaged_rows_is_the_plants() {
    let mut level = 0.01;
    let recording = flown(5, |time, own, draw| excited(time, own, draw, &mut level), |_, command, _| command);
    let found = identify(&[recording], None, &|_| {}).unwrap();
    let gain = |parameters: &[sysid::estimate::Estimate]| {
        parameters.iter().find(|p| p.name == "dM_du").unwrap().value / GAIN - 1.0
    };
    let matched = gain(&found.hinf.as_ref().unwrap().parameters);
    assert!(matched.abs() < 0.03, "H-infinity: {matched}");
    for parameters in [&found.parameters, &found.parameters_coloured] {
        assert!(gain(parameters).abs() < 0.02, "{}", gain(parameters));
    }
}
