use super::fixture::{Flight, GAIN, fitted, flight, flown, held_in_the_air, model, normal, read, smoothed};
use super::*;
use crate::diagnosis::answer::Verdict;
use crate::diagnosis::diagnose;
use crate::diagnosis::estimates::estimates_of;
use crate::likelihood::fit::{Fit, fit_baseline};
use crate::model::baseline::Baseline;
use crate::recording::{ReadOptions, parse};
use rand::SeedableRng;
use rand_pcg::Pcg64;

fn compared(flight: &Flight, dm_du: Option<f64>) -> [DataCheck; 2] {
    let recordings = [flight.recording()];
    let data = Dataset::new(&recordings).unwrap();
    [motion::sign(&recordings, &data, dm_du), motion::unit(&recordings, &data)]
}

fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| factor * v).collect()
}

fn states(causes: &[DataCheck]) -> Vec<State> {
    causes.iter().map(|c| c.state).collect()
}

fn response(recording: &Recording, dm_du: f64) -> [DataCheck; 2] {
    fitted(recording, &model(dm_du, 0.06), |recordings, problem, fit: &Fit| {
        let response = Response::new(recordings, problem, estimates_of(problem, fit), Some(dm_du));
        [response.sign(false), response.unit()]
    })
}

fn loops(recording: &Recording, delay: f64) -> DataCheck {
    fitted(recording, &model(GAIN, delay), |recordings, problem, fit| {
        Loops::new(recordings, problem, fit).check()
    })
}

#[test]
fn a_sound_flight_is_cleared_of_everything() {
    let recording = flight(1, 0.0).recording();
    for cause in of_recordings(
        std::slice::from_ref(&recording),
        &Dataset::new(std::slice::from_ref(&recording)).unwrap(),
        Some(GAIN),
    ) {
        assert_eq!(cause.state, State::RuledOut, "{cause:?}");
    }
    let all = fitted(&recording, &model(GAIN, 0.06), |recordings, problem, fit| {
        let told = estimates_of(problem, fit);
        of_fit(recordings, problem, fit, told, Some(GAIN), &Loops::new(recordings, problem, fit))
    });
    assert_eq!(all.iter().map(|c| c.cause).collect::<Vec<_>>(), OF_FIT);
    assert_eq!(states(&all), [State::RuledOut; 5], "{all:?}");
}

#[test]
fn a_reversed_channel_is_told_from_the_other_by_the_response_to_the_input() {
    let sound = flight(1, 0.0);
    let rate = Flight { q: scaled(&sound.q, -1.0), ..sound.clone() };
    let angle = Flight { theta: scaled(&sound.theta, -1.0), ..sound.clone() };
    for (reversed, option) in [(rate, "'q_rad_s=q_rad_s*-1'"), (angle, "'theta_rad=theta_rad*-1'")] {
        let [sign, unit] = compared(&reversed, Some(GAIN));
        assert!(sign.stops() && sign.words.contains(option), "{sign:?}");
        assert_eq!(sign.words.matches("--column").count(), 1);
        assert_eq!(unit.state, State::RuledOut);
        let [sign, _] = compared(&reversed, None);
        assert!(sign.stops() && sign.words.matches("--column").count() == 2, "{sign:?}");
    }
}

#[test]
fn degrees_are_told_from_a_wrong_gain_of_the_gyro() {
    let sound = flight(1, 0.0);
    for (factor, found) in [(DEGREES, true), (1.0 / DEGREES, true), (1.3, false), (0.7, false)] {
        let spoilt = Flight { q: scaled(&sound.q, factor), ..sound.clone() };
        let [sign, unit] = compared(&spoilt, Some(GAIN));
        assert_eq!((sign.state, unit.stops()), (State::RuledOut, found), "{factor}: {unit:?}");
    }
    let spoilt = Flight { q: scaled(&sound.q, DEGREES), ..sound };
    assert!(compared(&spoilt, None)[1].words.contains("'q_rad_s=q_rad_s*0.01745329'"));
}

#[test]
fn rate_and_angle_that_contradict_each_other_are_told_with_both_factors() {
    let sound = flight(1, 0.0);
    let unit = |factor: f64, limit: f64| {
        let q = sound.q.iter().map(|q| (factor * q).clamp(-limit, limit)).collect();
        compared(&Flight { q, ..sound.clone() }, None)[1].clone()
    };
    for (factor, option) in [(0.2, "'q_rad_s=q_rad_s*5"), (8.0, "'theta_rad=theta_rad*8")] {
        let told = unit(factor, f64::INFINITY);
        assert!(told.stops() && told.words.contains(option), "{told:?}");
    }
    assert!(unit(60.0 / std::f64::consts::TAU, f64::INFINITY).words.contains("(turns per minute would fit)"));
    let fastest = sound.q.iter().fold(0.0_f64, |most, q| most.max(q.abs()));
    assert!(!unit(1.0, 0.15 * fastest).stops(), "a gyro that clips shows less");
    assert!(unit(8.0, 4.0 * fastest).stops(), "and not more");
    let farthest = sound.theta.iter().fold(0.0_f64, |most, theta| most.max(theta.abs()));
    let theta = sound.theta.iter().map(|theta| theta.clamp(-0.15 * farthest, 0.15 * farthest)).collect();
    let text = Flight { theta, ..sound.clone() }.text().replace("theta_rad", "arm");
    let options = ReadOptions { columns: vec!["theta_rad=arm".parse().unwrap()], ..ReadOptions::default() };
    let at_its_end = parse("log.csv", text.as_bytes(), &options).unwrap();
    assert!(noted(&at_its_end, NoteKind::Clipped, "theta_rad", "stays").is_some(), "by the file's name");
    let data = Dataset::new(std::slice::from_ref(&at_its_end)).unwrap();
    assert!(!motion::unit(&[at_its_end], &data).stops(), "an angle that clips shows less");
}

#[test]
fn a_slow_gyro_is_no_reversed_one_and_noise_tells_nothing() {
    let sound = flight(1, 0.0);
    let mut filtered = 0.0;
    let slow = sound.q.iter().map(|q| {
        filtered += 0.15 * (q - filtered);
        filtered
    });
    let slow = Flight { q: slow.collect(), ..sound.clone() };
    assert_eq!(states(&compared(&slow, Some(GAIN))), [State::RuledOut; 2]);
    let mut random = Pcg64::seed_from_u64(3);
    let noise = sound.theta.iter().map(|_| 0.01 * normal(&mut random)).collect();
    let noise = Flight { theta: noise, ..sound };
    assert_eq!(states(&compared(&noise, Some(GAIN))), [State::CannotTell; 2]);
}

#[test]
fn an_angle_of_another_motion_is_told() {
    let [one, other] = [flight(1, 0.0), flight(2, 0.0)];
    let [sign, _] = compared(&Flight { theta: other.theta, ..one }, Some(GAIN));
    assert!(sign.stops() && sign.words.contains("does not follow"), "{sign:?}");
}

#[test]
fn sign_and_unit_of_the_input_are_those_of_the_fitted_gain() {
    let sound = flight(1, 0.0);
    let spoilt = |factor: f64| Flight { u: scaled(&sound.u, factor), ..sound.clone() }.recording();
    let [sign, unit] = response(&spoilt(-1.0), GAIN);
    assert!(sign.stops() && sign.words.contains("'u_rad=u_rad*-1'"), "{sign:?}");
    assert_eq!(unit.state, State::RuledOut);
    let [sign, unit] = response(&spoilt(DEGREES), GAIN);
    assert!(unit.stops() && unit.words.contains("'u_rad=u_rad*0.01745329'"), "{unit:?}");
    assert_eq!(sign.state, State::RuledOut);
    let degrees =
        Flight { q: scaled(&sound.q, DEGREES), theta: scaled(&sound.theta, DEGREES), ..sound.clone() };
    let [_, unit] = response(&degrees.recording(), GAIN);
    assert!(unit.stops() && unit.words.contains("'theta_rad=theta_rad*0.01745329'"), "{unit:?}");
    // The user's value may be 30 % off, and three times as large is no unit either.
    assert_eq!(states(&response(&sound.recording(), 0.7 * GAIN)), [State::RuledOut; 2]);
    assert_eq!(states(&response(&sound.recording(), 5.0 * GAIN)), [State::RuledOut, State::CannotTell]);
}

#[test]
fn the_delay_that_the_data_want_is_told_in_samples() {
    let asked = |delay: f64| {
        let recording = flight(1, 0.0).recording();
        let found = diagnose(&[recording], Some(&model(GAIN, delay)), &|_| ()).unwrap();
        found.answer.data_checks.into_iter().find(|c| c.cause == "delay").unwrap()
    };
    let right = asked(0.06);
    assert!(right.state == State::RuledOut && right.words.contains("(3.00 samples)"), "{right:?}");
    let wrong = asked(0.1);
    assert_eq!((wrong.state, wrong.gravity), (State::Found, Gravity::Told), "{wrong:?}");
    assert!(wrong.words.contains("(5.00 samples): named as extra_delay"), "{wrong:?}");
}

#[test]
fn a_command_is_held_and_half_a_sample_of_delay_is_not_taken_for_one() {
    let asked = |recording: &Recording| {
        fitted(recording, &model(GAIN, 0.06), |_, problem, fit| timing::hold(problem, fit))
    };
    let mut recording = flight(1, 0.0).recording();
    assert_eq!(asked(&recording).state, State::RuledOut);
    recording.input_hold = crate::recording::InputHold::Interpolated;
    let wrong = asked(&recording);
    assert!(wrong.state == State::Found && wrong.words.contains("--input interpolated"), "{wrong:?}");
    let straight = asked(&flown(1, 0.05, [0.5, 0.5]).recording());
    assert_ne!(straight.state, State::RuledOut, "{straight:?}");
}

#[test]
fn feedback_is_found_where_it_is_and_a_wrong_delay_does_not_fake_it() {
    for seed in 1..5 {
        let open = loops(&flight(seed, 0.0).recording(), 0.06);
        assert_eq!(open.state, State::RuledOut, "{open:?}");
        let delayed = loops(&flight(seed, 0.0).recording(), 0.1);
        assert_eq!(delayed.state, State::RuledOut, "{delayed:?}");
        let closed = loops(&flight(seed, 0.1).recording(), 0.06);
        assert_eq!((closed.state, closed.gravity), (State::Found, Gravity::Headline), "{closed:?}");
        assert!(closed.words.contains("not open loop"));
    }
}

#[test]
fn a_controller_that_answers_within_the_row_is_not_taken_for_the_plant() {
    let recordings = [held_in_the_air(1)];
    let data = Dataset::new(&recordings).unwrap();
    let baseline = Baseline::from_data(&data);
    let problem = Problem::new(&data, &baseline, &[]);
    let fit = fit_baseline(&problem).unwrap();
    assert!(is_of_the_controller(&recordings, &problem, &fit), "{:?}", fit.minimum.values);
    let known = Baseline { input_first: true, ..baseline };
    let problem = Problem::new(&data, &known, &[]);
    let fit = fit_baseline(&problem).unwrap();
    let gain = fit.minimum.values[1] * 0.17 / GAIN;
    assert!((0.7..1.4).contains(&gain), "{gain}");
}

/// At 12 ms, what a quadrotor's controller makes of the rate, a row late in part, of its filtered slope, and of the angle.
fn held_a_row_late(seed: u64) -> Recording {
    const STEP: f64 = 0.012;
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut rate, mut angle, mut air, mut slope) = (0.0, 0.0, 0.0, 0.0);
    let (mut u, mut q): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut text = String::from("t_s,u_norm,q_rad_s\n");
    for k in 0..500_usize {
        let measured = rate + 0.02 * normal(&mut random);
        let before = *q.last().unwrap_or(&0.0);
        slope = 0.8 * slope + 0.2 * (measured - before) / STEP * 0.1;
        q.push(measured);
        u.push(-0.1 * (0.7 * before + 0.3 * measured + 0.1 * slope + angle) + 0.002 * normal(&mut random));
        text.push_str(&format!("{:.3},{:.5},{measured:.5}\n", STEP * k as f64, u[k]));
        air = 0.93 * air + 1.5 * normal(&mut random);
        rate += STEP * (130.0 * if k < 2 { 0.0 } else { u[k - 2] } + air);
        angle += STEP * rate;
    }
    read(&text)
}

#[test]
fn a_motion_that_leads_is_of_the_controller_where_no_stamps_explain_it() {
    let baseline_of = |recording: &Recording| {
        let recordings = [recording.clone()];
        let data = Dataset::new(&recordings).unwrap();
        let baseline = Baseline::from_data(&data);
        let problem = Problem::new(&data, &baseline, &[]);
        let fit = fit_baseline(&problem).unwrap();
        let leads = fit.delay(&problem) < -0.4 * problem.sizes.step;
        let unseen = !Loops::new(&recordings, &problem, &fit).all_closed();
        (leads, unseen, is_of_the_controller(&recordings, &problem, &fit))
    };
    let all: Vec<_> = (0..12).map(|seed| baseline_of(&held_a_row_late(seed))).collect();
    assert!(all.iter().all(|(leads, _, found)| !leads || *found), "{all:?}");
    assert!(all.iter().any(|(leads, unseen, _)| *leads && *unseen), "{all:?}");
    for seed in 1..4 {
        let mut late = flight(seed, 0.0);
        late.u.rotate_right(4);
        let (leads, _, found) = baseline_of(&late.recording());
        assert!(leads && !found, "{seed}");
    }
}

#[test]
fn of_a_motion_that_was_smoothed_no_lag_is_named_and_no_loop_told() {
    for seed in 1..4 {
        let flown = flight(seed, 0.0);
        // a section that is closed by design says nothing of one that was not asked
        let section = if seed == 3 { "IV" } else { flown.section };
        let flown = Flight { q: smoothed(&flown.q), theta: smoothed(&flown.theta), section, ..flown };
        let answer = diagnose(&[flown.recording()], None, &|_| {}).unwrap().answer;
        let gain = answer.fit.extended.parameters.iter().find(|p| p.name == "dM_du").unwrap().value;
        let share = gain / (GAIN / 0.1705);
        assert!((0.6..1.6).contains(&share), "{seed}: {share}");
        assert!(answer.summary.contains("smoothed both ways in time"), "{}", answer.summary);
        let named: Vec<_> = answer.effects.iter().map(|e| e.id.as_str()).collect();
        assert!(!matches!(answer.verdict, Verdict::Named | Verdict::Ambiguous), "{seed}: {named:?}");
        let state = |cause: &str| answer.data_checks.iter().find(|c| c.cause == cause).unwrap().state;
        assert_eq!([state("smoothing"), state("feedback")], [State::Found, State::CannotTell], "{seed}");
    }
}

#[test]
fn sections_that_are_closed_on_purpose_are_not_accused() {
    let closed = flight(1, 0.05);
    let mut led = closed.clone();
    led.reference.iter_mut().step_by(100).for_each(|r| *r = 0.1);
    for flight in [led, Flight { section: "IV", ..closed }] {
        let described = loops(&flight.recording(), 0.06);
        assert_eq!(described.state, State::CannotTell);
        assert!(described.words.contains("by design"), "{described:?}");
    }
}

#[test]
fn a_controller_that_answers_in_the_row_of_the_motion_is_found_there() {
    // what is measured and is no motion shows once: no later row knows of it
    let mut noisy = flight(1, 0.0);
    let mut random = Pcg64::seed_from_u64(3);
    for (u, q) in noisy.u.iter_mut().zip(&mut noisy.q) {
        let noise = 0.05 * normal(&mut random);
        *q += noise;
        *u -= 0.01 * noise;
    }
    let described = loops(&noisy.recording(), 0.06);
    assert_eq!(described.state, State::Found, "{described:?}");
    assert!(described.words.contains("of the same row"), "{described:?}");
}

#[test]
fn the_supervisor_is_told_as_a_fact() {
    let mut entered = flight(1, 0.0);
    entered.supervised[300..320].fill(true);
    let few = loops(&entered.recording(), 0.06);
    assert_eq!((few.state, few.gravity), (State::Found, Gravity::Told), "{few:?}");
    assert!(few.words.contains("1.0 % of I") && !few.words.contains("not open loop"), "{few:?}");
    entered.supervised[300..1700].fill(true);
    assert_eq!(loops(&entered.recording(), 0.06).gravity, Gravity::Headline);
    let unsaid = |flight: Flight| {
        fitted(&flight.recording(), &model(GAIN, 0.06), |recordings, problem, fit| {
            Loops::new(recordings, problem, fit).any_closed_unsaid()
        })
    };
    assert!(!unsaid(entered) && unsaid(flight(1, 0.1)));
}

#[test]
fn irregular_stamps_are_told() {
    let sound = flight(1, 0.0);
    let rows: Vec<String> = sound.text().lines().map(|line| line.to_owned() + "\n").collect();
    assert_eq!(channels::clock(&[read(&rows.concat())]).state, State::RuledOut);
    let gap = [&rows[..500], &rows[600..]].concat().concat();
    let double = [&rows[..500], &rows[499..]].concat().concat();
    for (text, word) in [(gap, "gap"), (double, "duplicate")] {
        let described = channels::clock(&[read(&text)]);
        assert!(described.state == State::Found && described.words.contains(word), "{described:?}");
    }
}

#[test]
fn more_than_a_hundred_per_cent_is_a_command_before_its_limit() {
    let saturation = |most: f64| {
        let text = flight(1, 0.0).text().replace("u_rad", "u_pct");
        let scale = format!("u_pct=u_pct*{}", most / 0.015);
        let options = ReadOptions { columns: vec![scale.parse().unwrap()], ..ReadOptions::default() };
        channels::saturation(&[parse("log.csv", text.as_bytes(), &options).unwrap()])
    };
    assert_eq!(saturation(101.0).state, State::RuledOut);
    let found = saturation(-300.0);
    assert!(
        found.stops() && found.words.contains("--column 'u_pct=limit(u_pct*-20000,-100,100)'"),
        "{found:?}"
    );
    let text = flight(1, 0.0).text().replace("u_rad", "u_pct");
    let wild = text.replacen(",0.015,", ",655.35,", 3);
    assert_ne!(wild, text);
    let spike = parse("log.csv", wild.as_bytes(), &ReadOptions::default()).unwrap();
    assert!(!channels::saturation(&[spike]).stops(), "a wild value is no command");
}

#[test]
fn plateaus_are_told_but_not_the_two_levels_of_an_excitation() {
    let sound = flight(1, 0.0);
    assert_eq!(channels::saturation(&[sound.recording()]).state, State::RuledOut);
    let clipped = Flight { q: sound.q.iter().map(|q| q.clamp(-0.3, 0.3)).collect(), ..sound.clone() };
    let described = channels::saturation(&[clipped.recording()]);
    assert!(described.state == State::Found && described.words.contains("q_rad_s stays at"), "{described:?}");
    let from_rest = |rest: f64| {
        let q = sound.q.iter().enumerate().map(|(k, q)| if k < 200 { rest } else { 1.5 + q }).collect();
        channels::saturation(&[Flight { q, ..sound.clone() }.recording()]).state
    };
    assert_eq!(
        [from_rest(0.0), from_rest(-0.1)],
        [State::RuledOut, State::Found],
        "a wheel that stands still"
    );
    let mut fed_back = flight(1, 0.05);
    assert_eq!(channels::saturation(&[fed_back.recording()]).state, State::RuledOut);
    fed_back.u.iter_mut().for_each(|u| *u = u.clamp(-0.02, 0.02));
    let described = channels::saturation(&[fed_back.recording()]);
    assert!(
        described.state == State::Found && described.words.contains("u_rad stays at 0.0200"),
        "{described:?}"
    );
    // two steps down and one up, commanded within the loop
    let mut stepped = flight(1, 0.05);
    let least = stepped.u.iter().copied().fold(0.0, f64::min) - 0.01;
    for (level, rows) in [(least, 800..830), (0.5 * least.abs(), 830..850), (least, 850..870)] {
        stepped.u[rows].fill(level);
    }
    assert_eq!(channels::saturation(&[stepped.recording()]).state, State::RuledOut);
    // a random sequence of two levels, drawn again in every sample
    let mut random = Pcg64::seed_from_u64(1);
    let mut drawn = || if normal(&mut random) > 0.0 { 0.02 } else { -0.02 };
    let levels = Flight { u: fed_back.u.iter().map(|_| drawn()).collect(), ..fed_back };
    assert_eq!(channels::saturation(&[levels.recording()]).state, State::RuledOut);
}

#[test]
fn dead_channels_are_told() {
    let sound = flight(1, 0.0);
    let dead = Flight { theta: vec![0.0; sound.theta.len()], ..sound.clone() };
    let described = channels::dead(&[dead.recording()]);
    assert!(described.stops() && described.words.contains("theta_rad is constant"), "{described:?}");
    let still = Flight { u: vec![0.01; sound.u.len()], ..sound.clone() };
    assert_eq!(channels::dead(&[still.recording()]).gravity, Gravity::Headline);
    let mut text = sound.text();
    for k in 0..300 {
        text += &format!("{:.2},0,{},0,III,0,0\n", 40.0 + 0.02 * f64::from(k), 0.01 * f64::from(k % 7));
    }
    let described = channels::dead(&[read(&text)]);
    assert!(described.state == State::Found && described.words.contains("in section III"), "{described:?}");
}

#[test]
fn a_cause_that_stops_leaves_no_physics_in_the_answer() {
    let sound = flight(1, 0.0);
    let reversed = Flight { q: scaled(&sound.q, -1.0), ..sound };
    let found = diagnose(&[reversed.recording()], Some(&model(GAIN, 0.06)), &|_| ()).unwrap();
    let answer = found.answer;
    assert_eq!((answer.verdict, answer.data_checks.len()), (Verdict::CheckData, 11));
    assert!(answer.effects.is_empty() && answer.remainder.is_none());
    assert!(answer.summary.contains("the rate is reversed"), "{}", answer.summary);
    assert!(answer.summary.starts_with("The angle theta_rad falls"), "{}", answer.summary);
}

#[test]
fn an_output_that_freezes_while_the_other_moves_is_named_with_the_part_to_keep() {
    let sound = flight(1, 0.0);
    let asked = |flight: &Flight| channels::dead(&[flight.recording()]);
    let mut frozen = sound.clone();
    let middle = sound.theta.iter().position(|&angle| angle > 0.0).unwrap().max(1200);
    frozen.theta[middle..middle + 200].fill(sound.theta[middle]);
    let check = asked(&frozen);
    let kept = format!("--section \"A=0.00..{:.2}\"", middle as f64 * 0.02);
    assert!(
        check.stops() && check.words.contains("theta_rad stays") && check.words.contains(&kept),
        "{check:?}"
    );

    let mut at_a_stop = sound.clone();
    let highest = sound.theta.iter().copied().fold(f64::MIN, f64::max);
    at_a_stop.theta[1200..1400].fill(highest);
    assert_eq!(asked(&at_a_stop).state, State::RuledOut);

    let mut at_rest = sound;
    for signal in [&mut at_rest.u, &mut at_rest.q, &mut at_rest.theta] {
        let value = signal[1800];
        signal[1800..].fill(value);
    }
    assert_eq!(asked(&at_rest).state, State::RuledOut);
}

#[test]
fn the_rows_as_logged_are_those_of_the_section_by_whatever_clock() {
    // 200 Hz from 37 s on, averaged; a controller closes the loop in the second half alone
    let mut random = Pcg64::seed_from_u64(4);
    let (mut rate, mut level, mut air) = (0.0, 0.0, 0.0);
    let mut text = String::from("t_s,u_N_m,q_rad_s,section\n");
    for k in 0..6000 {
        let open = k < 3000;
        level = if k % 10 == 0 { 0.2 * normal(&mut random) } else { level };
        let measured = rate + 0.01 * normal(&mut random);
        let u = level - if open { 0.0 } else { measured };
        let label = if open { "I" } else { "II" };
        text.push_str(&format!("{:.3},{u:.6},{measured:.6},{label}\n", 37.0 + 0.005 * f64::from(k)));
        air = 0.95 * air + 0.2 * normal(&mut random);
        rate += 0.005 * (5.0 * u - rate + air);
    }
    let recording = read(&text);
    let mut model = model(5.0, 0.0);
    model.plant.inertia_kg_m2 = 1.0;
    fitted(&recording, &model, |recordings, problem, fit| {
        assert!(problem.data.thinned > 1);
        let check = Loops::new(recordings, problem, fit).check();
        assert!(
            check.words.contains("section II is not open loop: in the rows as logged"),
            "{}",
            check.words
        );
        assert!(!check.words.contains("section I is"), "{}", check.words);
    });
}
