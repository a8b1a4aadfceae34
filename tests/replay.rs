//! What a recording holds is enough to fly the core again: fed with it, it sends the same commands and learns the same taps.

use estimator_core::constants::TAPS;
use estimator_core::{Command, Input, Sample};
use host_sim::{Background, Plant, Scenario, Setting, fly};
use sysid::recording::{ReadOptions, parse};

#[test]
fn a_recorded_test_replays_through_the_core_to_the_same_commands_and_taps() {
    for seed in [3, 4] {
        let mut scenario = Scenario::campaign(4, 0.015, seed).expect("campaign 4 exists");
        scenario.plant = Plant::drawn(seed);
        scenario.background = Background::Paper;
        scenario.effects = vec![Setting::usual("coulomb_friction", true).expect("the catalogue has it")];
        let flight = fly(&scenario).expect("the scenario flies");
        let text = flight.recording();
        let recording =
            parse("flight.csv", text.as_bytes(), &ReadOptions::default()).expect("the recording reads");
        let column = |column: &Option<Vec<f64>>| column.clone().expect("the simulator logs it");
        let [q, theta, reference] = [&recording.q, &recording.theta, &recording.theta_ref].map(column);

        let cycle = scenario.core().build::<TAPS>().expect("the configuration is legal");
        let mut state = cycle.initial_state();
        let mut overridden = 0;
        for k in 0..q.len() {
            let (tick, now_us) = (k as u32, k as u64 * 20_000);
            let sample = Sample { time_us: now_us, q_rad_s: q[k] as f32, theta_rad: theta[k] as f32 };
            let input = Input {
                tick,
                now_us,
                sample: Some(sample),
                theta_ref_rad: reference[k] as f32,
                command: if k == 0 { Command::Start } else { Command::None },
            };
            let told = cycle.step(&mut state, &input);
            assert_eq!(told.u_rad.to_bits(), (recording.u[k] as f32).to_bits(), "row {k}");
            assert_eq!(told.supervised, recording.supervised[k], "row {k}");
            overridden += u32::from(told.supervised);
        }
        assert!(overridden > 0, "the supervisor is met");
        assert_eq!(state.taps().map(f32::to_bits), flight.taps.map(f32::to_bits));
    }
}
