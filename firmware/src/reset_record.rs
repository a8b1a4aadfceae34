//! What is kept across a reset: why it came, and where.
//!
//! The record lies in RAM that start-up leaves alone. It is believed only with its mark and its checksum, for after power-up
//! that RAM holds anything.

use core::fmt;

const MARK: u32 = 0x5049_5443;

/// Why the board gave up.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Cause {
    /// The program found itself wrong, at this line.
    Panic {
        /// Line of the source.
        line: u32,
    },
    /// The processor refused an instruction, at this address.
    HardFault {
        /// Program counter.
        address: u32,
    },
    /// This many cycles in a row were too late.
    MissedDeadlines {
        /// Cycles.
        count: u32,
    },
    /// The supply fell below 2.9 V.
    BrownOut,
    /// The watchdog bit: no cycle met its deadline for 70 ms, and nothing could say why.
    Watchdog,
}

/// Bit of the clock controller's `RCC_CSR` that the independent watchdog's reset sets (reference manual RM0090, 7.3.21).
pub const WATCHDOG_RESET: u32 = 1 << 29;

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Panic { line } => write!(f, "last reset: panic at line {line}"),
            Self::HardFault { address } => write!(f, "last reset: hard fault at {address:#010x}"),
            Self::MissedDeadlines { count } => write!(f, "last reset: {count} deadlines missed in a row"),
            Self::BrownOut => f.write_str("last reset: supply below 2.9 V"),
            Self::Watchdog => f.write_str("last reset: watchdog, no cycle met its deadline for 70 ms"),
        }
    }
}

/// The words in RAM.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
#[repr(C)]
pub struct Record {
    mark: u32,
    kind: u32,
    detail: u32,
    check: u32,
}

impl Record {
    /// Nothing to tell.
    pub const EMPTY: Self = Self { mark: 0, kind: 0, detail: 0, check: 0 };

    /// The record of `cause`.
    #[must_use]
    pub const fn of(cause: Cause) -> Self {
        let (kind, detail) = match cause {
            Cause::Panic { line } => (1, line),
            Cause::HardFault { address } => (2, address),
            Cause::MissedDeadlines { count } => (3, count),
            Cause::BrownOut => (4, 0),
            Cause::Watchdog => (5, 0),
        };
        Self { mark: MARK, kind, detail, check: checksum(kind, detail) }
    }

    /// The cause, if this is a record.
    #[must_use]
    pub const fn cause(&self) -> Option<Cause> {
        let Self { mark, kind, detail, check } = *self;
        if mark != MARK || check != checksum(kind, detail) {
            return None;
        }
        match kind {
            1 => Some(Cause::Panic { line: detail }),
            2 => Some(Cause::HardFault { address: detail }),
            3 => Some(Cause::MissedDeadlines { count: detail }),
            4 => Some(Cause::BrownOut),
            5 => Some(Cause::Watchdog),
            _ => None,
        }
    }
}

const fn checksum(kind: u32, detail: u32) -> u32 {
    (kind ^ detail.rotate_left(13)).wrapping_mul(0x9e37_79b1) ^ MARK
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cause_comes_back_and_a_flipped_bit_is_noticed() {
        let causes = [
            Cause::Panic { line: 77 },
            Cause::HardFault { address: 0x0800_1234 },
            Cause::MissedDeadlines { count: 3 },
            Cause::BrownOut,
            Cause::Watchdog,
        ];
        for cause in causes {
            let record = Record::of(cause);
            assert_eq!(record.cause(), Some(cause));
            for bit in 0..32 {
                assert_eq!(Record { detail: record.detail ^ (1 << bit), ..record }.cause(), None);
            }
        }
    }

    #[test]
    fn what_power_up_leaves_is_no_record() {
        assert_eq!(Record::EMPTY.cause(), None);
        assert_eq!(
            Record { mark: u32::MAX, kind: u32::MAX, detail: u32::MAX, check: u32::MAX }.cause(),
            None
        );
    }
}
