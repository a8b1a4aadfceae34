//! The monitor's model in pieces: `DEBUG_FLOAT_ARRAY` named `model`, 58 numbers each, the digest of all of them in `time_usec`.
//! The board answers every piece under the same name and number.

use estimator_core::monitor::MonitorModel;
use messages::board::DEBUG_FLOAT_ARRAY_DATA;
use sha2::{Digest, Sha256};

const NAME: &str = "model";

/// What the board answers to a piece.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Answer {
    /// Others are missing.
    Partly,
    /// The model is whole and taken.
    Taken,
    /// It is refused; why comes as a text.
    Refused,
}

/// The number of a piece and what the board answers to it, if that is such an answer.
pub fn read(array: &DEBUG_FLOAT_ARRAY_DATA) -> Option<(u16, Answer)> {
    (array.name.to_str() == Ok(NAME)).then_some(())?;
    let answer = match array.data[1] {
        state if state > 0.0 => Answer::Taken,
        state if state < 0.0 => Answer::Refused,
        _ => Answer::Partly,
    };
    Some((array.array_id, answer))
}

/// The pieces of a model.
pub fn pieces(model: &MonitorModel) -> Vec<DEBUG_FLOAT_ARRAY_DATA> {
    let numbers = model.to_numbers();
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let digest =
        Sha256::digest(bytes).iter().take(8).rev().fold(0, |sum, byte| (sum << 8) | u64::from(*byte));
    let piece = |(array_id, values): (u16, &[f32])| {
        let mut array =
            DEBUG_FLOAT_ARRAY_DATA { time_usec: digest, array_id, name: NAME.into(), ..Default::default() };
        array.data[..values.len()].copy_from_slice(values);
        array
    };
    let length = DEBUG_FLOAT_ARRAY_DATA::default().data.len();
    (0..).zip(numbers.chunks(length)).map(piece).collect()
}
