//! A craft in gusts, nothing put in: held by an attitude controller, which then is what relates rate, angle and input; or held by
//! nothing, where that a model follows it from row to row is no proof of the model.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use sysid::diagnosis::answer::Verdict;
use sysid::recording::{ReadOptions, Recording, parse};

const STEP: f64 = 0.004;
const FINE: usize = 5;

fn normal(random: &mut Pcg64) -> f64 {
    (0..12).map(|_| random.random::<f64>() - 0.5).sum()
}

/// Ten seconds under u = −k_p θ − k_d q, decided in one row of `every`, by motors that lag: `gain` in rad/s² per unit, the loop's
/// frequency in rad/s.
fn hover(seed: u64, gain: f64, frequency: f64, every: usize) -> Recording {
    let mut random = Pcg64::seed_from_u64(seed);
    let (lag, delay, gusts, lasting) = (0.045, 2 * FINE, 3.0, 0.5);
    let (k_p, k_d) = (frequency * frequency / gain, 1.6 * frequency / gain);
    let dt = STEP / FINE as f64;
    let (mut rate, mut angle, mut motors, mut gust, mut command) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut on_the_way = vec![0.0; delay];
    let mut text = "t_s,u_norm,q_rad_s,theta_rad\n".to_owned();
    for k in 0..2500 {
        let (q, theta) = (rate + 0.015 * normal(&mut random), angle + 0.002 * normal(&mut random));
        if k % every == 0 {
            command = -k_p * theta - k_d * q;
        }
        text += &format!("{:.4},{command:.6},{q:.5},{theta:.5}\n", STEP * k as f64);
        for _ in 0..FINE {
            on_the_way.push(command);
            motors += dt * (on_the_way.remove(0) - motors) / lag;
            gust += -dt * gust / lasting + gusts * (2.0 * dt / lasting).sqrt() * normal(&mut random);
            rate += dt * (gain * motors - 0.8 * rate + gust);
            angle += dt * rate;
        }
    }
    parse("hover.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
}

#[test]
fn nothing_is_named_of_a_craft_that_its_controller_holds() {
    for (seed, gain, frequency, every) in
        [(1, 178.0, 6.0, 1), (2, 115.0, 8.0, 1), (3, 71.0, 5.0, 2), (4, 250.0, 7.0, 3), (5, 120.0, 4.0, 1)]
    {
        let answer =
            sysid::diagnosis::diagnose(&[hover(seed, gain, frequency, every)], None, &|_| {}).unwrap().answer;
        assert!(
            matches!(answer.verdict, Verdict::NotExcited | Verdict::Unlisted),
            "{seed}: {:?}: {}",
            answer.verdict,
            answer.summary
        );
    }
}

/// Six seconds of a damped body under gusts that last 0.3 s.
fn adrift(seed: u64) -> Recording {
    let step = 0.02_f64;
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut rate, mut angle, mut gust) = (0.0, 0.0, 0.0);
    let mut text = "t_s,u_norm,q_rad_s,theta_rad\n".to_owned();
    for k in 0..300 {
        gust += -step * gust / 0.3 + 3.0 * step.sqrt() * normal(&mut random);
        let before = rate;
        rate += step * (gust - rate);
        angle += step * (before + rate) / 2.0;
        let (q, theta) = (rate + 0.002 * normal(&mut random), angle + 0.001 * normal(&mut random));
        text += &format!("{:.2},0,{q:.5},{theta:.5}\n", step * f64::from(k));
    }
    parse("adrift.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
}

#[test]
fn a_body_that_gusts_drive_tells_nothing_where_nothing_is_commanded() {
    for seed in 1..=5 {
        let answer = sysid::diagnosis::diagnose(&[adrift(seed)], None, &|_| {}).unwrap().answer;
        assert_eq!(answer.verdict, Verdict::NotExcited, "{seed}: {}", answer.summary);
    }
}
