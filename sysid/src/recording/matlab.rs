//! MATLAB files of level 5 (saved as version 6 or 7): the vectors of numbers in them.
//!
//! Our own reader: `matfile` 0.5 inflates without a limit and in itself without an end, writes to standard output, and multiplies
//! sizes that overflow.
//!
//! ```text
//! file    = header of 128 bytes, then elements
//! element = type, length (u32 each), bytes, filled up to a multiple of 8; or both in one u32 and up to 4 bytes behind
//! matrix  = element 14: flags, dimensions, name, numbers; or element 15, which is that matrix deflated
//! ```

use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

use crate::error::{Error, ErrorKind};
use crate::files::LARGEST_RECORDING;

const HEADER: usize = 128;
const MATRIX: u32 = 14;
const DEFLATED: u32 = 15;
/// Classes of matrices of numbers; the others are cells, structures, objects, text and sparse ones.
const NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;

/// A vector with its name.
pub(super) type Vector = (String, Vec<f64>);

/// The vectors of a file.
///
/// # Errors
/// A file that is cut off or damaged, or that would be too large once inflated.
pub(super) fn vectors(bytes: &[u8]) -> Result<Vec<Vector>, Error> {
    let end = bytes.get(HEADER - 2..HEADER).unwrap_or_default();
    let order = match end {
        b"IM" => Order { big: false },
        b"MI" => Order { big: true },
        _ => return Err(broken("a header that is cut off")),
    };
    let mut rest = &bytes[HEADER..];
    let mut left = LARGEST_RECORDING as usize;
    let mut found = Vec::new();
    while rest.len() >= 8 {
        let (kind, content) = order.element(&mut rest).ok_or_else(|| broken("an element that is cut off"))?;
        match kind {
            MATRIX => found.extend(order.vector(content)),
            DEFLATED => {
                let inflated = decompress_to_vec_zlib_with_limit(content, left)
                    .map_err(|_| broken("an element that cannot be inflated, or is too large"))?;
                left -= inflated.len();
                let mut inner = &inflated[..];
                if let Some((MATRIX, content)) = order.element(&mut inner) {
                    found.extend(order.vector(content));
                }
            }
            _ => {}
        }
    }
    Ok(found)
}

fn broken(what: &str) -> Error {
    let found = format!("a MATLAB file that cannot be read: {what}");
    Error::new(ErrorKind::Format, found, "in MATLAB save(FILE, '-v7') again")
}

/// The order of the bytes.
#[derive(Clone, Copy)]
struct Order {
    big: bool,
}

impl Order {
    fn word(self, bytes: &mut &[u8]) -> Option<u32> {
        let (word, rest) = bytes.split_first_chunk()?;
        *bytes = rest;
        Some(if self.big { u32::from_be_bytes(*word) } else { u32::from_le_bytes(*word) })
    }

    /// The next element: its type and its bytes.
    fn element<'b>(self, bytes: &mut &'b [u8]) -> Option<(u32, &'b [u8])> {
        let word = self.word(bytes)?;
        let (kind, length, room) = match word >> 16 {
            0 => {
                let length = self.word(bytes)? as usize;
                // deflated ones stand without a gap
                let room = if word == DEFLATED { length } else { length.checked_next_multiple_of(8)? };
                (word, length, room)
            }
            length => (word & 0xFFFF, length as usize, 4),
        };
        let content = bytes.get(..length).filter(|_| length <= room)?;
        *bytes = bytes.get(room..).unwrap_or_default();
        Some((kind, content))
    }

    /// A matrix, where it is a vector of numbers and whole.
    fn vector(self, mut matrix: &[u8]) -> Option<Vector> {
        let (_, mut flags) = self.element(&mut matrix)?;
        let class = self.word(&mut flags)? as u8;
        let (_, mut sizes) = self.element(&mut matrix)?;
        let sizes = [self.word(&mut sizes)?, self.word(&mut sizes)?];
        let (_, name) = self.element(&mut matrix)?;
        let (kind, data) = self.element(&mut matrix)?;
        let values = self.numbers(kind, data)?;
        let length = sizes.iter().map(|size| *size as usize).max()?;
        let is_vector = NUMBERS.contains(&class) && sizes.contains(&1) && values.len() == length;
        is_vector.then(|| (String::from_utf8_lossy(name).into_owned(), values))
    }

    /// The numbers of an element, whatever their type.
    fn numbers(self, kind: u32, bytes: &[u8]) -> Option<Vec<f64>> {
        macro_rules! each {
            ($of:ty) => {
                bytes
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&b| if self.big { <$of>::from_be_bytes(b) } else { <$of>::from_le_bytes(b) } as f64)
                    .collect()
            };
        }
        Some(match kind {
            1 => each!(i8),
            2 => each!(u8),
            3 => each!(i16),
            4 => each!(u16),
            5 => each!(i32),
            6 => each!(u32),
            7 => each!(f32),
            9 => each!(f64),
            12 => each!(i64),
            13 => each!(u64),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use miniz_oxide::deflate::compress_to_vec_zlib;

    fn element(kind: u32, content: &[u8], big: bool) -> Vec<u8> {
        let words = [kind, content.len() as u32];
        let mut bytes = words.map(if big { u32::to_be_bytes } else { u32::to_le_bytes }).concat();
        bytes.extend(content);
        if kind != DEFLATED {
            bytes.resize(bytes.len().next_multiple_of(8), 0);
        }
        bytes
    }

    fn matrix(name: &str, [kind, class]: [u32; 2], sizes: [u32; 2], data: &[u8], big: bool) -> Vec<u8> {
        let words =
            |words: [u32; 2]| words.map(if big { u32::to_be_bytes } else { u32::to_le_bytes }).concat();
        let parts = [
            element(6, &words([class, 0]), big),
            element(5, &words(sizes), big),
            element(1, name.as_bytes(), big),
            element(kind, data, big),
        ];
        element(MATRIX, &parts.concat(), big)
    }

    fn file(elements: &[Vec<u8>], big: bool) -> Vec<u8> {
        let mut file = b"MATLAB 5.0 MAT-file".to_vec();
        file.resize(124, b' ');
        file.extend(if big { b"\x01\x00MI" } else { b"\x00\x01IM" });
        file.extend(elements.concat());
        file
    }

    #[test]
    fn numbers_of_every_order_and_deflated_ones_are_read_and_other_classes_passed_over() {
        let data: Vec<u8> = [1i16, -2, 300].iter().flat_map(|x| x.to_le_bytes()).collect();
        let plain = matrix("a", [3, 6], [3, 1], &data, false);
        let deflated = element(DEFLATED, &compress_to_vec_zlib(&plain, 6), false);
        let text = matrix("text", [4, 4], [1, 3], &data, false);
        let square = matrix("square", [3, 6], [3, 3], &data, false);
        let short = matrix("short", [3, 6], [u32::MAX, 1], &data, false);
        let found = vectors(&file(&[text, square, deflated, short, plain], false)).unwrap();
        assert_eq!(found, vec![("a".to_owned(), vec![1.0, -2.0, 300.0]); 2]);
        let data: Vec<u8> = [0.5f64, -1e9].iter().flat_map(|x| x.to_be_bytes()).collect();
        let found = vectors(&file(&[matrix("b", [9, 6], [1, 2], &data, true)], true)).unwrap();
        assert_eq!(found, [("b".to_owned(), vec![0.5, -1e9])]);
    }

    #[test]
    fn what_is_cut_off_is_refused_and_zeros_that_inflate_are_no_vector() {
        let data = 1.0f64.to_le_bytes();
        let whole = file(&[matrix("a", [9, 6], [1, 1], &data, false)], false);
        for end in [0, 100, 127, whole.len() - 60] {
            assert!(vectors(&whole[..end]).is_err(), "{end}");
        }
        // zeros that inflate to more than is read, in a million times less
        let bomb = element(DEFLATED, &compress_to_vec_zlib(&vec![0; 1 << 24], 9), false);
        assert!(bomb.len() < 1 << 15);
        assert_eq!(vectors(&file(&[bomb], false)).unwrap(), []);
        let mut lying = file(&[], false);
        lying.extend([MATRIX, u32::MAX].map(u32::to_le_bytes).concat());
        assert!(vectors(&lying).unwrap_err().to_string().contains("cut off"));
    }
}
