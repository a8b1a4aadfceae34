//! How the fields of blackbox frames are written, and what they are predicted from.

/// Bytes of one flight, read from front to back.
pub(super) struct Stream<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl Stream<'_> {
    pub(super) fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    /// Seven bits to a byte, the lowest first; the highest bit says that another follows.
    pub(super) fn unsigned(&mut self) -> Option<u32> {
        let mut value = 0_u32;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f).checked_shl(shift)?;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// The same with the sign in the lowest bit.
    pub(super) fn signed(&mut self) -> Option<i32> {
        let value = self.unsigned()?;
        Some((value >> 1) as i32 ^ -((value & 1) as i32))
    }

    fn little_endian(&mut self, bytes: u32) -> Option<i32> {
        let mut value = 0;
        for i in 0..bytes {
            value |= u32::from(self.byte()?) << (8 * i);
        }
        Some(extend(value, 8 * bytes))
    }

    /// Up to eight numbers: a byte with a bit for each that is not zero, then those.
    fn tag8_8svb(&mut self, count: usize) -> Option<[i32; 8]> {
        let mut values = [0; 8];
        if count == 1 {
            values[0] = self.signed()?;
            return Some(values);
        }
        let tags = self.byte()?;
        for (i, value) in values.iter_mut().enumerate().take(count) {
            if tags >> i & 1 == 1 {
                *value = self.signed()?;
            }
        }
        Some(values)
    }

    /// Three numbers of 2, 4, 6 bits, or of 8, 16, 24, 32 each.
    fn tag2_3s32(&mut self) -> Option<[i32; 8]> {
        let lead = u32::from(self.byte()?);
        Some(match lead >> 6 {
            0 => triple(extend(lead >> 4, 2), extend(lead >> 2, 2), extend(lead, 2)),
            1 => {
                let next = u32::from(self.byte()?);
                triple(extend(lead, 4), extend(next >> 4, 4), extend(next, 4))
            }
            2 => {
                let (second, third) = (u32::from(self.byte()?), u32::from(self.byte()?));
                triple(extend(lead, 6), extend(second, 6), extend(third, 6))
            }
            _ => {
                let mut width = |shift: u32| self.little_endian((lead >> shift & 3) + 1);
                triple(width(0)?, width(2)?, width(4)?)
            }
        })
    }

    /// Three numbers of 2, 5 or 5.5 bits, or of 8, 16, 24, 32 each.
    fn tag2_3svariable(&mut self) -> Option<[i32; 8]> {
        let lead = u32::from(self.byte()?);
        Some(match lead >> 6 {
            0 => triple(extend(lead >> 4, 2), extend(lead >> 2, 2), extend(lead, 2)),
            1 => {
                let next = u32::from(self.byte()?);
                let second = (lead & 1) << 4 | next >> 4;
                triple(extend(lead >> 1, 5), extend(second, 5), extend(next, 4))
            }
            2 => {
                let (second, third) = (u32::from(self.byte()?), u32::from(self.byte()?));
                let first = (lead & 0x3f) << 2 | second >> 6;
                let middle = (second & 0x3f) << 1 | third >> 7;
                triple(extend(first, 8), extend(middle, 7), extend(third, 7))
            }
            _ => {
                let mut width = |shift: u32| self.little_endian((lead >> shift & 3) + 1);
                triple(width(0)?, width(2)?, width(4)?)
            }
        })
    }

    /// Four numbers of 0, 4, 8 or 16 bits, high nibble first, without alignment.
    fn tag8_4s16(&mut self) -> Option<[i32; 8]> {
        let tags = self.byte()?;
        let mut values = [0; 8];
        // The low nibble of a byte of which the high one is used up.
        let mut rest: Option<u32> = None;
        for (i, value) in values.iter_mut().enumerate().take(4) {
            let bits = [0, 4, 8, 16][usize::from(tags >> (2 * i) & 3)];
            let mut wanted = bits / 4;
            let mut number = 0;
            while wanted > 0 {
                let nibble = match rest.take() {
                    Some(nibble) => nibble,
                    None => {
                        let byte = u32::from(self.byte()?);
                        rest = Some(byte & 0xf);
                        byte >> 4
                    }
                };
                number = number << 4 | nibble;
                wanted -= 1;
            }
            *value = if bits == 0 { 0 } else { extend(number, bits) };
        }
        Some(values)
    }
}

fn triple(a: i32, b: i32, c: i32) -> [i32; 8] {
    [a, b, c, 0, 0, 0, 0, 0]
}

/// The lowest `bits` of `value` as a number with a sign.
fn extend(value: u32, bits: u32) -> i32 {
    (value << (32 - bits)) as i32 >> (32 - bits)
}

/// How fields are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Signed,
    Unsigned,
    Negative14,
    Tag8x8,
    Tag2x3,
    Tag8x4,
    Null,
    Tag2x3Variable,
}

impl Encoding {
    pub(super) fn of(code: u16) -> Option<Self> {
        Some(match code {
            0 => Self::Signed,
            1 => Self::Unsigned,
            3 => Self::Negative14,
            6 => Self::Tag8x8,
            7 => Self::Tag2x3,
            8 => Self::Tag8x4,
            9 => Self::Null,
            10 => Self::Tag2x3Variable,
            _ => return None,
        })
    }

    /// How many fields of this encoding in a row are written together.
    pub(super) fn together(self) -> usize {
        match self {
            Self::Tag8x8 => 8,
            Self::Tag8x4 => 4,
            Self::Tag2x3 | Self::Tag2x3Variable => 3,
            _ => 1,
        }
    }

    /// Reads the next `count` fields; unsigned ones as the same 32 bits.
    pub(super) fn read(self, stream: &mut Stream, count: usize) -> Option<[i32; 8]> {
        Some(match self {
            Self::Signed => triple(stream.signed()?, 0, 0),
            Self::Unsigned => triple(stream.unsigned()? as i32, 0, 0),
            Self::Negative14 => triple(-extend(stream.unsigned()?, 14), 0, 0),
            Self::Tag8x8 => stream.tag8_8svb(count)?,
            Self::Tag2x3 => stream.tag2_3s32()?,
            Self::Tag8x4 => stream.tag8_4s16()?,
            Self::Null => [0; 8],
            Self::Tag2x3Variable => stream.tag2_3svariable()?,
        })
    }
}

/// What a field is the difference from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Predictor {
    Zero,
    Previous,
    StraightLine,
    Average2,
    MinThrottle,
    Motor0,
    Increment,
    HomeCoordinate,
    Middle1500,
    BatteryReference,
    MainTime,
    MinMotor,
}

impl Predictor {
    pub(super) fn of(code: u16) -> Option<Self> {
        Some(match code {
            0 => Self::Zero,
            1 => Self::Previous,
            2 => Self::StraightLine,
            3 => Self::Average2,
            4 => Self::MinThrottle,
            5 => Self::Motor0,
            6 => Self::Increment,
            7 => Self::HomeCoordinate,
            8 => Self::Middle1500,
            9 => Self::BatteryReference,
            10 => Self::MainTime,
            11 => Self::MinMotor,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(encoding: Encoding, count: usize, bytes: &[u8]) -> Option<(Vec<i32>, usize)> {
        let mut stream = Stream { bytes, at: 0 };
        let values = encoding.read(&mut stream, count)?;
        Some((values[..count].to_vec(), stream.at))
    }

    #[test]
    fn numbers_of_variable_length() {
        assert_eq!(read(Encoding::Unsigned, 1, &[0x80, 0x01]), Some((vec![128], 2)));
        assert_eq!(read(Encoding::Signed, 1, &[0x03]), Some((vec![-2], 1)));
        assert_eq!(read(Encoding::Negative14, 1, &[0x05]), Some((vec![-5], 1)));
        assert_eq!(read(Encoding::Unsigned, 1, &[0xff; 5]), None);
        assert_eq!(read(Encoding::Unsigned, 1, &[0x80]), None);
    }

    #[test]
    fn groups() {
        assert_eq!(read(Encoding::Tag8x8, 3, &[0b101, 0x02, 0x01]), Some((vec![1, 0, -1], 3)));
        assert_eq!(read(Encoding::Tag2x3, 3, &[0b00_01_10_11]), Some((vec![1, -2, -1], 1)));
        assert_eq!(read(Encoding::Tag2x3, 3, &[0x47, 0x8f]), Some((vec![7, -8, -1], 2)));
        assert_eq!(read(Encoding::Tag2x3, 3, &[0x9f, 0x20, 0x3f]), Some((vec![31, -32, -1], 3)));
        let wide = [0b11_10_01_00, 0xff, 0x34, 0x12, 0xff, 0xff, 0xff];
        assert_eq!(read(Encoding::Tag2x3, 3, &wide), Some((vec![-1, 0x1234, -1], 7)));
        assert_eq!(
            read(Encoding::Tag8x4, 4, &[0b01_00_11_01, 0x71, 0x23, 0x4f]),
            Some((vec![7, 0x1234, 0, -1], 4))
        );
        assert_eq!(read(Encoding::Tag2x3Variable, 3, &[0b0101_1111, 0x0f]), Some((vec![15, -16, -1], 2)));
    }
}
