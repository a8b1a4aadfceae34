//! Records across power-off: a log in two sectors of flash, of which the newest whole record counts.
//!
//! ```text
//! slot:  mark · sequence · payload · first 8 bytes of SHA-256 of all that
//! ```
//!
//! A record is appended to the slot after the newest, so nothing is erased while the board runs: erasing a sector stops the
//! processor for 1 to 2 s, far beyond the watchdog's 70 ms. Only at start, where the sector has become three quarters full, the
//! *other* one is erased and the newest record written there; the power may fail at any moment, the last whole record is found.
//! A record with another mark does not count. The flash bears 10 000 erasures of some hundred records each.
//!
//! That is why this is no key-value store of the shelf: those erase when they are written to.

use embedded_storage::nor_flash::NorFlash;

use crate::digest::{DIGEST, digest};

/// Bytes of one sector.
pub const SECTOR: u32 = 128 * 1024;
/// Bytes of a slot before its payload.
const HEADER: usize = 8;

/// Bytes of the slot of a payload.
#[must_use]
pub const fn slot_of(payload: usize) -> usize {
    (HEADER + payload + DIGEST).next_multiple_of(4)
}

/// The flash did not take a record, or has no room for it.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct NotKept;

/// Where the next record goes, in slots of so many bytes.
#[derive(Clone, Copy, Debug)]
pub struct Store<const SLOT: usize> {
    area: u32,
    mark: u32,
    next: Option<u32>,
    newest: Option<u32>,
    sequence: u32,
}

/// A whole record.
#[derive(Clone, Copy)]
pub struct Record<const SLOT: usize>([u8; SLOT]);

impl<const SLOT: usize> Record<SLOT> {
    fn new(mark: u32, sequence: u32, payload: &[u8]) -> Self {
        let mut slot = [0; SLOT];
        let head = mark.to_le_bytes().into_iter().chain(sequence.to_le_bytes());
        slot.iter_mut().zip(head.chain(payload.iter().copied())).for_each(|(to, byte)| *to = byte);
        let digest = digest(checked(&slot));
        slot.iter_mut().rev().zip(digest.iter().rev()).for_each(|(to, byte)| *to = *byte);
        Self(slot)
    }

    fn read(slot: [u8; SLOT], mark: u32) -> Option<(u32, Self)> {
        let (head, _) = slot.split_first_chunk::<4>()?;
        let sequence = slot.get(4..)?.first_chunk().copied().map(u32::from_le_bytes)?;
        let sound = u32::from_le_bytes(*head) == mark && slot.ends_with(&digest(checked(&slot)));
        sound.then_some((sequence, Self(slot)))
    }

    /// What was kept, and the zeros behind it.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        checked(&self.0).get(HEADER..).unwrap_or_default()
    }
}

fn checked(slot: &[u8]) -> &[u8] {
    slot.get(..slot.len().saturating_sub(DIGEST)).unwrap_or_default()
}

impl<const SLOT: usize> Store<SLOT> {
    /// Slots of one sector.
    const SLOTS: u32 = SECTOR / SLOT as u32;

    /// Finds the newest record of the two sectors from `area` on and makes room where there is little. Before the watchdog runs.
    pub fn open(flash: &mut impl NorFlash, area: u32, mark: u32) -> Self {
        let mut store = Self { area, mark, next: None, newest: None, sequence: 0 };
        for at in store.places() {
            if let Some((sequence, _)) = store.record(flash, at)
                && (store.newest.is_none() || sequence > store.sequence)
            {
                (store.newest, store.sequence) = (Some(at), sequence);
            }
        }
        let Some(at) = store.newest else {
            let erased = store.places().find(|&at| is_erased::<SLOT>(flash, at));
            store.next = erased.or_else(|| store.erase(flash, area));
            return store;
        };
        store.next = store.rest(at).find(|&at| is_erased::<SLOT>(flash, at));
        if store.next.is_none_or(|next| (store.rest(next).count() as u32) < Self::SLOTS / 4) {
            let other = if store.sector(at) == area { area + SECTOR } else { area };
            let newest = store.newest(flash);
            store.next = store.erase(flash, other).or(store.next);
            // what cannot be written now is still where it was
            let _ = newest.map(|record| store.save(flash, record.payload()));
        }
        store
    }

    /// The newest record.
    pub fn newest(&self, flash: &mut impl NorFlash) -> Option<Record<SLOT>> {
        self.record(flash, self.newest?).map(|(_, record)| record)
    }

    /// The whole record at `at`, with its sequence.
    fn record(&self, flash: &mut impl NorFlash, at: u32) -> Option<(u32, Record<SLOT>)> {
        slot(flash, at).and_then(|slot| Record::read(slot, self.mark))
    }

    /// Appends a record.
    ///
    /// # Errors
    /// No room, or another content than was written.
    #[inline(never)]
    pub fn save(&mut self, flash: &mut impl NorFlash, payload: &[u8]) -> Result<(), NotKept> {
        let at = self.next.ok_or(NotKept)?;
        self.sequence = self.sequence.wrapping_add(1);
        let wanted = Record::<SLOT>::new(self.mark, self.sequence, payload);
        let written = flash.write(at, &wanted.0).is_ok()
            && self.record(flash, at).is_some_and(|(sequence, _)| sequence == self.sequence);
        self.next = self.rest(at).skip(1).find(|&at| is_erased::<SLOT>(flash, at));
        if written {
            self.newest = Some(at);
            Ok(())
        } else {
            Err(NotKept)
        }
    }

    /// The first byte of the sector in which `at` lies.
    const fn sector(&self, at: u32) -> u32 {
        if at < self.area + SECTOR { self.area } else { self.area + SECTOR }
    }

    /// Every slot.
    fn places(&self) -> impl Iterator<Item = u32> + use<SLOT> {
        let area = self.area;
        [area, area + SECTOR].into_iter().flat_map(|from| (from..).step_by(SLOT).take(Self::SLOTS as usize))
    }

    /// The slots of its sector from `at` on.
    fn rest(&self, at: u32) -> impl Iterator<Item = u32> + use<SLOT> {
        let end = self.sector(at) + Self::SLOTS * SLOT as u32;
        (at..end).step_by(SLOT)
    }

    /// Erases the sector at `at`; its first slot, if that worked.
    fn erase(&self, flash: &mut impl NorFlash, at: u32) -> Option<u32> {
        let done = flash.erase(at, at + SECTOR).is_ok() && is_erased::<SLOT>(flash, at);
        done.then_some(at)
    }
}

fn slot<const SLOT: usize>(flash: &mut impl NorFlash, at: u32) -> Option<[u8; SLOT]> {
    let mut slot = [0; SLOT];
    flash.read(at, &mut slot).ok().map(|()| slot)
}

fn is_erased<const SLOT: usize>(flash: &mut impl NorFlash, at: u32) -> bool {
    slot::<SLOT>(flash, at).is_some_and(|slot| slot.iter().all(|&byte| byte == 0xff))
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_storage::nor_flash::{ErrorType, NorFlashErrorKind, ReadNorFlash};

    const LONG: usize = 101;
    const SLOT: usize = slot_of(LONG + 8);
    const SLOTS: usize = SECTOR as usize / SLOT;
    /// Not the first byte of the flash, which belongs to somebody else.
    const AREA: u32 = SECTOR;
    const MARK: u32 = 77;

    /// Flash in which bits only fall, with a supply that may fail after so many bytes.
    struct Chip {
        bytes: Vec<u8>,
        supply: usize,
    }

    impl Chip {
        fn new(fill: u8) -> Self {
            Self { bytes: vec![fill; 3 * SECTOR as usize], supply: usize::MAX }
        }
        fn boot(&mut self) -> (Store<SLOT>, Option<Record<SLOT>>) {
            self.supply = usize::MAX;
            let store = Store::open(self, AREA, MARK);
            let newest = store.newest(self);
            (store, newest)
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

    fn payload(number: usize) -> Vec<u8> {
        (0..LONG).map(|place| (number + place) as u8).chain(number.to_le_bytes()).collect()
    }

    fn same(found: Option<Record<SLOT>>, number: usize) -> bool {
        found.is_some_and(|found| found.payload().starts_with(&payload(number)))
    }

    #[test]
    fn what_was_saved_last_is_found_over_many_boots() {
        let mut chip = Chip::new(0xff);
        assert!(chip.boot().1.is_none());
        for number in 0..3000 {
            let (mut store, found) = chip.boot();
            assert!(number == 0 || same(found, number - 1), "{number}");
            assert_eq!(store.save(&mut chip, &payload(number)), Ok(()), "{number}");
        }
    }

    #[test]
    fn a_full_sector_is_told_and_the_next_boot_makes_room() {
        let mut chip = Chip::new(0xff);
        let (mut store, _) = chip.boot();
        let kept = (0..2000).take_while(|&number| store.save(&mut chip, &payload(number)).is_ok()).count();
        assert_eq!(kept, SLOTS);
        let (mut store, found) = chip.boot();
        assert!(same(found, SLOTS - 1));
        assert_eq!(store.save(&mut chip, &payload(5000)), Ok(()));
        assert!(same(chip.boot().1, 5000));
    }

    #[test]
    fn a_supply_that_fails_in_any_byte_of_a_save_leaves_the_old_or_the_new() {
        for supply in 0..SLOT {
            let mut chip = Chip::new(0xff);
            let (mut store, _) = chip.boot();
            store.save(&mut chip, &payload(1)).unwrap();
            chip.supply = supply;
            assert_eq!(store.save(&mut chip, &payload(2)), Err(NotKept));
            let (mut store, found) = chip.boot();
            assert!(same(found, 1), "{supply}");
            assert_eq!(store.save(&mut chip, &payload(3)), Ok(()), "{supply}");
            assert!(same(chip.boot().1, 3), "{supply}");
        }
    }

    #[test]
    fn a_supply_that_fails_while_room_is_made_loses_nothing() {
        let mut full = Chip::new(0xff);
        let (mut store, _) = full.boot();
        (0..SLOTS - 20).for_each(|number| store.save(&mut full, &payload(number)).unwrap());
        for supply in [0, 1, 1000, SECTOR as usize, SECTOR as usize + 50, SECTOR as usize + SLOT] {
            let mut chip = Chip { bytes: full.bytes.clone(), supply };
            let _ = Store::<SLOT>::open(&mut chip, AREA, MARK);
            let (mut store, found) = chip.boot();
            assert!(same(found, SLOTS - 21), "{supply}");
            assert_eq!(store.save(&mut chip, &payload(7)), Ok(()), "{supply}");
            assert!(same(chip.boot().1, 7), "{supply}");
        }
    }

    #[test]
    fn records_of_another_mark_do_not_count_and_what_lies_outside_is_left_alone() {
        let mut chip = Chip::new(0xff);
        chip.bytes[..SECTOR as usize].fill(0x11);
        let mut other = Store::<SLOT>::open(&mut chip, AREA, MARK + 1);
        (0..3).for_each(|number| other.save(&mut chip, &payload(number)).unwrap());
        let (mut store, found) = chip.boot();
        assert!(found.is_none());
        (0..2 * SLOTS).for_each(|number| {
            if store.save(&mut chip, &payload(number)).is_err() {
                store = chip.boot().0;
            }
        });
        assert!(chip.bytes[..SECTOR as usize].iter().all(|&byte| byte == 0x11));
    }

    #[test]
    fn garbage_is_erased_and_a_flipped_bit_is_noticed() {
        let mut chip = Chip::new(0x5a);
        let (mut store, found) = chip.boot();
        assert!(found.is_none());
        assert_eq!(store.save(&mut chip, &payload(4)), Ok(()));
        for bit in 0..8 * SLOT {
            let mut spoilt = Chip { bytes: chip.bytes.clone(), supply: usize::MAX };
            spoilt.bytes[AREA as usize + bit / 8] ^= 1 << (bit % 8);
            assert!(spoilt.boot().1.is_none(), "{bit}");
        }
    }
}
