//! Clock start: the 8 MHz crystal to 168 MHz, or the internal 16 MHz when the crystal or the PLL does not come up.
//!
//! Every wait has a limit. The crystal and the PLL are tried by hand first; only when both have locked is the hardware
//! abstraction layer, whose waits have none, told to do the same.

use stm32f4xx_hal::pac::RCC;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

const CRYSTAL_MHZ: u32 = 8;
/// Reads of a flag before it is given up: 10 ms at 16 MHz, five times the crystal's longest start (data sheet, table 33).
const PATIENCE: u32 = 20_000;

/// Starts the clocks.
pub fn start(rcc: RCC) -> Rcc {
    let sound = crystal_and_pll(&rcc);
    let config = if sound { Config::hse(CRYSTAL_MHZ.MHz()).sysclk(168.MHz()) } else { Config::hsi() };
    rcc.freeze(config)
}

/// Tries the crystal and the PLL at 8 / 8 · 336 / 2 = 168 MHz, and leaves the PLL off.
fn crystal_and_pll(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().on());
    if !comes(|| rcc.cr().read().hserdy().bit_is_set()) {
        rcc.cr().modify(|_, w| w.hseon().off());
        return false;
    }
    rcc.pllcfgr().modify(|_, w| {
        w.pllsrc().hse();
        // SAFETY: 8 and 336 are legal dividers of the reference manual's section 7.3.2
        #[allow(unsafe_code)]
        unsafe {
            w.pllm().bits(8);
            w.plln().bits(336)
        }
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    let locked = comes(|| rcc.cr().read().pllrdy().bit_is_set());
    rcc.cr().modify(|_, w| w.pllon().off());
    locked && comes(|| rcc.cr().read().pllrdy().bit_is_clear())
}

fn comes(flag: impl Fn() -> bool) -> bool {
    (0..PATIENCE).any(|_| flag())
}
