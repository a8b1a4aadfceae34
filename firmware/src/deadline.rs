//! Was the cycle in time? The watchdog is fed by cycles that were, and by nothing else.

/// Late cycles in a row that are borne.
const BORNE: u32 = 2;

/// What a cycle's end calls for.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Verdict {
    /// In time: feed the watchdog.
    Feed,
    /// Late: leave it hungry.
    Hold,
    /// Late too often: give up before the watchdog does, for it keeps no cause.
    GiveUp {
        /// Late cycles in a row.
        count: u32,
    },
}

/// Counts late cycles.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub struct Deadline {
    late: u32,
}

impl Deadline {
    /// Takes the end of one cycle.
    pub fn close(&mut self, late: bool) -> Verdict {
        self.late = if late { self.late.saturating_add(1) } else { 0 };
        match self.late {
            0 => Verdict::Feed,
            1..=BORNE => Verdict::Hold,
            count => Verdict::GiveUp { count },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_cycle_in_time_feeds_and_the_third_late_one_in_a_row_gives_up() {
        let mut deadline = Deadline::default();
        let found = [false, true, true, false, true, true, true].map(|late| deadline.close(late));
        use Verdict::{Feed, GiveUp, Hold};
        assert_eq!(found, [Feed, Hold, Hold, Feed, Hold, Hold, GiveUp { count: 3 }]);
    }
}
