//! A sensor that is slower than its log, and a servo: what the rows are worth is how many readings there are.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use sysid::diagnosis::answer::{Answer, Verdict};
use sysid::recording::{NoteKind, ReadOptions, Recording, parse};

const STEP: f64 = 0.02;
const FINE: usize = 20;

fn normal(random: &mut Pcg64) -> f64 {
    (0..12).map(|_| random.random::<f64>() - 0.5).sum()
}

/// Forty seconds under a command in steps that comes 0.04 s late: the angle alone, read in one row of `every` and logged in each. `turned`
/// is the acceleration by delayed command, rate and angle.
fn logged(seed: u64, every: usize, turned: impl Fn(f64, f64, f64) -> f64) -> Recording {
    let mut random = Pcg64::seed_from_u64(seed);
    let dt = STEP / FINE as f64;
    let (mut rate, mut angle, mut reading, mut command, mut left) = (0.0, 0.0_f64, 0.0, 0.0, 30);
    let mut on_the_way = vec![0.0; 2];
    let mut text = "t_s,u_norm,theta_rad\n".to_owned();
    for k in 0..2000 {
        if left == 0 {
            command = 2.0 * random.random::<f64>() - 1.0;
            left = 15 + (50.0 * random.random::<f64>()) as usize;
        }
        left -= 1;
        if k % every == 0 {
            reading = angle + 0.002 * normal(&mut random);
        }
        text += &format!("{:.2},{command:.5},{reading:.4}\n", STEP * k as f64);
        on_the_way.push(command);
        let delayed = on_the_way.remove(0);
        for _ in 0..FINE {
            rate += dt * turned(delayed, rate, angle);
            angle += dt * rate;
        }
    }
    parse("bench.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
}

fn diagnosed(recording: Recording) -> Answer {
    sysid::diagnosis::diagnose(&[recording], None, &|_| {}).unwrap().answer
}

#[test]
fn a_pendulum_read_in_every_seventh_row_has_its_own_delay_and_not_the_sensors() {
    for (seed, every) in [(1, 4), (2, 7)] {
        let recording = logged(seed, every, |u, q, theta| 12.0 * u - 0.9 * q - 20.0 * theta.sin());
        let told = recording.notes.iter().any(|note| note.kind == NoteKind::Repeated);
        assert!(
            told && recording.unmeasured.iter().filter(|unmeasured| !**unmeasured).count()
                <= 2000 / every + 20
        );
        let answer = diagnosed(recording);
        assert_eq!(answer.verdict, Verdict::Named, "{}", answer.summary);
        assert_eq!(answer.effects[0].id, "gravity_stiffness");
        let delay = answer.told().parameters.iter().find(|p| p.name == "delay").unwrap();
        assert!((delay.value - 0.04).abs() < 0.003, "{} for 0.04 s", delay.value);
    }
}

#[test]
fn a_servo_at_its_limit_is_a_drive_that_holds_a_position() {
    let answer =
        diagnosed(logged(3, 1, |u, q, theta| (400.0 * (0.6 * u - theta)).clamp(-80.0, 80.0) - 36.0 * q));
    assert_eq!(answer.verdict, Verdict::Named, "{}", answer.summary);
    assert_eq!(answer.effects[0].id, "position_drive");
    let value = |name: &str| answer.effects[0].parameters.iter().find(|p| p.name == name).unwrap().value;
    assert!((value("k") / 400.0 - 1.0).abs() < 0.1, "{}", answer.summary);
    assert!((value("M_max") / 80.0 - 1.0).abs() < 0.1, "{}", answer.summary);
}
