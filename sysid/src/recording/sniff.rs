//! Tells what a file is when it is no recording: flight logs, archives, other encodings, other separators.

use super::fields::BLANKS;
use super::garbled::are_few;
use super::wall_clock;
use crate::error::{Error, ErrorKind};
use std::borrow::Cow;

/// First bytes, what they mean, what to do.
const SIGNATURES: [(&[u8], &str, &str); 9] = [
    (b"ULog", "a PX4 flight log (ULog)", LOG_ADVICE),
    (b"H Product:Blackbox", "a Betaflight blackbox log", LOG_ADVICE),
    (&[0xA3, 0x95], "an ArduPilot flight log (DataFlash)", LOG_ADVICE),
    (b"PK\x03\x04", "a zip archive or a spreadsheet (xlsx, ods)", "save the sheet as CSV with commas"),
    (&[0xD0, 0xCF, 0x11, 0xE0], "an old spreadsheet (xls)", "save the sheet as CSV with commas"),
    (&[0x1F, 0x8B], "a gzip archive", "unpack it first"),
    (b"MATLAB 7.3", "an HDF5 file of MATLAB 7.3", "in MATLAB save(FILE, '-v7'), or writetable to CSV"),
    (
        b"\x89HDF",
        "an HDF5 file (MATLAB 7.3 among others)",
        "in MATLAB save(FILE, '-v7'), or writetable to CSV",
    ),
    (b"SQLite format 3", "a database (ROS 2 bag among others)", "export the topics as CSV"),
];
const MARK: char = '\u{feff}';
const LOG_ADVICE: &str = "give it to pitchid show, diagnose or identify, which read it as it is";

/// The text without its byte order mark, if these bytes can be a CSV file at all. In a few garbled lines U+FFFD stands for what is no
/// text.
pub(super) fn text(bytes: &[u8]) -> Result<Cow<'_, str>, Error> {
    if bytes.is_empty() {
        return Err(Error::new(
            ErrorKind::Format,
            "the file is empty",
            "check that the logger has written it",
        )
        .expecting("a header line and one line per sample"));
    }
    let signature = SIGNATURES.iter().find(|(start, _, _)| bytes.starts_with(start));
    if let Some((_, what, advice)) = signature {
        return Err(
            Error::new(ErrorKind::Format, format!("this is {what}"), *advice).expecting("a UTF-8 CSV file")
        );
    }
    if let [0xFF, 0xFE, rest @ ..] | [0xFE, 0xFF, rest @ ..] = bytes {
        let is_little = bytes[0] == 0xFF;
        let unit = |pair: &[u8]| match is_little {
            true => u16::from_le_bytes([pair[0], pair[1]]),
            false => u16::from_be_bytes([pair[0], pair[1]]),
        };
        let units: Vec<u16> = rest.chunks_exact(2).map(unit).collect();
        return Ok(Cow::Owned(String::from_utf16_lossy(&units)));
    }
    let zero = bytes.iter().position(|&b| b == 0);
    let text = std::str::from_utf8(bytes);
    if let (None, Ok(text)) = (zero, text) {
        return Ok(Cow::Borrowed(text.strip_prefix(MARK).unwrap_or(text)));
    }
    if has_few_garbled(bytes) {
        let is_text =
            bytes.split(|&b| b == b'\n').next().is_some_and(|line| std::str::from_utf8(line).is_ok());
        // names with a degree sign as older programs write it
        let latin_1 = || bytes.iter().copied().map(char::from).collect::<String>();
        let text = if is_text { String::from_utf8_lossy(bytes) } else { Cow::Owned(latin_1()) };
        return Ok(Cow::Owned(text.strip_prefix(MARK).unwrap_or(&text).to_owned()));
    }
    if let Some(offset) = zero {
        let found = format!("a binary file (zero byte at offset {offset})");
        let advice = "convert the log to CSV with the columns of the recording format first";
        return Err(Error::new(ErrorKind::Format, found, advice)
            .at_line(line_at(bytes, offset))
            .expecting("a UTF-8 CSV file"));
    }
    let offset = text.err().map_or(0, |error| error.valid_up_to());
    let byte = bytes.get(offset).copied().unwrap_or_default();
    let found = format!("not UTF-8: byte 0x{byte:02x} at offset {offset}");
    Err(Error::new(ErrorKind::Format, found, "save the file as UTF-8, or write plain ASCII names and units")
        .at_line(line_at(bytes, offset))
        .expecting("a UTF-8 CSV file"))
}

/// Whether few lines hold bytes that are no text.
fn has_few_garbled(bytes: &[u8]) -> bool {
    let is_text = |line: &[u8]| !line.contains(&0) && std::str::from_utf8(line).is_ok();
    let lines = bytes.split(|&b| b == b'\n').map(is_text);
    let (all, garbled) =
        lines.fold((0, 0), |(all, garbled), is_text| (all + 1, garbled + usize::from(!is_text)));
    bytes.iter().take_while(|&&b| b != b'\n').all(|&b| b != 0) && are_few(garbled, all)
}

fn line_at(bytes: &[u8], offset: usize) -> usize {
    1 + bytes.iter().take(offset).filter(|&&b| b == b'\n').count()
}

/// What separates the columns: semicolons or tabs, where the header has no comma, or the row below as many of them; blanks, where the row
/// below is numbers between blanks; else commas.
pub(super) fn separator(header: &str, below: &str) -> u8 {
    let times = |line: &str, separator: u8| line.bytes().filter(|byte| *byte == separator).count();
    let separates = |separator: &u8| match times(header, *separator) {
        0 => false,
        some => !header.contains(',') || times(below, *separator) == some,
    };
    let otherwise = if is_between_blanks(below) { BLANKS } else { b',' };
    [b';', b'\t'].into_iter().find(separates).unwrap_or(otherwise)
}

/// Whether a row is two numbers or more between blanks, no comma among them but a decimal one.
pub(super) fn is_between_blanks(row: &str) -> bool {
    let whole = |word: &str| !word.starts_with(',') && !word.ends_with(',');
    let reads =
        |word: &str| word.replace(',', ".").parse::<f64>().is_ok() || wall_clock::seconds(word).is_some();
    let is_number = |word: &str| whole(word) && reads(word);
    let numbers = row.split_whitespace().filter(|word| is_number(word)).count();
    let words = row.split_whitespace().count();
    numbers >= 2 && (numbers == words || !row.contains(','))
}

/// What to do about a cell that is not a number.
pub(super) fn number_advice(cell: &str) -> &'static str {
    let digits =
        |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    if cell.split_once(',').is_some_and(|(whole, part)| digits(whole) && digits(part)) {
        "write decimals with a point"
    } else if cell.contains(':') {
        "write time as seconds, e.g. 12.34, or as 12:34:56.789 or 2024-05-03T12:34:56.789"
    } else {
        "correct the cell, empty it (then it is a gap), or delete the row; units belong in the header"
    }
}
