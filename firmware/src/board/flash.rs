//! The four last sectors of the chip's flash, which the linker leaves free.
#![allow(unsafe_code)]

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware::settings::LENGTH;
use firmware::store::SECTOR;
use stm32f4xx_hal::flash::FlashExt;
use stm32f4xx_hal::pac::FLASH;

/// Number of the first of them (reference manual RM0090, table 5).
const FIRST: u32 = 8;
const OFFSET: usize = 0x8_0000;

/// Sectors 8 to 11.
pub struct Sectors(pub FLASH);

impl ErrorType for Sectors {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Sectors {
    const READ_SIZE: usize = 1;

    fn read(&mut self, at: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        // SAFETY: flash that is always mapped, which nothing but this type writes
        let all =
            unsafe { core::slice::from_raw_parts((self.0.address() + OFFSET) as *const u8, LENGTH as usize) };
        let end = (at as usize).saturating_add(bytes.len());
        let part = all.get(at as usize..end).ok_or(NorFlashErrorKind::OutOfBounds)?;
        bytes.copy_from_slice(part);
        Ok(())
    }

    fn capacity(&self) -> usize {
        LENGTH as usize
    }
}

impl NorFlash for Sectors {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let mut flash = self.0.unlocked();
        for sector in from / SECTOR..to / SECTOR {
            flash.erase((FIRST + sector) as u8).map_err(|_| NorFlashErrorKind::Other)?;
        }
        Ok(())
    }

    fn write(&mut self, at: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let mut flash = self.0.unlocked();
        flash.program(OFFSET + at as usize, bytes.iter()).map_err(|_| NorFlashErrorKind::Other)
    }
}
