//! MAVLink packets as ground stations write them: before each its time of arrival, u64 µs since 1970, big endian.
//!
//! Packets of MAVLink 1 (fe) and 2 (fd) are taken where their checksum is right
//! (<https://mavlink.io/en/guide/serialization.html>); messages are those of the dialect `ardupilotmega`, which holds
//! `common`. A topic's instance is the sender's system number, its times are those of arrival, and choices and flags
//! (the enumerations of MAVLink) are no channels.

mod dialect;

use std::collections::BTreeMap;

use crate::bytes::array;
use crate::damage::Damage;
use crate::{Error, Field, Format, Known, Log, Place, Topic};
use dialect::Message;

/// Bytes of the time of arrival.
const TIME: usize = 8;
/// Times of arrival that can be: the years 1973 to 2286, µs.
const TIMES: std::ops::Range<u64> = 100_000_000_000_000..10_000_000_000_000_000;

/// A packet with a right checksum, or one of an unknown kind.
struct Packet<'a> {
    time_s: f64,
    system: u8,
    payload: &'a [u8],
    /// `None` where the message is not of this dialect.
    message: Option<&'static Message>,
    /// With the time.
    length: usize,
}

/// Whether these bytes hold a packet with its time before it.
pub(crate) fn recognised(bytes: &[u8]) -> bool {
    (0..bytes.len()).any(|at| packet(bytes, at).is_some_and(|packet| packet.message.is_some()))
}

fn packet(bytes: &[u8], at: usize) -> Option<Packet<'_>> {
    let start = at + TIME;
    let header = match bytes.get(start)? {
        0xfe => 6,
        0xfd => 10,
        _ => return None,
    };
    let time_us = u64::from_be_bytes(array(bytes, at)?);
    if !TIMES.contains(&time_us) {
        return None;
    }
    let head = bytes.get(start..start + header)?;
    let (system, id, signature) = match *head {
        [_, _, _, system, _, id] => (system, u32::from(id), 0),
        [_, _, flags, _, _, system, _, low, middle, high] => {
            (system, u32::from_le_bytes([low, middle, high, 0]), if flags & 1 == 1 { 13 } else { 0 })
        }
        _ => return None,
    };
    let end = start + header + usize::from(head[1]);
    let sum = u16::from_le_bytes(array(bytes, end)?);
    let message = dialect::message(id);
    if let Some(message) = message
        && dialect::checksum([bytes.get(start + 1..end)?, &[message.extra_crc]]) != sum
    {
        return None;
    }
    let length = end + 2 + signature - at;
    bytes.get(at..at + length)?;
    let payload = bytes.get(start + header..end)?;
    Some(Packet { time_s: time_us as f64 / 1e6, system, payload, message, length })
}

/// Reads a telemetry log.
pub(crate) fn parse(bytes: &[u8]) -> Result<Log, Error> {
    let mut log = Log::new(Format::Tlog);
    let mut topics: BTreeMap<(&'static str, u8), Topic> = BTreeMap::new();
    let mut known = Known::new();
    let mut damage = Damage::default();
    let (mut messages, mut unknown) = (0_usize, 0_usize);
    let mut at = 0;
    while at < bytes.len() {
        // Nothing but what follows vouches for a packet of an unknown kind.
        let vouched = |packet: &Packet| {
            let next = at + packet.length;
            packet.message.is_some() || next == bytes.len() || self::packet(bytes, next).is_some()
        };
        let Some(packet) = packet(bytes, at).filter(vouched) else {
            damage.skip(at, 1);
            at += 1;
            continue;
        };
        at += packet.length;
        match packet.message {
            Some(message) => {
                messages += 1;
                add(&packet, message, &mut log, &mut known, &mut topics);
            }
            None => unknown += 1,
        }
    }
    if messages == 0 {
        return Err(Error::new("no message can be read", "check that the file is whole")
            .at(Place::Offset(0))
            .expecting("MAVLink packets, each after 8 bytes of time"));
    }
    log.notes.extend(damage.note());
    if unknown > 0 {
        log.notes.push(format!("{unknown} packets of kinds that are not known: skipped"));
    }
    log.notes.push("times are those of arrival at the ground station: late by the radio's delay".to_owned());
    log.topics = topics.into_values().collect();
    Ok(log.finish())
}

fn add(
    packet: &Packet,
    message: &'static Message,
    log: &mut Log,
    known: &mut Known,
    topics: &mut BTreeMap<(&'static str, u8), Topic>,
) {
    let text = |name| message.text(packet.payload, name).unwrap_or_default();
    match message.name {
        "PARAM_VALUE" => {
            let value = message.value(packet.payload, "param_value").unwrap_or(f64::NAN);
            log.set_parameter(packet.time_s, &text("param_id"), value, known);
            return;
        }
        "STATUSTEXT" => {
            let text = text("text");
            if log.firmware.is_none() && (text.starts_with("Ardu") || text.starts_with("APM:")) {
                log.firmware = Some(text.clone());
            }
            log.messages.push((packet.time_s, text));
            return;
        }
        _ => {}
    }
    let topic = topics.entry((message.name, packet.system)).or_insert_with(|| {
        let mut topic = Topic::new(message.name, packet.system);
        topic.fields = message.channels().into_iter().map(Field::new).collect();
        topic
    });
    topic.time_s.push(packet.time_s);
    for (field, value) in topic.fields.iter_mut().zip(message.values(packet.payload)) {
        field.values.push(value);
    }
}
