//! What MAVLink's messages hold: `messages.txt` has the dialect `ardupilotmega` with all that it includes, one message a line:
//! number, name, fields in the order of the wire (`type[length]:name`, `?` after the type of a choice or of flags), and
//! behind `+` those that MAVLink 2 added (<https://mavlink.io/en/guide/serialization.html>).
//!
//! Every packet's checksum covers the definition of its message, so a line that were wrong would read no packet.

use crate::bytes::{Number, text};
use crc_any::CRCu16;
use std::sync::LazyLock;

/// All messages, by number.
static MESSAGES: LazyLock<Vec<Message>> =
    LazyLock::new(|| include_str!("messages.txt").lines().filter_map(Message::parse).collect());

/// A kind of message.
pub struct Message {
    id: u32,
    /// Its name.
    pub name: &'static str,
    /// What goes into the checksum for this definition.
    pub extra_crc: u8,
    fields: Vec<Field>,
}

struct Field {
    name: &'static str,
    /// `None` for characters.
    number: Option<Number>,
    /// Of an array.
    length: Option<usize>,
    /// A choice out of a list, or flags.
    choice: bool,
    at: usize,
}

/// MAVLink's checksum.
pub fn checksum(parts: [&[u8]; 2]) -> u16 {
    let mut sum = CRCu16::crc16mcrf4cc();
    parts.iter().for_each(|part| sum.digest(part));
    sum.get_crc()
}

/// The message of this number.
pub fn message(id: u32) -> Option<&'static Message> {
    let place = MESSAGES.binary_search_by_key(&id, |message| message.id).ok()?;
    MESSAGES.get(place)
}

impl Message {
    fn parse(line: &'static str) -> Option<Self> {
        let mut words = line.split(' ');
        let (id, name) = (words.next()?.parse().ok()?, words.next()?);
        let mut fields: Vec<Field> = Vec::new();
        let (mut at, mut extended) = (0, false);
        let mut definition = format!("{name} ").into_bytes();
        for word in words {
            if word == "+" {
                extended = true;
                continue;
            }
            let (kind, name) = word.split_once(':')?;
            let choice = kind.ends_with('?');
            let kind = kind.trim_end_matches('?');
            let (kind, length) = match kind.split_once('[') {
                Some((kind, length)) => (kind, Some(length.trim_end_matches(']').parse::<u8>().ok()?)),
                None => (kind, None),
            };
            let (long, number) = type_of(kind)?;
            if !extended {
                definition.extend(format!("{long} {name} ").into_bytes());
                definition.extend(length);
            }
            let field = Field { name, number, length: length.map(usize::from), choice, at };
            at = field.end();
            fields.push(field);
        }
        let [low, high] = checksum([&definition, &[]]).to_le_bytes();
        Some(Self { id, name, extra_crc: low ^ high, fields })
    }

    /// Names of the channels: numbers, and each element of arrays of numbers.
    pub fn channels(&self) -> Vec<String> {
        let names = |field: &Field| match field.length {
            Some(length) => (0..length).map(|i| format!("{}[{i}]", field.name)).collect(),
            None => vec![field.name.to_owned()],
        };
        self.measured().flat_map(names).collect()
    }

    /// The channels' values in a payload, whose last zeros the sender may have left out.
    pub fn values(&self, payload: &[u8]) -> Vec<f64> {
        let whole = self.whole(payload);
        let values = |field: &Field| -> Vec<f64> {
            let Some(number) = field.number else { return Vec::new() };
            let places = (0..field.length.unwrap_or(1)).map(|i| field.at + i * number.size());
            places.map(|at| number.read(&whole, at).unwrap_or(f64::NAN)).collect()
        };
        self.measured().flat_map(values).collect()
    }

    /// A number by its name.
    pub fn value(&self, payload: &[u8], name: &str) -> Option<f64> {
        let field = self.fields.iter().find(|field| field.name == name)?;
        field.number?.read(&self.whole(payload), field.at)
    }

    /// A text by its name.
    pub fn text(&self, payload: &[u8], name: &str) -> Option<String> {
        let field = self.fields.iter().find(|field| field.name == name)?;
        Some(text(self.whole(payload).get(field.at..field.end())?))
    }

    fn measured(&self) -> impl Iterator<Item = &Field> {
        self.fields.iter().filter(|field| !field.choice && field.number.is_some())
    }

    fn whole(&self, payload: &[u8]) -> Vec<u8> {
        let mut whole = payload.to_vec();
        whole.resize(self.fields.last().map_or(0, Field::end).max(payload.len()), 0);
        whole
    }
}

impl Field {
    fn end(&self) -> usize {
        self.at + self.number.map_or(1, Number::size) * self.length.unwrap_or(1)
    }
}

/// The protocol's name of a type, and how its numbers are read.
fn type_of(short: &str) -> Option<(&'static str, Option<Number>)> {
    Some(match short {
        "char" => ("char", None),
        "i8" => ("int8_t", Some(Number::I8)),
        "u8" => ("uint8_t", Some(Number::U8)),
        "i16" => ("int16_t", Some(Number::I16)),
        "u16" => ("uint16_t", Some(Number::U16)),
        "i32" => ("int32_t", Some(Number::I32)),
        "u32" => ("uint32_t", Some(Number::U32)),
        "i64" => ("int64_t", Some(Number::I64)),
        "u64" => ("uint64_t", Some(Number::U64)),
        "f32" => ("float", Some(Number::F32)),
        "f64" => ("double", Some(Number::F64)),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_read_and_in_order() {
        let lines = include_str!("messages.txt").lines().count();
        assert_eq!(MESSAGES.len(), lines);
        assert!(MESSAGES.is_sorted_by(|a, b| a.id < b.id));
    }

    /// The numbers of the protocol's page and of pymavlink 2.4.50.
    #[test]
    fn definitions_have_the_checksums_of_the_protocol() {
        for (id, name, extra) in [
            (0, "HEARTBEAT", 50),
            (22, "PARAM_VALUE", 220),
            (30, "ATTITUDE", 39),
            (76, "COMMAND_LONG", 152),
            (147, "BATTERY_STATUS", 154),
            (253, "STATUSTEXT", 83),
            (350, "DEBUG_FLOAT_ARRAY", 232),
            (11020, "AOA_SSA", 205),
        ] {
            let message = message(id).unwrap();
            assert_eq!((message.name, message.extra_crc), (name, extra));
        }
        assert!(message(9).is_none());
    }

    #[test]
    fn zeros_at_the_end_may_be_left_out() {
        let attitude = message(30).unwrap();
        assert_eq!(attitude.channels()[..2], ["time_boot_ms", "roll"]);
        assert_eq!(attitude.values(&[5, 1]), [261.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let said = message(253).unwrap();
        assert_eq!(said.text(b"\x06hello", "text").as_deref(), Some("hello"));
    }
}
