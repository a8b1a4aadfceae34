//! Neutral first, then the record, then the reset.
#![allow(unsafe_code)]

use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use firmware::reset_record::{Cause, Record, WATCHDOG_RESET};
use firmware::servo::ServoConfig;
use stm32f4xx_hal::pac::{EXTI, PWR, RCC, TIM4};
use stm32f4xx_hal::rcc::Rcc;

/// Outlives a reset: start-up does not touch this section.
#[unsafe(link_section = ".uninit.record")]
static mut RECORD: MaybeUninit<Record> = MaybeUninit::uninit();

/// Why the board was reset: what the last run left, or else that the watchdog bit. It is told once.
pub fn cause(rcc: &RCC) -> Option<Cause> {
    let bitten = rcc.csr().read().bits() & WATCHDOG_RESET != 0;
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    take().or(bitten.then_some(Cause::Watchdog))
}

fn take() -> Option<Cause> {
    let record = &raw mut RECORD;
    // SAFETY: called once, before any interrupt is on; any four words are a `Record`
    unsafe {
        let cause = record.cast::<Record>().read_volatile().cause();
        record.cast::<Record>().write_volatile(Record::EMPTY);
        cause
    }
}

fn keep(cause: Cause) {
    // SAFETY: the only writer; called with interrupts off or from where nothing else runs
    unsafe { (&raw mut RECORD).cast::<Record>().write_volatile(Record::of(cause)) };
}

/// Both rotors to the trim, whatever state the program is in.
fn neutral() {
    // SAFETY: writes of two compare registers, which any value suits
    let timer = unsafe { &*TIM4::ptr() };
    let config = ServoConfig::default();
    let [front, rear] = config.widths_us(0.0);
    let top = timer.arr().read().bits() as u16;
    timer.ccr(0).write(|w| unsafe { w.bits(u32::from(config.duty(front, top))) });
    timer.ccr(1).write(|w| unsafe { w.bits(u32::from(config.duty(rear, top))) });
}

/// Neutral, record, reset.
pub fn give_up(cause: Cause) -> ! {
    cortex_m::interrupt::disable();
    neutral();
    keep(cause);
    SCB::sys_reset()
}

/// The supply is going: neutral and the record. The brown-out reset will follow, or the watchdog.
pub fn brown_out() {
    give_up(Cause::BrownOut);
}

/// Interrupt below 2.9 V (PVD level 7, line 16 of the EXTI, rising).
pub fn watch_supply(pwr: &PWR, exti: &EXTI, _rcc: &mut Rcc) {
    // SAFETY: switches the clock of the power interface on, which nothing else uses
    unsafe { <PWR as stm32f4xx_hal::rcc::Enable>::enable_unchecked() };
    pwr.cr().modify(|_, w| unsafe { w.pls().bits(7).pvde().set_bit() });
    exti.rtsr().modify(|_, w| w.tr16().enabled());
    exti.imr().modify(|_, w| w.mr16().unmasked());
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let line = info.location().map_or(0, core::panic::Location::line);
    give_up(Cause::Panic { line })
}

#[exception(trampoline = true)]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    give_up(Cause::HardFault { address: frame.pc() })
}
