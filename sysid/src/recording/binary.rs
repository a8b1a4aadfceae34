//! Recordings that other programs keep in binary tables: Parquet (pandas, polars) and MATLAB files, read as the CSV file with the
//! same columns, and Parquet written.

use std::io::Write;
use std::panic::catch_unwind;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, RowGroupMetaData};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::Field;
use parquet::schema::types::Type;

use super::Recording;
use crate::error::{Error, ErrorKind};
use crate::files::LARGEST_RECORDING;

/// The file's content as CSV: what is no binary table is left as it is.
pub(super) fn as_csv(bytes: Vec<u8>) -> Result<Vec<u8>, Error> {
    match () {
        () if bytes.starts_with(b"PAR1") => {
            // at some damaged pages the crate panics
            let read = catch_unwind(|| of_parquet(bytes));
            let damaged = |_| Err(ParquetError::General("a page is damaged".into()));
            read.unwrap_or_else(damaged).map_err(|error| {
                let found = format!("a Parquet table that cannot be read: {error}");
                Error::new(ErrorKind::Format, found, "write the table again, or as CSV")
            })
        }
        () if bytes.starts_with(b"MATLAB 5.0") => of_matlab(&bytes),
        () => Ok(bytes),
    }
}

fn of_parquet(bytes: Vec<u8>) -> Result<Vec<u8>, ParquetError> {
    let length = bytes.len() as i64;
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes))?;
    check_places(reader.metadata(), length)?;
    let names: Vec<String> =
        reader.metadata().file_metadata().schema().get_fields().iter().map(|f| f.name().to_owned()).collect();
    let mut csv = csv::Writer::from_writer(Vec::new());
    let failed = |error: csv::Error| ParquetError::General(error.to_string());
    csv.write_record(&names).map_err(failed)?;
    for row in reader.get_row_iter(None)? {
        let row = row?;
        csv.write_record(row.get_column_iter().map(|(_, field)| cell(field))).map_err(failed)?;
        // a few bytes can stand for any number of rows
        if csv.get_ref().len() as u64 > LARGEST_RECORDING {
            return Err(ParquetError::General(format!("more than {} MiB as text", LARGEST_RECORDING >> 20)));
        }
    }
    csv.into_inner().map_err(|error| ParquetError::General(error.to_string()))
}

/// Refuses columns of columns, and places that are not in a file of so many bytes: the reader panics at some of them.
fn check_places(metadata: &ParquetMetaData, length: i64) -> Result<(), ParquetError> {
    let flat = |field: &Arc<Type>| {
        field.is_primitive() && field.get_basic_info().repetition() != Repetition::REPEATED
    };
    if !metadata.file_metadata().schema().get_fields().iter().all(flat) {
        return Err(ParquetError::General("a column that holds others".into()));
    }
    let within = |column: &ColumnChunkMetaData| {
        let start = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let sizes = [start, column.data_page_offset(), column.compressed_size()];
        sizes.into_iter().all(|size| (0..=length).contains(&size))
            && start + column.compressed_size() <= length
            && column.uncompressed_size() >= 0
            && column.num_values() >= 0
    };
    let sound = |group: &RowGroupMetaData| group.num_rows() >= 0 && group.columns().iter().all(within);
    match metadata.row_groups().iter().all(sound) {
        true => Ok(()),
        false => Err(ParquetError::General("a column that lies outside the file".into())),
    }
}

/// What stands in a cell; nothing for a null, seconds for a time.
fn cell(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Bool(flag) => u8::from(*flag).to_string(),
        Field::Byte(number) => number.to_string(),
        Field::Short(number) => number.to_string(),
        Field::Int(number) => number.to_string(),
        Field::Long(number) => number.to_string(),
        Field::UByte(number) => number.to_string(),
        Field::UShort(number) => number.to_string(),
        Field::UInt(number) => number.to_string(),
        Field::ULong(number) => number.to_string(),
        Field::Float(number) => number.to_string(),
        Field::Double(number) => number.to_string(),
        Field::Str(text) => text.clone(),
        Field::TimeMillis(time) => (f64::from(*time) / 1e3).to_string(),
        Field::TimestampMillis(time) => (*time as f64 / 1e3).to_string(),
        Field::TimeMicros(time) | Field::TimestampMicros(time) => (*time as f64 / 1e6).to_string(),
        other => other.to_string(),
    }
}

/// The numeric vectors that are as long as the longest.
fn of_matlab(bytes: &[u8]) -> Result<Vec<u8>, Error> {
    let refuse = |found: String, advice: &'static str| Error::new(ErrorKind::Format, found, advice);
    let vectors = super::matlab::vectors(bytes)?;
    let rows = vectors.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    let columns: Vec<_> = vectors.into_iter().filter(|(_, values)| values.len() == rows).collect();
    if rows < 2 {
        let advice = "save the columns as vectors with names of the format: t_s, u_rad, q_rad_s, theta_rad";
        return Err(refuse("a MATLAB file without vectors of numbers".into(), advice));
    }
    let mut csv = csv::Writer::from_writer(Vec::new());
    let failed = |error: csv::Error| refuse(error.to_string(), "save the columns as vectors");
    csv.write_record(columns.iter().map(|(name, _)| name)).map_err(failed)?;
    for row in 0..rows {
        csv.write_record(columns.iter().map(|(_, values)| values[row].to_string())).map_err(failed)?;
    }
    csv.into_inner().map_err(|error| refuse(error.to_string(), "save the columns as vectors"))
}

impl Recording {
    /// Writes a Parquet table with the columns of [`Self::write_csv`].
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_parquet(&self, out: impl Write + Send) -> Result<(), Error> {
        self.write_table(out).map_err(|error| {
            Error::new(ErrorKind::Format, format!("the table could not be written: {error}"), "write CSV")
                .in_file(self.name.as_str())
        })
    }

    fn write_table(&self, out: impl Write + Send) -> Result<(), ParquetError> {
        let columns = self.number_columns();
        let flags = self.flags_as_numbers();
        let labels = self.row_labels();
        let field = |name: &str, physical: Physical, logical: Option<LogicalType>| {
            let of_rows = Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED);
            of_rows.with_logical_type(logical).build().map(Arc::new)
        };
        let mut fields = columns
            .iter()
            .map(|(name, _)| field(name, Physical::DOUBLE, None))
            .chain(flags.iter().map(|(name, _)| field(name, Physical::DOUBLE, None)))
            .collect::<Result<Vec<_>, _>>()?;
        if labels.is_some() {
            fields.push(field("section", Physical::BYTE_ARRAY, Some(LogicalType::String))?);
        }
        let schema = Type::group_type_builder("recording").with_fields(fields).build()?;
        let properties =
            WriterProperties::builder().set_compression(parquet::basic::Compression::SNAPPY).build();
        let mut writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
        let mut rows = writer.next_row_group()?;
        let missing = || ParquetError::General("a column is missing".into());
        for values in
            columns.iter().map(|(_, values)| *values).chain(flags.iter().map(|(_, values)| values.as_slice()))
        {
            let mut column = rows.next_column()?.ok_or_else(missing)?;
            column.typed::<DoubleType>().write_batch(values, None, None)?;
            column.close()?;
        }
        if let Some(labels) = labels {
            let labels: Vec<ByteArray> = labels.into_iter().map(ByteArray::from).collect();
            let mut column = rows.next_column()?.ok_or_else(missing)?;
            column.typed::<ByteArrayType>().write_batch(&labels, None, None)?;
            column.close()?;
        }
        rows.close()?;
        writer.close().map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ReadOptions, parse};
    use super::*;

    fn recording() -> Recording {
        let mut text = "t_s,u_rad,q_rad_s,section,supervised\n".to_owned();
        for k in 0..200 {
            let t = 0.02 * f64::from(k);
            let label = if k < 100 { "I" } else { "IV" };
            text += &format!("{t:.2},{},{},{label},{}\n", t.sin(), t.cos(), u8::from(k == 7));
        }
        parse("a.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
    }

    fn read_back(bytes: Vec<u8>) -> Result<Recording, Error> {
        parse("a.csv", &as_csv(bytes)?, &ReadOptions::default())
    }

    #[test]
    fn what_is_written_as_parquet_reads_back() {
        let recording = recording();
        let mut bytes = Vec::new();
        recording.write_parquet(&mut bytes).unwrap();
        let again = read_back(bytes).unwrap();
        assert_eq!((&again.t, &again.u, &again.q), (&recording.t, &recording.u, &recording.q));
        assert_eq!((&again.sections, &again.supervised), (&recording.sections, &recording.supervised));
    }

    #[test]
    fn a_damaged_table_is_read_or_refused() {
        let mut whole = Vec::new();
        recording().write_parquet(&mut whole).unwrap();
        let mut refused = 0;
        for place in (4..whole.len()).step_by(7) {
            for change in [0xff, 0x80, 1] {
                let mut damaged = whole.clone();
                damaged[place] ^= change;
                refused += u32::from(as_csv(damaged).is_err());
            }
        }
        assert!(refused > 100, "{refused}");
    }

    /// A MATLAB file of version 5 with one double matrix per name.
    fn matlab(vectors: &[(&str, Vec<f64>)]) -> Vec<u8> {
        let mut file = b"MATLAB 5.0 MAT-file".to_vec();
        file.resize(124, b' ');
        file.extend([0x00, 0x01, b'I', b'M']);
        for (name, values) in vectors {
            let element = |kind: u32, content: &[u8]| {
                let mut bytes = [kind, content.len() as u32].map(u32::to_le_bytes).concat();
                bytes.extend(content);
                bytes.resize(bytes.len().next_multiple_of(8), 0);
                bytes
            };
            let size = [values.len() as i32, 1].map(i32::to_le_bytes).concat();
            let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            let flags = [6u32, 0].map(u32::to_le_bytes).concat();
            let parts =
                [element(6, &flags), element(5, &size), element(1, name.as_bytes()), element(9, &data)];
            file.extend(element(14, &parts.concat()));
        }
        file
    }

    #[test]
    fn vectors_of_a_matlab_file_are_columns() {
        let recording = recording();
        let q = recording.q.clone().unwrap();
        let file = matlab(&[
            ("t_s", recording.t.clone()),
            ("u_rad", recording.u.clone()),
            ("q_rad_s", q),
            ("mass", vec![3.0]),
        ]);
        let again = read_back(file).unwrap();
        assert_eq!((&again.t, &again.u, &again.q), (&recording.t, &recording.u, &recording.q));
        let refused = read_back(matlab(&[("mass", vec![3.0])])).unwrap_err().to_string();
        assert!(refused.contains("without vectors") && refused.contains("t_s, u_rad"), "{refused}");
    }

    #[test]
    fn damaged_tables_are_refused_and_never_panic() {
        let mut parquet = Vec::new();
        recording().write_parquet(&mut parquet).unwrap();
        let matlab = matlab(&[("t_s", recording().t), ("u_rad", recording().u)]);
        let mut state = 1u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize % below
        };
        for whole in [parquet, matlab] {
            assert!(as_csv(whole.clone()).is_ok());
            for _ in 0..400 {
                let mut bytes = whole.clone();
                match random(3) {
                    0 => bytes.truncate(random(whole.len())),
                    1 => bytes.iter_mut().skip(random(whole.len())).take(8).for_each(|byte| *byte = 0xFF),
                    _ => {
                        let at = random(whole.len());
                        bytes[at] ^= 1 << random(8);
                    }
                }
                let _ = as_csv(bytes);
            }
        }
    }
}
