//! Frames out of a stream of bytes.
//!
//! Bytes are kept until they make a frame of a known message with a valid checksum. When they cannot, the first of them is
//! dropped and the search for a start goes on *within* what is kept, so a frame that follows garbage is not lost.

use messages::calculate_crc;

/// First byte of a MAVLink 2 frame.
const START: u8 = 0xFD;
const HEADER: usize = 10;
const CHECKSUM: usize = 2;
/// Length of the signature of a signed frame.
pub const SIGNATURE: usize = 13;
/// Longest frame.
pub const LONGEST: usize = HEADER + 255 + CHECKSUM + SIGNATURE;
/// Incompatibility flag of a signed frame.
pub const SIGNED: u8 = 1;

/// A frame with a valid checksum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    bytes: &'a [u8],
}

impl<'a> Frame<'a> {
    /// Id of the message.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.bytes.get(7..10).map_or(0, |id| id.iter().rev().fold(0, |sum, &b| (sum << 8) | u32::from(b)))
    }

    /// Ids of the system and the component that say to have sent it.
    #[must_use]
    pub const fn sender(&self) -> [u8; 2] {
        [self.bytes[5], self.bytes[6]]
    }

    /// The message's payload, without the zeros that were cut off its end.
    #[must_use]
    pub fn payload(&self) -> &'a [u8] {
        self.bytes.get(HEADER..HEADER + usize::from(self.bytes[1])).unwrap_or_default()
    }

    /// The whole frame up to and with the checksum, and the signature if there is one.
    #[must_use]
    pub fn parts(&self) -> (&'a [u8], Option<&'a [u8]>) {
        let signed = self.bytes[2] & SIGNED != 0;
        let end = if signed { self.bytes.len().saturating_sub(SIGNATURE) } else { self.bytes.len() };
        let (body, rest) = self.bytes.split_at(end);
        (body, signed.then_some(rest))
    }
}

/// Bytes that may become a frame.
#[derive(Clone, Debug)]
pub struct Decoder {
    bytes: [u8; LONGEST],
    length: usize,
    extra_crc: fn(u32) -> Option<u8>,
}

/// What the kept bytes are.
enum Standing {
    Incomplete,
    Whole(usize),
    Wrong,
}

impl Decoder {
    /// A decoder of the messages for which `extra_crc` knows the seed of the checksum.
    #[must_use]
    pub const fn new(extra_crc: fn(u32) -> Option<u8>) -> Self {
        Self { bytes: [0; LONGEST], length: 0, extra_crc }
    }

    /// Takes one byte; hands over at most one frame, to `take`.
    pub fn push(&mut self, byte: u8, take: impl FnOnce(Frame<'_>)) {
        if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
        loop {
            match self.standing() {
                Standing::Incomplete => return,
                Standing::Wrong => self.drop_first(1),
                Standing::Whole(length) => {
                    take(Frame { bytes: &self.bytes[..length] });
                    return self.drop_first(length);
                }
            }
        }
    }

    fn standing(&self) -> Standing {
        let kept = &self.bytes[..self.length.min(LONGEST)];
        match kept {
            [] => return Standing::Incomplete,
            [first, ..] if *first != START => return Standing::Wrong,
            [_, _, flags, ..] if flags & !SIGNED != 0 => return Standing::Wrong,
            [_] | [_, _] => return Standing::Incomplete,
            _ => {}
        }
        let checked = HEADER + usize::from(kept[1]);
        let signature = if kept[2] & SIGNED != 0 { SIGNATURE } else { 0 };
        let length = checked + CHECKSUM + signature;
        if kept.len() >= HEADER && (self.extra_crc)(Frame { bytes: kept }.id()).is_none() {
            return Standing::Wrong;
        }
        let Some(frame) = kept.get(..length) else { return Standing::Incomplete };
        let sound = (self.extra_crc)(Frame { bytes: frame }.id()).is_some_and(|extra| {
            frame[checked..][..2] == calculate_crc(&frame[1..checked], extra).to_le_bytes()
        });
        if sound { Standing::Whole(length) } else { Standing::Wrong }
    }

    /// Drops `count` bytes and what follows them up to the next start.
    fn drop_first(&mut self, count: usize) {
        let kept = &self.bytes[..self.length.min(LONGEST)];
        let rest = kept.get(count..).unwrap_or_default();
        let start = rest.iter().position(|&b| b == START).map_or(kept.len(), |place| count + place);
        self.bytes.copy_within(start..self.length, 0);
        self.length -= start;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::frame::{Header, encode};
    use messages::MessageData;
    use messages::board::{HEARTBEAT_DATA, MANUAL_CONTROL_DATA};
    use proptest::prelude::*;

    fn known(id: u32) -> Option<u8> {
        (id == MANUAL_CONTROL_DATA::ID).then_some(MANUAL_CONTROL_DATA::EXTRA_CRC)
    }

    fn message(x: i16) -> Vec<u8> {
        let data = MANUAL_CONTROL_DATA { x, target: 1, ..MANUAL_CONTROL_DATA::default() };
        encode(Header { sequence: x as u8, system: 255, component: 0 }, &data).as_slice().to_vec()
    }

    fn decode(bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut decoder = Decoder::new(known);
        let mut found = Vec::new();
        bytes.iter().for_each(|&byte| decoder.push(byte, |frame| found.push(frame.bytes.to_vec())));
        found
    }

    #[test]
    fn a_message_of_another_kind_is_passed_over() {
        let other = encode(Header { sequence: 0, system: 1, component: 1 }, &HEARTBEAT_DATA::default());
        let mut stream = other.as_slice().to_vec();
        stream.extend(message(7));
        assert_eq!(decode(&stream), [message(7)]);
    }

    #[test]
    fn a_truncated_frame_costs_no_frame_that_follows_once_its_length_is_filled() {
        let mut stream = message(300)[..9].to_vec();
        (0..3).for_each(|x| stream.extend(message(x)));
        assert_eq!(decode(&stream), [message(0), message(1), message(2)]);
    }

    proptest! {
        #[test]
        fn garbage_between_frames_never_panics_and_every_frame_is_found(
            garbage in proptest::collection::vec(any::<u8>(), 0..700), x in any::<i16>()
        ) {
            let mut stream = garbage;
            stream.extend(message(x));
            // a start in the garbage may claim up to 280 bytes
            stream.extend([0; 300]);
            prop_assert!(decode(&stream).contains(&message(x)));
        }

        #[test]
        fn a_flipped_bit_is_noticed(x in any::<i16>(), place in 0_usize..20, bit in 0_u8..8) {
            let mut bytes = message(x);
            let place = place % bytes.len();
            bytes[place] ^= 1 << bit;
            bytes.extend([0; 300]);
            prop_assert!(decode(&bytes).is_empty());
        }
    }
}
