//! Counts what the control cycle costs. Made for the emulator with `-icount shift=0`, where one instruction takes one
//! nanosecond of SysTick: prints `name value` lines over semihosting and ends.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("the self-test runs on the chip; `cargo xtask chip-test` starts it in the emulator");
}

#[cfg(target_os = "none")]
mod count {
    use core::hint::black_box;
    use core::panic::PanicInfo;

    use cortex_m::Peripherals;
    use cortex_m::peripheral::SYST;
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::{debug, hprintln};
    use defmt_rtt as _;
    use estimator_core::constants::MAX_TAPS;
    use estimator_core::lms::{LmsConfig, LmsState, NormalizedLms};
    use estimator_core::monitor::{
        CAUSES, Monitor, MonitorConfig, MonitorModel, MonitorReport, MonitorState, Observation, Test,
    };
    use estimator_core::{Command, Config, Cycle, CycleState, Input, Sample};
    use firmware::pitch_filter::{Motion, PitchFilter};
    use firmware::servo::ServoConfig;
    use firmware::watch::Watch;
    use stm32f4xx_hal as _;

    const FULL: u32 = 0x00ff_ffff;
    /// SysTick counts in the 168 MHz that the emulator gives the chip, an instruction is a nanosecond.
    const fn instructions(ticks: u32) -> u32 {
        (ticks as u64 * 1000 / 168) as u32
    }

    fn ticks(counter: &mut SYST, mut run: impl FnMut()) -> u32 {
        counter.clear_current();
        let begin = SYST::get_current();
        run();
        begin.wrapping_sub(SYST::get_current()) & FULL
    }

    const ROUNDS: u32 = 64;
    /// Longest estimate that is counted.
    const MOST: usize = 256;

    fn nlms(counter: &mut SYST, taps: u16) {
        let config = LmsConfig { taps, ..LmsConfig::default() };
        let Ok(lms) = config.build::<MOST>() else { return };
        let mut state = LmsState::default();
        let mut signal = 1_u32;
        let mut next = || {
            signal = signal.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (signal >> 8) as f32 / 1e9
        };
        for _ in 0..300 {
            lms.observe(&mut state, next(), true);
            lms.push(&mut state, next());
        }
        let (q, u) = (next(), next());
        let spent = ticks(counter, || {
            for _ in 0..ROUNDS {
                update(&lms, &mut state, q, u);
            }
        });
        hprintln!("nlms_{} {}", taps, instructions(spent) / ROUNDS);
    }

    /// What is counted: one sample met, one input taken, the call included.
    #[inline(never)]
    fn update(lms: &NormalizedLms<MOST>, state: &mut LmsState<MOST>, q: f32, u: f32) {
        lms.observe(state, q, true);
        lms.push(state, u);
    }

    /// The most that one cycle takes, over a test of 3000 ticks on a vehicle that swings.
    fn cycle(counter: &mut SYST) {
        let mut config = Config::default();
        config.lms.taps = 64;
        let Ok(cycle) = config.build::<MAX_TAPS>() else { return };
        let mut state = cycle.initial_state();
        let (mut filter, mut most) = (PitchFilter::default(), 0);
        let mut signal = 1_u32;
        for tick in 0..3000_u32 {
            signal = signal.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (signal >> 8) as f32 / 16_777_216.0 - 0.5;
            let swing = libm::sinf(0.06 * tick as f32);
            let motion =
                Motion { q_rad_s: 0.3 * swing + 0.02 * noise, force_m_s2: [2.0 * swing + noise, 0.0, -9.6] };
            let command = if tick == 0 { Command::Start } else { Command::None };
            let spent = ticks(counter, || {
                black_box(one(&cycle, &mut state, &mut filter, black_box(&motion), tick, command));
            });
            most = spent.max(most);
        }
        hprintln!("cycle {}", instructions(most));
    }

    /// A model with six states and delay in which every cause is tested.
    fn model() -> MonitorModel {
        let test = Test {
            dead_zone: 0.05,
            calibration: 1.2,
            onset: [0.3, 0.1],
            sizes: [-0.6, -0.3, -0.15, 0.15, 0.3, 0.6],
        };
        MonitorModel {
            transition: [[0.9, 0.2, -0.2, 0.9], [0.7, 0.0, 0.0, 0.6], [0.95, 0.1, -0.1, 0.95]],
            moment: [0.02, 0.01, 0.03, 0.01, 0.002, 0.001],
            correction: [[0.1, 0.05, 0.02, 0.3, 0.01, 0.02], [0.2, 0.1, 0.01, 0.04, 0.1, 0.05]],
            output: [[3.0, 1.0, 2.0, 0.5, 1.0, 0.3], [0.3, 2.0, 0.1, 1.0, 0.5, 2.0]],
            whitening: [30.0, -5.0, 200.0],
            gain: 130.0,
            delay_samples: 2.0,
            delay_fraction: 0.4,
            lag: [0.4, 0.035],
            friction_rate: 0.01,
            trim: [0.5, 0.2],
            bias: [5.0, -1.0],
            tests: [test; CAUSES],
            ..MonitorModel::EMPTY
        }
    }

    /// The most that the monitor takes in a cycle, over 3000 of them.
    fn monitor(counter: &mut SYST) {
        let Ok(monitor) = MonitorConfig::default().build(&model()) else { return };
        let (mut state, mut most, mut signal) = (monitor.initial_state(), 0, 1_u32);
        for tick in 0..3000_u32 {
            signal = signal.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (signal >> 8) as f32 / 16_777_216.0 - 0.5;
            let swing = libm::sinf(0.06 * tick as f32);
            let seen = Observation {
                tick,
                measured: Some([0.3 * swing + 0.1 * noise, 0.1 * swing]),
                u_rad: 0.02 * swing,
            };
            let spent = ticks(counter, || {
                black_box(watched(&monitor, &mut state, black_box(&seen)));
            });
            most = spent.max(most);
        }
        hprintln!("monitor {}", instructions(most));
        hprintln!("monitor_state_bytes {}", size_of::<Monitor>() + size_of::<MonitorState>());
    }

    #[inline(never)]
    fn watched(monitor: &Monitor, state: &mut MonitorState, seen: &Observation) -> MonitorReport {
        monitor.step(state, seen)
    }

    /// The longest for which the link holds the control cycle back (`board/link.rs`), whatever arrives: it copies the taps, begins a
    /// test, or begins to watch.
    fn held_back(counter: &mut SYST) {
        let Ok(cycle) = Config::default().build::<MAX_TAPS>() else { return };
        let (mut kept, mut state) = (cycle, cycle.initial_state());
        let taps = ticks(counter, || {
            black_box(*black_box(&state).taps());
        });
        let start = ticks(counter, || {
            kept = *black_box(&cycle);
            state = kept.initial_state();
        });
        black_box((&kept, &state));
        let (mut watch, config, model) = (Watch::default(), MonitorConfig::default(), model());
        let arm = ticks(counter, || watch.begin(black_box(&config), Some(black_box(&model))));
        black_box(&watch);
        hprintln!("held_back {}", instructions(taps.max(start).max(arm)));
    }

    fn one(
        cycle: &Cycle<MAX_TAPS>,
        state: &mut CycleState<MAX_TAPS>,
        filter: &mut PitchFilter,
        motion: &Motion,
        tick: u32,
        command: Command,
    ) -> [f32; 2] {
        let now_us = u64::from(tick) * 20_000;
        let sample = Sample { time_us: now_us, q_rad_s: motion.q_rad_s, theta_rad: filter.step(motion) };
        let input = Input { tick, now_us, sample: Some(sample), theta_ref_rad: 0.0, command };
        ServoConfig::default().widths_us(cycle.step(state, &input).u_rad)
    }

    #[entry]
    fn main() -> ! {
        if let Some(core) = Peripherals::take() {
            let mut counter = core.SYST;
            counter.set_clock_source(SystClkSource::Core);
            counter.set_reload(FULL);
            counter.enable_counter();
            [16, 32, 50, 64, 128, 256].into_iter().for_each(|taps| nlms(&mut counter, taps));
            cycle(&mut counter);
            monitor(&mut counter);
            held_back(&mut counter);
            hprintln!(
                "core_state_bytes {}",
                size_of::<Cycle<MAX_TAPS>>() + size_of::<CycleState<MAX_TAPS>>()
            );
            debug::exit(debug::EXIT_SUCCESS);
        }
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[panic_handler]
    fn panic(info: &PanicInfo<'_>) -> ! {
        hprintln!("{}", info);
        debug::exit(debug::EXIT_FAILURE);
        loop {
            cortex_m::asm::wfi();
        }
    }
}
