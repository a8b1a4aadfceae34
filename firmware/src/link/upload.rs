//! The monitor's model on its way to the board.
//!
//! `DEBUG_FLOAT_ARRAY` with the name `model`: 58 of the model's numbers, the piece's number in `array_id`, the digest of all of
//! them in `time_usec`. Every piece is answered under the same name, piece and digest with
//!
//! | place | quantity |
//! | --- | --- |
//! | 0 | the pieces that the board has, a bit for each |
//! | 1 | 1 when the model is whole and taken, −1 when it is refused; why comes as a text |
//!
//! so a piece that was lost is sent again. A piece of another model begins anew.

use core::fmt;

use estimator_core::monitor::{MonitorModel, NUMBERS, Refusal};
use messages::board::DEBUG_FLOAT_ARRAY_DATA;

use crate::digest::digest;
use crate::link::telemetry::{PIECE, array};
use crate::settings::number_bytes;

/// Name of the arrays.
pub const NAME: &str = "model";
/// Arrays of one model.
pub const PIECES: usize = NUMBERS.div_ceil(PIECE);
const ALL: u8 = (1 << PIECES) - 1;
const _: () = assert!(PIECES <= 8, "a bit for each piece");

/// A model in pieces.
#[derive(Clone)]
pub struct Upload {
    digest: u64,
    have: u8,
    numbers: [f32; NUMBERS],
}

/// How far it has got.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// Pieces are missing.
    Partly,
    /// It is whole, and was not before.
    Whole,
    /// It is whole, and was before.
    Again,
}

/// Why a piece, or all that have come, is not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refused {
    /// The vehicle is armed.
    Armed,
    /// All pieces are there, but they are not what was sent.
    Broken,
    /// No board would run it.
    Model(Refusal),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Armed => f.write_str("monitor refused: disarm first"),
            Self::Broken => f.write_str("monitor refused: not what was sent"),
            Self::Model(why) => write!(f, "monitor refused: {why}"),
        }
    }
}

impl Default for Upload {
    fn default() -> Self {
        Self { digest: 0, have: 0, numbers: [0.0; NUMBERS] }
    }
}

impl Upload {
    /// Takes what `fill` puts in for a whole model, if it says so.
    pub fn restore(&mut self, fill: impl FnOnce(&mut [f32; NUMBERS]) -> bool) {
        if fill(&mut self.numbers) {
            (self.digest, self.have) = (sum(&self.numbers), ALL);
        }
    }

    /// The numbers, when all have come.
    #[must_use]
    pub fn numbers(&self) -> Option<&[f32; NUMBERS]> {
        (self.have == ALL).then_some(&self.numbers)
    }

    /// Takes a piece.
    ///
    /// # Errors
    /// The last piece of something that is no model; then it begins anew.
    pub fn take(&mut self, piece: &DEBUG_FLOAT_ARRAY_DATA) -> Result<Progress, Refused> {
        if piece.time_usec != self.digest {
            (self.digest, self.have) = (piece.time_usec, 0);
        }
        if self.have == ALL {
            return Ok(Progress::Again);
        }
        let number = usize::from(piece.array_id);
        if let Some(places) = self.numbers.chunks_mut(PIECE).nth(number) {
            places.iter_mut().zip(piece.data).for_each(|(place, value)| *place = value);
            self.have |= 1 << number;
        }
        if self.have != ALL {
            return Ok(Progress::Partly);
        }
        let outcome = match MonitorModel::from_numbers(&self.numbers) {
            _ if sum(&self.numbers) != self.digest => Err(Refused::Broken),
            Ok(_) => return Ok(Progress::Whole),
            Err(refusal) => Err(Refused::Model(refusal)),
        };
        self.have = 0;
        outcome
    }

    /// The model, when it is whole.
    #[must_use]
    pub fn model(&self) -> Option<MonitorModel> {
        MonitorModel::from_numbers(self.numbers()?).ok()
    }

    /// The answer to a piece.
    #[must_use]
    pub fn answer(&self, piece: &DEBUG_FLOAT_ARRAY_DATA, refused: bool) -> DEBUG_FLOAT_ARRAY_DATA {
        let state = match self.have {
            _ if refused => -1.0,
            ALL => 1.0,
            _ => 0.0,
        };
        array(NAME, piece.array_id, piece.time_usec, &[f32::from(self.have), state])
    }
}

/// Digest of a model.
fn sum(numbers: &[f32; NUMBERS]) -> u64 {
    u64::from_le_bytes(digest(&number_bytes(numbers)))
}

/// The pieces of a model.
pub fn pieces(model: &MonitorModel) -> impl Iterator<Item = DEBUG_FLOAT_ARRAY_DATA> {
    let numbers = model.to_numbers();
    let sum = sum(&numbers);
    (0..PIECES).map(move |piece| {
        let from = piece * PIECE;
        let values = numbers.get(from..(from + PIECE).min(NUMBERS)).unwrap_or_default();
        array(NAME, piece as u16, sum, values)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::telemetry::PIECE;

    fn model(gain: f32) -> MonitorModel {
        let mut numbers = MonitorModel::EMPTY.to_numbers();
        let place = NUMBERS - 1;
        numbers[place] = gain;
        MonitorModel::from_numbers(&numbers).unwrap()
    }

    #[test]
    fn pieces_in_any_order_and_twice_make_the_model_once() {
        let wanted = model(0.25);
        let mut upload = Upload::default();
        let sent: Vec<_> = pieces(&wanted).collect();
        assert_eq!(sent.len(), 3);
        let order = [2, 0, 0, 2, 1, 1];
        let found: Vec<_> = order.iter().map(|&piece| upload.take(&sent[piece]).unwrap()).collect();
        use Progress::{Again, Partly, Whole};
        assert_eq!(found, [Partly, Partly, Partly, Partly, Whole, Again]);
        assert_eq!(upload.model(), Some(wanted));
        assert_eq!(upload.answer(&sent[1], false).data[..2], [7.0, 1.0]);
    }

    #[test]
    fn a_piece_of_another_model_begins_anew() {
        let [one, other] = [model(0.25), model(0.5)];
        let mut upload = Upload::default();
        upload.restore(|numbers| {
            *numbers = one.to_numbers();
            true
        });
        assert_eq!(upload.model(), Some(one));
        let sent: Vec<_> = pieces(&other).collect();
        assert_eq!(upload.take(&sent[0]), Ok(Progress::Partly));
        assert_eq!((upload.model(), upload.answer(&sent[0], false).data[0]), (None, 1.0));
        upload.take(&sent[1]).unwrap();
        assert_eq!(upload.take(&sent[2]), Ok(Progress::Whole));
        assert_eq!(upload.model(), Some(other));
    }

    #[test]
    fn what_arrives_otherwise_than_it_was_sent_or_that_no_board_would_run_is_not_taken() {
        for (place, value, refused) in [(NUMBERS - 1, 0.26, false), (0, 1.5, true), (5, f32::NAN, true)] {
            let mut numbers = model(0.25).to_numbers();
            numbers[place] = value;
            let mut sent: Vec<_> = pieces(&model(0.25)).collect();
            sent[place / PIECE].data[place % PIECE] = value;
            if refused {
                sent.iter_mut().for_each(|piece| piece.time_usec = sum(&numbers));
            }
            let mut upload = Upload::default();
            let last = sent.iter().map(|piece| upload.take(piece)).last().unwrap();
            assert_eq!(matches!(last, Err(Refused::Model(_))), refused, "{last:?}");
            assert!(refused || last == Err(Refused::Broken));
            assert_eq!(upload.model(), None);
            // and once more, as it was sent
            let whole = pieces(&model(0.25)).map(|piece| upload.take(&piece)).last();
            assert_eq!(whole, Some(Ok(Progress::Whole)));
        }
    }
}
