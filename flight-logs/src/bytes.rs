//! Numbers and text out of bytes that may end anywhere.

/// The `N` bytes at `at`, if they are there.
pub(crate) fn array<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..)?.first_chunk().copied()
}

/// Text up to its first zero byte; what is not UTF-8 is replaced.
pub(crate) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).trim_end().to_owned()
}

/// Where `pattern` first stands in `bytes`.
pub(crate) fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes.windows(pattern.len()).position(|window| window == pattern)
}

/// A number in one of the encodings that loggers share, little endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Number {
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number at `at`; 64-bit integers beyond 2⁵³ lose their last digits.
    pub(crate) fn read(self, bytes: &[u8], at: usize) -> Option<f64> {
        Some(match self {
            Self::I8 => f64::from(i8::from_le_bytes(array(bytes, at)?)),
            Self::U8 => f64::from(u8::from_le_bytes(array(bytes, at)?)),
            Self::I16 => f64::from(i16::from_le_bytes(array(bytes, at)?)),
            Self::U16 => f64::from(u16::from_le_bytes(array(bytes, at)?)),
            Self::I32 => f64::from(i32::from_le_bytes(array(bytes, at)?)),
            Self::U32 => f64::from(u32::from_le_bytes(array(bytes, at)?)),
            Self::I64 => i64::from_le_bytes(array(bytes, at)?) as f64,
            Self::U64 => u64::from_le_bytes(array(bytes, at)?) as f64,
            Self::F16 => half(u16::from_le_bytes(array(bytes, at)?)),
            Self::F32 => f64::from(f32::from_le_bytes(array(bytes, at)?)),
            Self::F64 => f64::from_le_bytes(array(bytes, at)?),
        })
    }
}

/// IEEE 754 binary16: sign, 5 bits of exponent, 10 of fraction.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    sign * match i32::from(bits >> 10 & 0x1f) {
        0 => fraction * (-14_f64).exp2(),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1.0 + fraction) * f64::from(exponent - 15).exp2(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats() {
        for (bits, value) in [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 2f64.powi(-24))] {
            assert_eq!(half(bits), value);
        }
        assert_eq!(half(0x7c00), f64::INFINITY);
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn numbers_end_with_the_bytes() {
        assert_eq!(Number::I16.read(&[0, 0xff, 0xff], 1), Some(-1.0));
        assert_eq!(Number::I16.read(&[0, 0xff, 0xff], 2), None);
        assert_eq!(Number::F64.read(&[], usize::MAX), None);
        assert_eq!(text(b"ab \0cd"), "ab");
    }
}
