//! MAVLink packets as ground stations write them: before each its time of arrival, u64 µs since 1970, big endian.
//!
//! Packets of MAVLink 1 (fe) and 2 (fd) are taken where their checksum is right
//! (<https://mavlink.io/en/guide/serialization.html>); messages are those of the dialect `ardupilotmega`, which holds
//! `common`. A topic's instance is the sender's system number, its times are those of arrival, and choices and flags
//! (the enumerations of MAVLink) are no channels.

use std::collections::BTreeMap;

use mavlink::dialects::ardupilotmega::MavMessage;
use mavlink::{MavlinkVersion, Message, calculate_crc};
use serde_json::Value;

use crate::bytes::array;
use crate::damage::Damage;
use crate::{Error, Field, Format, Known, Log, Place, Topic};

/// Bytes of the time of arrival.
const TIME: usize = 8;
/// Times of arrival that can be: the years 1973 to 2286, µs.
const TIMES: std::ops::Range<u64> = 100_000_000_000_000..10_000_000_000_000_000;

/// A packet with a right checksum, or one of an unknown kind.
struct Packet<'a> {
    time_s: f64,
    version: MavlinkVersion,
    system: u8,
    id: u32,
    payload: &'a [u8],
    /// `None` where the message is not of this dialect.
    checked: Option<()>,
    /// With the time.
    length: usize,
}

/// Whether these bytes hold a packet with its time before it.
pub(crate) fn recognised(bytes: &[u8]) -> bool {
    (0..bytes.len()).any(|at| packet(bytes, at).is_some_and(|packet| packet.checked.is_some()))
}

fn packet(bytes: &[u8], at: usize) -> Option<Packet<'_>> {
    let start = at + TIME;
    let (version, header) = match bytes.get(start)? {
        0xfe => (MavlinkVersion::V1, 6),
        0xfd => (MavlinkVersion::V2, 10),
        _ => return None,
    };
    let time_us = u64::from_be_bytes(array(bytes, at)?);
    if !TIMES.contains(&time_us) {
        return None;
    }
    let head = bytes.get(start..start + header)?;
    let (system, id, signature) = match version {
        MavlinkVersion::V1 => (head[3], u32::from(head[5]), 0),
        MavlinkVersion::V2 => (
            head[5],
            u32::from_le_bytes([head[7], head[8], head[9], 0]),
            if head[2] & 1 == 1 { 13 } else { 0 },
        ),
    };
    let end = start + header + usize::from(head[1]);
    let sum = u16::from_le_bytes(array(bytes, end)?);
    let right = calculate_crc(bytes.get(start + 1..end)?, MavMessage::extra_crc(id)) == sum;
    if !right && MavMessage::default_message_from_id(id).is_some() {
        return None;
    }
    let length = end + 2 + signature - at;
    bytes.get(at..at + length)?;
    let payload = bytes.get(start + header..end)?;
    let checked = right.then_some(());
    Some(Packet { time_s: time_us as f64 / 1e6, version, system, id, payload, checked, length })
}

/// Reads a telemetry log.
pub(crate) fn parse(bytes: &[u8]) -> Result<Log, Error> {
    let mut log = Log::new(Format::Tlog);
    let mut topics: BTreeMap<(&'static str, u8), Topic> = BTreeMap::new();
    let mut known = Known::new();
    let mut damage = Damage::default();
    let (mut messages, mut unknown, mut unreadable) = (0_usize, 0_usize, 0_usize);
    let mut at = 0;
    while at < bytes.len() {
        // Nothing but what follows vouches for a packet of an unknown kind.
        let vouched = |packet: &Packet| {
            let next = at + packet.length;
            packet.checked.is_some() || next == bytes.len() || self::packet(bytes, next).is_some()
        };
        let Some(packet) = packet(bytes, at).filter(vouched) else {
            damage.skip(at, 1);
            at += 1;
            continue;
        };
        at += packet.length;
        if packet.checked.is_none() {
            unknown += 1;
            continue;
        }
        match MavMessage::parse(packet.version, packet.id, packet.payload) {
            Ok(message) => {
                messages += 1;
                add(&packet, &message, &mut log, &mut known, &mut topics);
            }
            Err(_) => unreadable += 1,
        }
    }
    if messages == 0 {
        return Err(Error::new("no message can be read", "check that the file is whole")
            .at(Place::Offset(0))
            .expecting("MAVLink packets, each after 8 bytes of time"));
    }
    log.notes.extend(damage.note());
    for (count, what) in
        [(unknown, "of kinds that are not known"), (unreadable, "with values that are not allowed")]
    {
        if count > 0 {
            log.notes.push(format!("{count} packets {what}: skipped"));
        }
    }
    log.notes.push("times are those of arrival at the ground station: late by the radio's delay".to_owned());
    log.topics = topics.into_values().collect();
    Ok(log.finish())
}

fn add(
    packet: &Packet,
    message: &MavMessage,
    log: &mut Log,
    known: &mut Known,
    topics: &mut BTreeMap<(&'static str, u8), Topic>,
) {
    match message {
        MavMessage::PARAM_VALUE(parameter) => {
            let name = crate::bytes::text(parameter.param_id.to_str().unwrap_or_default().as_bytes());
            log.set_parameter(packet.time_s, &name, f64::from(parameter.param_value), known);
            return;
        }
        MavMessage::STATUSTEXT(said) => {
            let text = crate::bytes::text(said.text.to_str().unwrap_or_default().as_bytes());
            if log.firmware.is_none() && (text.starts_with("Ardu") || text.starts_with("APM:")) {
                log.firmware = Some(text.clone());
            }
            log.messages.push((packet.time_s, text));
            return;
        }
        _ => {}
    }
    let Ok(Value::Object(values)) = serde_json::to_value(message) else { return };
    let topic = topics.entry((message.message_name(), packet.system)).or_insert_with(|| {
        let mut topic = Topic::new(message.message_name(), packet.system);
        topic.fields = values.iter().flat_map(|(name, value)| fields(name, value)).collect();
        topic
    });
    topic.time_s.push(packet.time_s);
    let rows = topic.time_s.len();
    let mut numbers = values.values().flat_map(numbers);
    for field in &mut topic.fields {
        field.values.push(numbers.next().unwrap_or(f64::NAN));
        debug_assert_eq!(field.values.len(), rows);
    }
}

fn fields(name: &str, value: &Value) -> Vec<Field> {
    match value {
        Value::Array(items) => (0..items.len()).map(|i| Field::new(format!("{name}[{i}]"))).collect(),
        Value::Number(_) | Value::Null => vec![Field::new(name)],
        _ => Vec::new(),
    }
}

/// The numbers of a value; JSON's null stands for those that are not finite.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().map(|item| item.as_f64().unwrap_or(f64::NAN)).collect(),
        Value::Number(number) => vec![number.as_f64().unwrap_or(f64::NAN)],
        Value::Null => vec![f64::NAN],
        _ => Vec::new(),
    }
}
