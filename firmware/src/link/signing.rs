//! Signatures of MAVLink 2.
//!
//! signature = link id (1) · timestamp (6) · first 6 bytes of SHA-256(key · frame up to its checksum · link id · timestamp)
//!
//! A frame is taken when its signature fits and its timestamp, in units of 10 µs since 2015, is later than that of the
//! last frame taken on the same link id, so nothing can be replayed.
//!
//! Nor after the power was off: the timestamp that the flash holds is one that no frame has reached yet, a minute ahead. Whoever keeps
//! it is told to before a frame beyond it is obeyed ([`Gate::reserve`]), and the next start takes nothing up to it. A ground station
//! learns the later time from the board's own frames, as the guide asks.
//! Source: MAVLink developer guide, *Message Signing*.

use sha2::{Digest, Sha256};

use crate::link::decoder::{Frame, SIGNATURE};

/// The secret that both sides share.
#[derive(Clone, Copy)]
pub struct Key(pub [u8; 32]);

impl Key {
    /// The 13 bytes that follow `frame`.
    #[must_use]
    pub fn signature(&self, frame: &[u8], link: u8, timestamp: u64) -> [u8; SIGNATURE] {
        let mut signature = [0; SIGNATURE];
        signature[0] = link;
        signature[1..7].copy_from_slice(&timestamp.to_le_bytes()[..6]);
        let mut hash = Sha256::new();
        hash.update(self.0);
        hash.update(frame);
        hash.update(&signature[..7]);
        signature[7..].copy_from_slice(&hash.finalize()[..6]);
        signature
    }
}

/// Links whose timestamps are remembered.
const LINKS: usize = 4;

/// How far ahead of the latest timestamp the one in flash is, in its units of 10 µs: a minute, the guide's own margin.
const AHEAD: u64 = 60 * 100_000;

/// Checks what comes in; keeps the timestamps.
#[derive(Clone)]
pub struct Gate {
    key: Key,
    /// The latest timestamp, of both directions.
    pub timestamp: u64,
    /// What the flash holds.
    reserved: u64,
    last: [Option<(u8, u64)>; LINKS],
}

impl Gate {
    /// A gate that takes frames later than `initial_timestamp`.
    #[must_use]
    pub const fn new(key: Key, initial_timestamp: u64) -> Self {
        Self { key, timestamp: initial_timestamp, reserved: initial_timestamp, last: [None; LINKS] }
    }

    /// Key and timestamp to be kept now; none while the timestamp that was kept last is still ahead.
    pub fn reserve(&mut self) -> Option<(Key, u64)> {
        (self.timestamp > self.reserved).then(|| {
            self.reserved = self.timestamp.saturating_add(AHEAD);
            self.kept()
        })
    }

    /// Key and timestamp as the flash is to hold them.
    #[must_use]
    pub const fn kept(&self) -> (Key, u64) {
        (self.key, self.reserved)
    }

    /// The secret.
    #[must_use]
    pub const fn key(&self) -> &Key {
        &self.key
    }

    /// True for a frame with a fitting signature that is later than the last.
    pub fn admits(&mut self, frame: &Frame<'_>) -> bool {
        let (body, Some(signature)) = frame.parts() else { return false };
        let Some((&[link, t0, t1, t2, t3, t4, t5], _)) = signature.split_first_chunk::<7>() else {
            return false;
        };
        let timestamp = u64::from_le_bytes([t0, t1, t2, t3, t4, t5, 0, 0]);
        if self.key.signature(body, link, timestamp) != signature {
            return false;
        }
        let known = self.last.iter().position(|last| matches!(last, Some((l, _)) if *l == link));
        let free = self.last.iter().position(Option::is_none);
        let Some(place) = known.or(free).and_then(|place| self.last.get_mut(place)) else { return false };
        let later = timestamp > place.map_or(self.timestamp, |(_, last)| last);
        if later {
            *place = Some((link, timestamp));
            self.timestamp = self.timestamp.max(timestamp);
        }
        later
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::decoder::Decoder;
    use crate::link::frame::{Bytes, Header, encode, sign};
    use messages::MessageData;
    use messages::board::MANUAL_CONTROL_DATA;

    const EXTRA: u8 = MANUAL_CONTROL_DATA::EXTRA_CRC;

    fn signed(key: u8, link: u8, timestamp: u64) -> Bytes {
        let mut frame =
            encode(Header::default(), &MANUAL_CONTROL_DATA { x: 5, ..MANUAL_CONTROL_DATA::default() });
        sign(&mut frame, EXTRA, &Key([key; 32]), link, timestamp);
        frame
    }

    fn admitted(gate: &mut Gate, bytes: &[u8]) -> bool {
        let mut decoder = Decoder::new(|_| Some(EXTRA));
        let mut admitted = false;
        bytes.iter().for_each(|&byte| decoder.push(byte, |frame| admitted = gate.admits(&frame)));
        admitted
    }

    #[test]
    fn signed_frames_pass_once_and_in_order() {
        let mut gate = Gate::new(Key([7; 32]), 1000);
        assert!(!admitted(&mut gate, &signed(7, 1, 1000)));
        assert!(admitted(&mut gate, &signed(7, 1, 1001)));
        assert!(!admitted(&mut gate, &signed(7, 1, 1001)));
        assert!(!admitted(&mut gate, &signed(7, 1, 900)));
        assert!(admitted(&mut gate, &signed(7, 1, 2000)));
    }

    #[test]
    fn another_key_or_none_or_a_changed_byte_does_not_pass() {
        let mut gate = Gate::new(Key([7; 32]), 0);
        assert!(!admitted(&mut gate, &signed(8, 1, 10)));
        assert!(!admitted(&mut gate, &encode(Header::default(), &MANUAL_CONTROL_DATA::default())));
        for place in 7..13 {
            let mut frame = signed(7, 1, 10);
            let length = frame.len();
            frame[length - 13 + place] ^= 1;
            assert!(!admitted(&mut gate, &frame));
        }
        assert!(admitted(&mut gate, &signed(7, 1, 10)));
    }

    #[test]
    fn whenever_the_power_goes_nothing_that_was_taken_is_taken_again() {
        for until in 1..40_u64 {
            let (mut gate, mut flash) = (Gate::new(Key([7; 32]), 1000), (Key([7; 32]), 1000));
            let mut taken = Vec::new();
            let mut writes = 0;
            for step in 1..=until {
                // from 30 µs to 20 s from one frame to the next, over two links
                let frame = signed(7, (step % 2) as u8, 1000 + 3 * step.pow(4));
                assert!(admitted(&mut gate, &frame));
                if let Some(kept) = gate.reserve() {
                    (flash, writes) = (kept, writes + 1);
                }
                taken.push(frame);
                // here the power may go
                let mut restarted = Gate::new(flash.0, flash.1);
                assert!(taken.iter().all(|frame| !admitted(&mut restarted, frame)), "{until} {step}");
                assert!(admitted(&mut restarted, &signed(7, 1, flash.1 + 1)));
            }
            assert!(writes <= 2, "{writes} writes for {until} frames");
        }
    }

    #[test]
    fn a_fifth_link_is_refused() {
        let mut gate = Gate::new(Key([7; 32]), 0);
        let passed: Vec<bool> =
            (0..5).map(|link| admitted(&mut gate, &signed(7, link, 10 + u64::from(link)))).collect();
        assert_eq!(passed, [true, true, true, true, false]);
    }
}
