//! The STM32F405 board: clocks, pins, peripherals.
//!
//! | what | where |
//! | --- | --- |
//! | control cycle | TIM2, 50 Hz |
//! | link | USART2, PA2 transmit, PA3 receive, 230400 baud |
//! | settings, the monitor's model | the last four sectors of the flash |
//! | IMU | SPI1, PA5 clock, PA6 from the chip, PA7 to the chip, PA4 select |
//! | collective servos | TIM4, PB6 front rotor, PB7 rear rotor, 200 Hz |

pub mod clock;
pub mod control;
pub mod failsafe;
pub mod flash;
pub mod link;
pub mod uart;

use defmt_rtt as _;
use embedded_hal::delay::DelayNs;
use embedded_hal_bus::spi::ExclusiveDevice;
use firmware::imu::Imu;
use firmware::reset_record::Cause;
use firmware::servo::{ServoConfig, Servos};
use firmware::settings::Memory;
use stm32f4xx_hal::gpio::{Output, Pin};
use stm32f4xx_hal::pac::{self, SPI1, TIM2, TIM4, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{self, Rx, Tx};
use stm32f4xx_hal::spi::{Mode, Phase, Polarity, Spi};
use stm32f4xx_hal::timer::{CounterHz, Event, PwmChannel, SysDelay};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Rate of the control cycle, Hz.
pub const RATE_HZ: u32 = 50;
const BAUD: u32 = 230_400;
/// Three cycles and a little: the dog bites when none of them met its deadline.
const WATCHDOG_MS: u32 = 70;

pub type BoardImu = Imu<ExclusiveDevice<Spi<SPI1>, Pin<'A', 4, Output>, Spin>>;
pub type BoardServos = Servos<PwmChannel<TIM4, 0>, PwmChannel<TIM4, 1>>;
pub type Timer = CounterHz<TIM2>;

/// A wait within a transfer, exact at 168 MHz and longer below. No driver here asks for one, but the device without any
/// panics when asked.
pub struct Spin;

impl DelayNs for Spin {
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay((ns / 1000).saturating_add(1).saturating_mul(168));
    }
}

/// What the tasks are given.
pub struct Parts {
    pub control: control::Control,
    pub tx: Tx<USART2>,
    pub rx: Rx<USART2>,
    /// Why the board was reset, if it kept a reason.
    pub cause: Option<Cause>,
    pub clock_hz: u32,
    pub memory: Memory<flash::Sectors>,
}

/// Brings the board up: servos to neutral first, then the rest.
pub fn start(device: pac::Peripherals, core: cortex_m::Peripherals) -> Parts {
    let cause = failsafe::cause(&device.RCC);
    let mut rcc = clock::start(device.RCC);
    let clock_hz = rcc.clocks.sysclk().raw();
    let gpioa = device.GPIOA.split(&mut rcc);
    let gpiob = device.GPIOB.split(&mut rcc);

    let period = (ServoConfig::default().period_us as u32).micros();
    let (_, (front, rear, ..)) = device.TIM4.pwm_us(period, &mut rcc);
    let (mut front, mut rear) = (front.with(gpiob.pb6), rear.with(gpiob.pb7));
    front.enable();
    rear.enable();
    let Ok(servos) = Servos::new(ServoConfig::default(), front, rear) else {
        failsafe::give_up(Cause::Panic { line: line!() })
    };
    failsafe::watch_supply(&device.PWR, &device.EXTI, &mut rcc);

    let mut delay = core.SYST.delay(&rcc.clocks);
    let mode = Mode { polarity: Polarity::IdleHigh, phase: Phase::CaptureOnSecondTransition };
    let pins = (Some(gpioa.pa5), Some(gpioa.pa6), Some(gpioa.pa7));
    let spi = Spi::new(device.SPI1, pins, mode, 1.MHz(), &mut rcc);
    let select = gpioa.pa4.into_push_pull_output_in_state(stm32f4xx_hal::gpio::PinState::High);
    let imu = sensor(spi, select, &mut delay);

    let settings = serial::Config::default().baudrate(BAUD.bps());
    let pins = (gpioa.pa2, gpioa.pa3);
    let Ok(port) = device.USART2.serial(pins, settings, &mut rcc) else {
        failsafe::give_up(Cause::Panic { line: line!() })
    };
    let (tx, mut rx) = port.split();
    rx.listen();

    // before the watchdog: making room takes seconds
    let memory = Memory::open(flash::Sectors(device.FLASH));
    let mut timer = device.TIM2.counter_hz(&mut rcc);
    if timer.start(RATE_HZ.Hz()).is_err() {
        failsafe::give_up(Cause::Panic { line: line!() });
    }
    timer.listen(Event::Update);
    let mut watchdog = IndependentWatchdog::new(device.IWDG);
    watchdog.start(WATCHDOG_MS.millis());
    let control = control::Control::new(timer, watchdog, imu, servos);
    Parts { control, tx, rx, cause, clock_hz, memory }
}

fn sensor(spi: Spi<SPI1>, select: Pin<'A', 4, Output>, delay: &mut SysDelay) -> Option<BoardImu> {
    let Ok(device) = ExclusiveDevice::new(spi, select, Spin);
    match Imu::new(device, delay) {
        Ok(imu) => Some(imu),
        Err(fault) => {
            defmt::warn!("no IMU: {}", defmt::Debug2Format(&fault));
            None
        }
    }
}
