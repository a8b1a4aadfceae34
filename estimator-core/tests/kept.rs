//! Every bit that core and monitor give is kept, for a test that meets upsets, faults and a change of each kind: whoever alters
//! one alters it on purpose, and writes the new digests here. What the bits should be is said by the other tests.

use estimator_core::constants::TAPS;
use estimator_core::monitor::{CAUSES, MonitorConfig, MonitorModel, Observation, SIZES, Test};
use estimator_core::plan::PlanConfig;
use estimator_core::{Command, Config, Input, Sample, Telemetry};

/// FNV-1a over bits and texts.
struct Digest(u64);

impl Digest {
    const START: Self = Self(0xcbf2_9ce4_8422_2325);

    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn numbers(&mut self, numbers: &[f32]) {
        numbers.iter().for_each(|number| self.bytes(&number.to_bits().to_le_bytes()));
    }
}

/// Uniform in ±1, by a generator whose every bit is known.
struct Random(u32);

impl Random {
    fn draw(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }
}

/// An airframe with three samples of delay, by steps of 2 ms.
struct Airframe {
    q: f32,
    theta: f32,
    line: [f32; 4],
}

impl Airframe {
    fn step(&mut self, u: f32, [gain, damping, friction, stiffness, moment]: [f32; 5]) {
        self.line.rotate_right(1);
        self.line[0] = u;
        for _ in 0..10 {
            let dry = friction * self.q / (self.q.abs() + 0.01);
            let acceleration = gain * self.line[3] - damping * self.q - dry - stiffness * self.theta + moment;
            self.q += 2e-3 * acceleration;
            self.theta += 2e-3 * self.q;
        }
    }
}

const AT_REST: Airframe = Airframe { q: 0.0, theta: 0.0, line: [0.0; 4] };
const USUAL: [f32; 5] = [134.9, 1.583, 0.0, 0.0, 0.0];

fn told(digest: &mut Digest, report: &Telemetry) {
    let Telemetry { sample, u_rad, excitation_rad, theta_ref_rad, convergence, .. } = report;
    if let Some(sample) = sample {
        digest.numbers(&[sample.q_rad_s, sample.theta_rad]);
    }
    digest.numbers(&[*u_rad, *excitation_rad, *theta_ref_rad, report.prediction_error_rad_s]);
    digest.numbers(&[convergence.settling, convergence.gain_drift, convergence.innovation_ratio]);
    let event = report.event.map_or(String::new(), |event| event.to_string());
    let words = format!(
        "{} {:?} {} {event} {:?} {}",
        report.section, report.phase, report.supervised, convergence.verdict, report.recoveries
    );
    digest.bytes(words.as_bytes());
}

/// One digest for each 250 cycles of a test under `config`.
fn flown(config: &Config, ticks: u32) -> Vec<u64> {
    let cycle = config.build::<TAPS>().unwrap();
    let (mut state, mut random, mut craft) = (cycle.initial_state(), Random(7), AT_REST);
    let (mut digest, mut digests) = (Digest::START, Vec::new());
    for tick in 0..ticks {
        let noise = [0.01 * random.draw(), 0.005 * random.draw()];
        // readings fail for a while: missing, late, beyond what a sensor reads
        let lost = tick % 1100 > 1095;
        let late = if tick % 1300 == 900 { 30_000 } else { 0 };
        let wild = if tick % 1700 == 1200 { 50.0 } else { 0.0 };
        let now_us = u64::from(tick) * 20_000;
        let sample = (!lost).then_some(Sample {
            time_us: now_us.saturating_sub(late),
            q_rad_s: craft.q + noise[0] + wild,
            theta_rad: craft.theta + noise[1],
        });
        let command = if tick == 5 { Command::Start } else { Command::None };
        let theta_ref_rad = 0.3 * random.draw();
        let report = cycle.step(&mut state, &Input { tick, now_us, sample, theta_ref_rad, command });
        told(&mut digest, &report);
        digest.numbers(state.taps());
        // a gust every 20 s
        let gust = if tick % 1000 < 30 { 3.0 } else { 0.0 };
        craft.step(report.u_rad, [USUAL[0], USUAL[1], USUAL[2], USUAL[3], gust]);
        if tick % 250 == 249 {
            digests.push(digest.0);
        }
    }
    digests
}

/// Two channels, six states, a fraction of a delay: every number counts. It is no model of the airframe, so that there is evidence.
fn model() -> MonitorModel {
    let mut random = Random(3);
    let mut about = |centre: f32, spread: f32| centre + spread * random.draw();
    let mut test = |unit: f32| Test {
        dead_zone: 0.2 * unit,
        calibration: about(1.3, 0.2),
        onset: [about(0.3, 0.1), about(0.1, 0.02)],
        sizes: [-3.0, -1.5, -0.7, 0.7, 1.5, 3.0].map(|size| size * unit),
    };
    let tests = [0.15, 0.03, 0.05, 0.3, 0.05, 0.02, 0.15, 0.3].map(&mut test);
    MonitorModel {
        transition: [
            [about(0.85, 0.02), about(0.05, 0.01), about(-0.05, 0.01), about(0.85, 0.02)],
            [about(0.6, 0.05), about(0.1, 0.02), about(-0.1, 0.02), about(0.6, 0.05)],
            [about(0.3, 0.05), 0.0, 0.0, about(0.2, 0.05)],
        ],
        moment: [0.2, 0.02, 0.03, -0.02, 0.01, 0.01].map(|value| about(value, 0.005)),
        correction: [[0.1, 0.02, 0.03, 0.02, 0.01, 0.01], [0.02, 0.1, 0.02, 0.03, 0.01, -0.01]]
            .map(|column| column.map(|value: f32| about(value, 0.005))),
        output: [[9.0, 1.0, 2.0, 1.0, 0.5, -0.5], [1.0, 12.0, -1.0, 2.0, 0.5, 0.5]]
            .map(|row| row.map(|value: f32| about(value, 0.3))),
        whitening: [25.0, 3.0, 40.0],
        rest: [0.05, -0.03],
        specific: 1.0,
        gain: 134.9,
        delay_samples: 2.0,
        delay_fraction: 0.4,
        lag: [0.4, 0.035],
        friction_rate: 0.01,
        trim: [about(4.0, 0.5), about(3.0, 0.5)],
        bias: [about(15.0, 1.0), about(5.0, 1.0)],
        tests,
    }
}

/// One digest for a flight in which `change` sets in.
fn watched(model: &MonitorModel, change: [f32; 5], bias: f32) -> u64 {
    let monitor = MonitorConfig::default().build(model).unwrap();
    let (mut state, mut random, mut craft) = (monitor.initial_state(), Random(11), AT_REST);
    let mut digest = Digest::START;
    digest.numbers(&[monitor.threshold()]);
    for tick in 0..3000_u32 {
        // readings that cannot be used: missing, no number, frozen
        let q = match tick {
            1400 => f32::NAN,
            1700..1760 => 0.25,
            _ => craft.q + 0.03 * random.draw() + if tick > 900 { bias } else { 0.0 },
        };
        let theta = if (1700..1760).contains(&tick) { 0.1 } else { craft.theta + 0.02 * random.draw() };
        let u = if (tick / 13 + tick / 29 + tick / 47) % 2 == 0 { 0.015 } else { -0.015 };
        let measured = (tick != 1200).then_some([q, theta]);
        let report = monitor.step(&mut state, &Observation { tick, measured, u_rad: u });
        digest.numbers(&report.innovation);
        digest.numbers(&report.evidence);
        digest.numbers(&[report.background]);
        digest.bytes(format!("{} {}", report.verdict, report.changed).as_bytes());
        let strength = if tick > 2500 { 3.0 } else { 1.0 };
        let mut law = if tick > 900 { change } else { USUAL };
        law[4] += 2.0 * strength * random.draw() - 12.0 * craft.theta;
        craft.step(u, law);
    }
    digest.0
}

/// The model with the tests for one cause alone.
fn alone(mut model: MonitorModel, place: usize) -> MonitorModel {
    model.specific = 0.0;
    let others = model.tests.iter_mut().enumerate().filter(|(i, _)| *i != place);
    others.for_each(|(_, test)| test.sizes = [0.0; SIZES]);
    model
}

#[test]
fn a_whole_test() {
    let plan = PlanConfig { lead_in_s: 0.5, section_s: 15.0, pause_s: 2.0, closed_loop_s: 15.0 };
    let found = flown(&Config { seed: 3, plan, ..Config::default() }, 3750);
    println!("{found:#x?}");
    assert_eq!(found, FLOWN);
}

#[test]
fn what_the_monitor_says() {
    let [gain, damping, ..] = USUAL;
    let changes: [([f32; 5], f32); CAUSES] = [
        (USUAL, 0.0),
        ([0.6 * gain, damping, 0.0, 0.0, 0.0], 0.0),
        ([1.5 * gain, damping, 0.0, 0.0, 0.0], 0.0),
        ([gain, damping, 0.0, 0.0, 2.0], 0.0),
        ([gain, 4.0 * damping, 0.0, 0.0, 0.0], 0.0),
        ([gain, damping, 1.0, 0.0, 0.0], 0.0),
        ([gain, damping, 0.0, 9.0, 0.0], 0.0),
        (USUAL, 0.1),
    ];
    let whole = model();
    // all causes together, then each alone
    let together = changes.iter().map(|(change, bias)| watched(&whole, *change, *bias));
    let each =
        changes.iter().enumerate().map(|(i, (change, bias))| watched(&alone(whole, i), *change, *bias));
    let found: Vec<u64> = together.chain(each).collect();
    println!("{found:#x?}");
    assert_eq!(found, WATCHED);
}

const FLOWN: [u64; 15] = [
    0x9aac_a4df_693d_1196,
    0xd2b3_d34d_798d_4e9d,
    0x0ff6_7058_c9bb_6b1a,
    0xd26f_4fc0_7726_8399,
    0xe5c7_ca9a_db10_daf0,
    0x5a59_4838_892f_e10e,
    0xc932_421b_f2ee_1dca,
    0x9111_e821_185e_3418,
    0x8123_a743_2697_57c3,
    0xd6e7_44b9_687c_f761,
    0x97c9_0ed1_2823_a10f,
    0x8da8_9b94_8f24_a3d0,
    0x41be_f2e9_1bb6_c676,
    0x5676_e0c6_8c81_378b,
    0xa7f3_114b_8f38_7da3,
];

const WATCHED: [u64; 2 * CAUSES] = [
    0x599a_a7e6_6dfd_ae1f,
    0x4601_3725_9384_77f3,
    0x17e0_02c1_eccc_a0bc,
    0x67c3_bf25_6d36_80b2,
    0xd8ac_5834_77d7_96ef,
    0x025f_34c8_48a0_042f,
    0x7c52_769e_5cff_bf62,
    0x6622_e193_1a87_7c13,
    0x9f6c_f8e4_f52b_1b34,
    0xcebb_1441_5f90_7270,
    0x07fa_ea22_bd86_4507,
    0xc5b5_4ad1_71b2_fd7f,
    0xa9f6_4f79_bdf7_54d3,
    0xeb4e_d0bf_5328_12a1,
    0x1c8f_f393_1869_0de0,
    0xa9f9_d20e_2ae3_cb3d,
];
