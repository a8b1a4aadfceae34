//! Flash that the chip finds when it boots: what the board itself would have written there.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware::settings::{LENGTH, Memory};
use firmware::store::{NotKept, SECTOR};

use super::emulator::FLIGHT;
use super::{Emulator, Pilot};

/// Where the board keeps its records.
const ADDRESS: &str = "0x08080000";

/// Flash, erased at first.
pub struct Flash(Vec<u8>);

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}
impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;
    fn read(&mut self, at: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        bytes.copy_from_slice(&self.0[at as usize..][..bytes.len()]);
        Ok(())
    }
    fn capacity(&self) -> usize {
        self.0.len()
    }
}
impl NorFlash for Flash {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR as usize;
    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.0[from as usize..to as usize].fill(0xff);
        Ok(())
    }
    fn write(&mut self, at: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.0[at as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}

impl Flash {
    /// Flash in which `keep` has kept something.
    ///
    /// # Panics
    /// Never: there is room.
    pub fn holding(keep: impl FnOnce(&mut Memory<&mut Self>) -> Result<(), NotKept>) -> Self {
        let mut flash = Self(vec![0xff; LENGTH as usize]);
        keep(&mut Memory::open(&mut flash)).expect("there is room");
        flash
    }

    /// The chip with this flash.
    ///
    /// # Panics
    /// Where no temporary file can be written.
    #[must_use]
    pub fn boot(&self) -> Option<Pilot> {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let file = folder.path().join("flash");
        std::fs::write(&file, &self.0).expect("a temporary file can be written");
        let device = format!("loader,file={},addr={ADDRESS},force-raw=on", file.display());
        // the greeting comes after the file has been read
        Emulator::boot_with(FLIGHT, &["-device".to_owned(), device]).map(Pilot::new)
    }
}
