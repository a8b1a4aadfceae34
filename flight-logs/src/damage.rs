//! Bytes that belong to no message: skipped, and counted.

/// What was skipped so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Damage {
    bytes: usize,
    places: usize,
    first: usize,
    end: usize,
}

impl Damage {
    /// Skips `count` bytes at `at`; what follows the last place at once belongs to it.
    pub(crate) fn skip(&mut self, at: usize, count: usize) {
        if self.places == 0 {
            self.first = at;
        }
        if self.places == 0 || at != self.end {
            self.places += 1;
        }
        self.bytes += count;
        self.end = at + count;
    }

    pub(crate) fn note(&self) -> Option<String> {
        (self.places > 0).then(|| {
            format!(
                "{} bad bytes in {}, the first at offset {}: skipped",
                self.bytes,
                if self.places == 1 { "1 place".to_owned() } else { format!("{} places", self.places) },
                self.first
            )
        })
    }
}
