//! Texts of the board, put together from their pieces.

use messages::board::STATUSTEXT_DATA;

const PIECE: usize = 50;

/// A text that is still coming.
#[derive(Default)]
pub struct Texts {
    id: u16,
    text: String,
}

impl Texts {
    /// Takes one piece; the text, when it is whole.
    pub fn take(&mut self, piece: &STATUSTEXT_DATA) -> Option<String> {
        let found = String::from_utf8_lossy(&piece.text[..]);
        let found = found.trim_end_matches('\0');
        if piece.id == 0 {
            return Some(found.to_owned());
        }
        if piece.id != self.id || piece.chunk_seq == 0 {
            self.text.clear();
        }
        self.id = piece.id;
        self.text.push_str(found);
        (found.len() < PIECE).then(|| std::mem::take(&mut self.text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use firmware::link::telemetry::texts;
    use messages::board::MavSeverity;

    #[test]
    fn long_texts_are_put_together_and_short_ones_pass() {
        let mut whole = Texts::default();
        for text in ["started", &"0123456789".repeat(7), "finished with 3 recoveries", &"abc".repeat(20)] {
            let pieces: Vec<_> = texts(MavSeverity::MAV_SEVERITY_INFO, text, 9).collect();
            let found: Vec<String> = pieces.iter().filter_map(|piece| whole.take(piece)).collect();
            assert_eq!(found, [text]);
        }
    }
}
