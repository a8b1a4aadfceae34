//! Recordings for MATLAB and for numpy: the columns as each of them keeps tables.

use std::borrow::Cow;
use std::io::Write;

use super::Recording;
use crate::error::Error;

/// Type numbers of MATLAB's elements and classes (MAT-File Format, level 5).
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const CLASS_CHAR: u32 = 4;
const CLASS_DOUBLE: u32 = 6;

/// A column of numbers, or of labels.
enum Column<'a> {
    Numbers(Cow<'a, [f64]>),
    Labels(Vec<&'a str>),
}

impl Recording {
    /// The columns of [`Self::write_csv`].
    fn all_columns(&self) -> Vec<(&str, Column<'_>)> {
        let numbers =
            self.number_columns().into_iter().map(|(name, values)| (name, Column::Numbers(values.into())));
        let flags = self.flags_as_numbers().into_iter();
        let flags = flags.map(|(name, values)| (name, Column::Numbers(values.into())));
        let labels = self.row_labels().map(|labels| ("section", Column::Labels(labels)));
        numbers.chain(flags).chain(labels).collect()
    }

    /// Writes a MATLAB file (level 5): a vector for each column of [`Self::write_csv`], `section` as rows of text.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_matlab(&self, mut out: impl Write) -> Result<(), Error> {
        let mut file = b"MATLAB 5.0 MAT-file, a recording of pitchid".to_vec();
        file.resize(124, b' ');
        // version, and the order of the bytes
        file.extend([0x00, 0x01, b'I', b'M']);
        for (name, column) in self.all_columns() {
            let mut matrix = Vec::new();
            let (class, columns) = match &column {
                Column::Numbers(_) => (CLASS_DOUBLE, 1),
                Column::Labels(labels) => (CLASS_CHAR, widest(labels)),
            };
            element(&mut matrix, UINT32, &[class, 0].map(u32::to_le_bytes).concat());
            element(&mut matrix, INT32, &[self.len() as u32, columns as u32].map(u32::to_le_bytes).concat());
            element(&mut matrix, INT8, name.as_bytes());
            match &column {
                Column::Numbers(values) => {
                    element(
                        &mut matrix,
                        DOUBLE,
                        &values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>(),
                    );
                }
                Column::Labels(labels) => element(&mut matrix, UINT16, &characters(labels, columns)),
            }
            element(&mut file, MATRIX, &matrix);
        }
        out.write_all(&file).map_err(|error| Error::from_io(&self.name, &error))
    }

    /// Writes a structured array of numpy (`.npy`, version 1): a field for each column of [`Self::write_csv`].
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_numpy(&self, mut out: impl Write) -> Result<(), Error> {
        let columns = self.all_columns();
        let kind = |column: &Column<'_>| match column {
            Column::Numbers(_) => "<f8".to_owned(),
            Column::Labels(labels) => format!("<U{}", widest(labels)),
        };
        let fields: Vec<String> =
            columns.iter().map(|(name, column)| format!("('{name}', '{}')", kind(column))).collect();
        let rows = self.len();
        let mut header =
            format!("{{'descr': [{}], 'fortran_order': False, 'shape': ({rows},), }}", fields.join(", "));
        // magic, version and length take ten bytes; the data begin at a multiple of 64
        let padding = (64 - (10 + header.len() + 1) % 64) % 64;
        header.push_str(&" ".repeat(padding));
        header.push('\n');
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend((header.len() as u16).to_le_bytes());
        file.extend(header.as_bytes());
        for row in 0..rows {
            for (_, column) in &columns {
                match column {
                    Column::Numbers(values) => file.extend(values[row].to_le_bytes()),
                    Column::Labels(labels) => {
                        let text = labels[row].chars().map(u32::from).chain(std::iter::repeat(0));
                        file.extend(text.take(widest(labels)).flat_map(u32::to_le_bytes));
                    }
                }
            }
        }
        out.write_all(&file).map_err(|error| Error::from_io(&self.name, &error))
    }
}

/// An element of a MATLAB file: type, length, bytes, filled up to a multiple of eight.
fn element(out: &mut Vec<u8>, kind: u32, bytes: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(bytes);
    out.resize(out.len().next_multiple_of(8), 0);
}

/// Characters of the longest label.
fn widest(labels: &[&str]) -> usize {
    labels.iter().map(|label| label.chars().count()).max().unwrap_or(0).max(1)
}

/// Labels as a matrix of characters, column by column, as MATLAB keeps them.
fn characters(labels: &[&str], columns: usize) -> Vec<u8> {
    let rows: Vec<Vec<u16>> = labels.iter().map(|label| label.encode_utf16().collect()).collect();
    let place =
        |column: usize| rows.iter().map(move |row| row.get(column).copied().unwrap_or(u16::from(b' ')));
    (0..columns).flat_map(place).flat_map(u16::to_le_bytes).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{ReadOptions, as_csv, parse};
    use super::*;

    fn recording() -> Recording {
        let mut text = "t_s,u_rad,q_rad_s,section,supervised\n".to_owned();
        for k in 0..200 {
            let t = 0.02 * f64::from(k);
            text += &format!(
                "{t:.2},{},{},{},{}\n",
                t.sin(),
                t.cos(),
                if k < 100 { "I" } else { "IV" },
                u8::from(k == 7)
            );
        }
        parse("a.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
    }

    #[test]
    fn what_is_written_for_matlab_reads_back() {
        let recording = recording();
        let mut bytes = Vec::new();
        recording.write_matlab(&mut bytes).unwrap();
        assert_eq!(&bytes[124..128], [0, 1, b'I', b'M']);
        // the first matrix: t_s, 200 by 1 doubles
        assert_eq!(bytes[128..132], MATRIX.to_le_bytes());
        assert_eq!(bytes[144..148], CLASS_DOUBLE.to_le_bytes());
        assert_eq!(bytes[160..168], [200u32, 1].map(u32::to_le_bytes).concat());
        assert_eq!(&bytes[176..179], b"t_s");
        let again = parse("a.csv", &as_csv("a.mat", bytes).unwrap(), &ReadOptions::default()).unwrap();
        assert_eq!((&again.t, &again.u, &again.q), (&recording.t, &recording.u, &recording.q));
        assert_eq!(again.supervised, recording.supervised);
    }

    #[test]
    fn what_is_written_for_numpy_has_its_layout() {
        let recording = recording();
        let mut bytes = Vec::new();
        recording.write_numpy(&mut bytes).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(header.contains("('t_s', '<f8')") && header.contains("('section', '<U2')"), "{header}");
        assert!(header.contains("'shape': (200,)") && header.ends_with('\n'), "{header}");
        let row = 4 * 8 + 2 * 4;
        assert_eq!(bytes.len(), 10 + length + 200 * row);
        let second = &bytes[10 + length + row..];
        assert_eq!(second[..8], recording.t[1].to_le_bytes());
        assert_eq!(second[32..40], [u32::from(b'I'), 0].map(u32::to_le_bytes).concat());
    }
}
