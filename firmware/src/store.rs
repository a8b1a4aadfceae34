//! Parameters and signing key across power-off: a log of records in two sectors of flash.
//!
//! ```text
//! slot of 128 bytes:  mark · sequence · parameters · key · timestamp · first 8 bytes of SHA-256 of all that
//! ```
//!
//! A change is appended to the slot after the newest, so nothing is erased while the board runs: erasing a sector stops the
//! processor for 1 to 2 s, far beyond the watchdog's 70 ms. Only at start, where the sector has become three quarters full, the
//! *other* one is erased and the newest record written there; the power may fail at any moment, the last whole record is found.
//! A record of another table of parameters does not count. The flash bears 10 000 erasures of some 700 records each.
//!
//! That is why this is no key-value store of the shelf: those erase when they are written to.

use embedded_storage::nor_flash::NorFlash;
use sha2::{Digest, Sha256};

use crate::link::signing::Key;
use crate::parameters::PARAMETERS;

/// Bytes of one sector.
pub const SECTOR: u32 = 128 * 1024;
/// Bytes of the whole store.
pub const LENGTH: u32 = 2 * SECTOR;
const SLOT: usize = 128;
/// Slots below which a sector counts as full.
const ROOM: u32 = SECTOR / SLOT as u32 / 4;
const MARK: u32 = 0x5049_0100 + PARAMETERS.len() as u32;
/// Place of the digest.
const CHECKED: usize = SLOT - 8;
const _: () = assert!(VALUES + 4 * PARAMETERS.len() <= SIGNED, "the parameters fit into the slot");
const VALUES: usize = 8;
const SIGNED: usize = 76;

type Slot = [u8; SLOT];

/// What is kept.
#[derive(Clone, Copy)]
pub struct Settings {
    /// Value of each parameter, in the order of the table.
    pub values: [f32; PARAMETERS.len()],
    /// Key and latest timestamp.
    pub signing: Option<(Key, u64)>,
}

/// The flash did not take a record, or has no room for it.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct NotKept;

impl Settings {
    fn slot(&self, sequence: u32) -> Slot {
        let mut slot = [0; SLOT];
        let mut put = |place: usize, bytes: &[u8]| {
            slot.iter_mut().skip(place).zip(bytes).for_each(|(to, &byte)| *to = byte);
        };
        put(0, &MARK.to_le_bytes());
        put(4, &sequence.to_le_bytes());
        self.values.iter().zip((VALUES..).step_by(4)).for_each(|(value, at)| put(at, &value.to_le_bytes()));
        if let Some((Key(key), timestamp)) = &self.signing {
            put(SIGNED, &[1]);
            put(SIGNED + 1, key);
            put(SIGNED + 33, &timestamp.to_le_bytes());
        }
        let digest = digest(&slot);
        slot.iter_mut().skip(CHECKED).zip(digest).for_each(|(to, byte)| *to = byte);
        slot
    }

    fn read(slot: &Slot) -> Option<(u32, Self)> {
        let word = |at: usize| slot.get(at..).and_then(<[u8]>::first_chunk).copied().map(u32::from_le_bytes);
        if word(0)? != MARK || slot.get(CHECKED..)? != digest(slot) {
            return None;
        }
        let mut values = [0.0; PARAMETERS.len()];
        for (value, at) in values.iter_mut().zip((VALUES..).step_by(4)) {
            *value = f32::from_bits(word(at)?);
        }
        let key = slot.get(SIGNED + 1..)?.first_chunk().copied()?;
        let timestamp = slot.get(SIGNED + 33..)?.first_chunk().copied().map(u64::from_le_bytes)?;
        let signing = (*slot.get(SIGNED)? == 1).then_some((Key(key), timestamp));
        Some((word(4)?, Self { values, signing }))
    }
}

fn digest(slot: &Slot) -> [u8; 8] {
    let hash = Sha256::digest(slot.get(..CHECKED).unwrap_or_default());
    hash.first_chunk().copied().unwrap_or_default()
}

/// Where the next record goes.
#[derive(Clone, Copy, Debug)]
pub struct Store {
    next: Option<u32>,
    sequence: u32,
}

impl Store {
    /// Finds the newest record and makes room where there is little. Before the watchdog runs.
    pub fn open(flash: &mut impl NorFlash) -> (Self, Option<Settings>) {
        let slots = || (0..LENGTH).step_by(SLOT);
        let mut newest: Option<(u32, u32, Settings)> = None;
        for at in slots() {
            let found = slot(flash, at).as_ref().and_then(Settings::read);
            if let Some((sequence, settings)) = found
                && newest.as_ref().is_none_or(|(last, ..)| sequence > *last)
            {
                newest = Some((sequence, at, settings));
            }
        }
        let Some((sequence, at, settings)) = newest else {
            let next = slots().find(|&at| is_erased(flash, at)).or_else(|| erased(flash, 0));
            return (Self { next, sequence: 0 }, None);
        };
        let end = (at / SECTOR + 1) * SECTOR;
        let next = (at..end).step_by(SLOT).find(|&at| is_erased(flash, at));
        let mut store = Self { next, sequence };
        if next.is_none_or(|next| (end - next) / (SLOT as u32) < ROOM) {
            store.next = erased(flash, end % LENGTH).or(next);
            // what cannot be written now is still where it was
            let _ = store.save(flash, &settings);
        }
        (store, Some(settings))
    }

    /// Appends a record.
    ///
    /// # Errors
    /// No room, or another content than was written.
    pub fn save(&mut self, flash: &mut impl NorFlash, settings: &Settings) -> Result<(), NotKept> {
        let at = self.next.ok_or(NotKept)?;
        let wanted = settings.slot(self.sequence.wrapping_add(1));
        let written = flash.write(at, &wanted).is_ok() && slot(flash, at) == Some(wanted);
        let end = (at / SECTOR + 1) * SECTOR;
        self.next = (at..end).step_by(SLOT).skip(1).find(|&at| is_erased(flash, at));
        self.sequence = self.sequence.wrapping_add(1);
        if written { Ok(()) } else { Err(NotKept) }
    }
}

fn slot(flash: &mut impl NorFlash, at: u32) -> Option<Slot> {
    let mut slot = [0; SLOT];
    flash.read(at, &mut slot).ok().map(|()| slot)
}

fn is_erased(flash: &mut impl NorFlash, at: u32) -> bool {
    slot(flash, at).is_some_and(|slot| slot == [0xff; SLOT])
}

/// Erases the sector at `at`; its first slot, if that worked.
fn erased(flash: &mut impl NorFlash, at: u32) -> Option<u32> {
    let done = flash.erase(at, at + SECTOR).is_ok() && is_erased(flash, at);
    done.then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_storage::nor_flash::{ErrorType, NorFlashErrorKind, ReadNorFlash};

    /// Flash in which bits only fall, with a supply that may fail after so many bytes.
    struct Chip {
        bytes: Vec<u8>,
        supply: usize,
    }

    impl Chip {
        fn new(fill: u8) -> Self {
            Self { bytes: vec![fill; LENGTH as usize], supply: usize::MAX }
        }
        fn boot(&mut self) -> (Store, Option<Settings>) {
            self.supply = usize::MAX;
            Store::open(self)
        }
    }

    impl ErrorType for Chip {
        type Error = NorFlashErrorKind;
    }
    impl ReadNorFlash for Chip {
        const READ_SIZE: usize = 1;
        fn read(&mut self, at: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            bytes.copy_from_slice(&self.bytes[at as usize..][..bytes.len()]);
            Ok(())
        }
        fn capacity(&self) -> usize {
            self.bytes.len()
        }
    }
    impl NorFlash for Chip {
        const WRITE_SIZE: usize = 1;
        const ERASE_SIZE: usize = SECTOR as usize;
        fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
            for byte in &mut self.bytes[from as usize..to as usize] {
                self.supply = self.supply.checked_sub(1).ok_or(NorFlashErrorKind::Other)?;
                *byte = 0xff;
            }
            Ok(())
        }
        fn write(&mut self, at: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
            for (place, byte) in self.bytes[at as usize..].iter_mut().zip(bytes) {
                self.supply = self.supply.checked_sub(1).ok_or(NorFlashErrorKind::Other)?;
                *place &= byte;
            }
            Ok(())
        }
    }

    fn settings(number: usize) -> Settings {
        let values = core::array::from_fn(|i| number as f32 + 0.125 * i as f32);
        let signing = (number % 2 == 1).then_some((Key([number as u8; 32]), number as u64 * 1000));
        Settings { values, signing }
    }

    fn same(found: Option<Settings>, number: usize) -> bool {
        let expected = settings(number);
        found.is_some_and(|found| {
            let key = |s: &Settings| s.signing.map(|(key, timestamp)| (key.0, timestamp));
            found.values == expected.values && key(&found) == key(&expected)
        })
    }

    #[test]
    fn what_was_saved_last_is_found_over_many_boots() {
        let mut chip = Chip::new(0xff);
        assert!(chip.boot().1.is_none());
        for number in 0..3000 {
            let (mut store, found) = chip.boot();
            assert!(number == 0 || same(found, number - 1), "{number}");
            assert_eq!(store.save(&mut chip, &settings(number)), Ok(()), "{number}");
        }
    }

    #[test]
    fn a_full_sector_is_told_and_the_next_boot_makes_room() {
        let mut chip = Chip::new(0xff);
        let (mut store, _) = chip.boot();
        let kept = (0..2000).take_while(|&number| store.save(&mut chip, &settings(number)).is_ok()).count();
        assert_eq!(kept, 1024);
        let (mut store, found) = chip.boot();
        assert!(same(found, 1023));
        assert_eq!(store.save(&mut chip, &settings(5000)), Ok(()));
        assert!(same(chip.boot().1, 5000));
    }

    #[test]
    fn a_supply_that_fails_in_any_byte_of_a_save_leaves_the_old_or_the_new() {
        for supply in 0..SLOT {
            let mut chip = Chip::new(0xff);
            let (mut store, _) = chip.boot();
            store.save(&mut chip, &settings(1)).unwrap();
            chip.supply = supply;
            assert_eq!(store.save(&mut chip, &settings(2)), Err(NotKept));
            let (mut store, found) = chip.boot();
            assert!(same(found, 1), "{supply}");
            assert_eq!(store.save(&mut chip, &settings(3)), Ok(()), "{supply}");
            assert!(same(chip.boot().1, 3), "{supply}");
        }
    }

    #[test]
    fn a_supply_that_fails_while_room_is_made_loses_nothing() {
        let mut full = Chip::new(0xff);
        let (mut store, _) = full.boot();
        (0..1000).for_each(|number| store.save(&mut full, &settings(number)).unwrap());
        for supply in [0, 1, 1000, SECTOR as usize, SECTOR as usize + 50, SECTOR as usize + SLOT] {
            let mut chip = Chip { bytes: full.bytes.clone(), supply };
            let _ = Store::open(&mut chip);
            let (mut store, found) = chip.boot();
            assert!(same(found, 999), "{supply}");
            assert_eq!(store.save(&mut chip, &settings(7)), Ok(()), "{supply}");
            assert!(same(chip.boot().1, 7), "{supply}");
        }
    }

    #[test]
    fn garbage_is_erased_and_a_flipped_bit_is_noticed() {
        let mut chip = Chip::new(0x5a);
        let (mut store, found) = chip.boot();
        assert!(found.is_none());
        assert_eq!(store.save(&mut chip, &settings(4)), Ok(()));
        for bit in 0..8 * SLOT {
            let mut spoilt = Chip { bytes: chip.bytes.clone(), supply: usize::MAX };
            spoilt.bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(spoilt.boot().1.is_none(), "{bit}");
        }
    }
}
