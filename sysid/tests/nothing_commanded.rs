//! A body that gusts drive while the command stands still: that a model follows it from row to row is no proof of the model.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use sysid::diagnosis::answer::Verdict;
use sysid::recording::{ReadOptions, Recording, parse};

const STEP: f64 = 0.02;

fn normal(random: &mut Pcg64) -> f64 {
    (0..12).map(|_| random.random::<f64>() - 0.5).sum()
}

/// Six seconds of a damped body under gusts that last 0.3 s.
fn adrift(seed: u64) -> Recording {
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut rate, mut angle, mut gust) = (0.0, 0.0, 0.0);
    let mut text = "t_s,u_norm,q_rad_s,theta_rad\n".to_owned();
    for k in 0..300 {
        gust += -STEP * gust / 0.3 + 3.0 * STEP.sqrt() * normal(&mut random);
        let before = rate;
        rate += STEP * (gust - rate);
        angle += STEP * (before + rate) / 2.0;
        let (q, theta) = (rate + 0.002 * normal(&mut random), angle + 0.001 * normal(&mut random));
        text += &format!("{:.2},0,{q:.5},{theta:.5}\n", STEP * f64::from(k));
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
