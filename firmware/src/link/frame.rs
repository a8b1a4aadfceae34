//! Messages into frames.

use heapless::Vec;
use messages::{MAVLinkV2MessageRaw, MavHeader, MessageData, calculate_crc};

use crate::link::decoder::{LONGEST, SIGNATURE, SIGNED};
use crate::link::signing::Key;

/// Who sends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Header {
    /// Counts the frames, so the other side sees what was lost.
    pub sequence: u8,
    /// System.
    pub system: u8,
    /// Component of the system.
    pub component: u8,
}

/// A frame as bytes.
pub type Bytes = Vec<u8, LONGEST>;

/// The frame of one message, not signed.
#[must_use]
pub fn encode<M: MessageData>(header: Header, message: &M) -> Bytes {
    let mut raw = MAVLinkV2MessageRaw::new();
    let Header { sequence, system, component } = header;
    raw.serialize_message_data(
        MavHeader { system_id: system.into(), component_id: component, sequence },
        message,
    );
    Bytes::from_slice(raw.raw_bytes()).unwrap_or_default()
}

/// Signs a frame made by [`encode`] at `timestamp` (units of 10 µs since 2015).
pub fn sign(frame: &mut Bytes, extra_crc: u8, key: &Key, link: u8, timestamp: u64) {
    let end = frame.len().saturating_sub(2);
    if let Some(flags) = frame.get_mut(2) {
        *flags |= SIGNED;
    }
    frame.truncate(end);
    let crc = calculate_crc(frame.get(1..).unwrap_or_default(), extra_crc);
    // a frame of 255 bytes of payload has room for its signature
    let _ = frame.extend_from_slice(&crc.to_le_bytes());
    let signature: [u8; SIGNATURE] = key.signature(frame, link, timestamp);
    let _ = frame.extend_from_slice(&signature);
}
