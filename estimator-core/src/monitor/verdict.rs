//! The verdict: which cause is told, and when.

use core::fmt;

use super::evidence::{Evidence, Finding};
use super::model::{CAUSES, Cause, MonitorModel, Test};
use super::{BLOCK, larger};
use crate::constants::SAMPLE_PERIOD_S;
use crate::decimal::Decimal;

/// Logarithm of the odds by which a cause must lead the next before it is told alone.
const LEAD: f32 = 3.0;
/// The same as a share of what speaks for it: the traces are not exact.
const SHARE: f32 = 0.15;
/// Blocks that two causes may stay level before both are told.
const PATIENCE: u32 = 3 * 50 / BLOCK;
/// A told cause stands until its sum falls below this share of the threshold.
const STANDS: f32 = 0.5;

/// A change with its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// What changed.
    pub cause: Cause,
    /// Whether moments are per unit inertia.
    pub specific: bool,
    /// By how much, in the units of [`Cause`].
    pub size: f32,
    /// Half the 95 % interval.
    pub interval: f32,
    /// Tick at which it began, the most likely one.
    pub since: u32,
}

/// Why there is no verdict.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Unable {
    /// The predictor settles.
    Settling,
    /// Too little motion to see a change of effectiveness of the largest size tested.
    NotEnoughMotion,
    /// No usable sample.
    NoSample,
    /// A reading that is no number, or beyond any sensor.
    NotFinite,
    /// The same readings again and again.
    Frozen,
}

/// What the monitor says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The craft is what was identified.
    AsIdentified,
    /// One thing changed.
    Changed(Change),
    /// One of two changed; the data do not say which.
    OneOf(Change, Change),
    /// The craft is not what was identified, and none of the causes is why.
    SomethingElse {
        /// Since which tick.
        since: u32,
    },
    /// Nothing can be said.
    CannotTell(Unable),
}

impl Verdict {
    /// Whether it says the same but for sizes and times.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        let kind = |verdict: &Self| match verdict {
            Self::Changed(change) => (Some(change.cause), None, None),
            Self::OneOf(a, b) => (Some(a.cause), Some(b.cause), None),
            Self::CannotTell(why) => (None, None, Some(*why)),
            Self::AsIdentified | Self::SomethingElse { .. } => (None, None, None),
        };
        core::mem::discriminant(self) == core::mem::discriminant(other) && kind(self) == kind(other)
    }
}

impl fmt::Display for Unable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Settling => "settling",
            Self::NotEnoughMotion => "not enough motion",
            Self::NoSample => "no sample",
            Self::NotFinite => "reading is not a number",
            Self::Frozen => "sensor frozen",
        })
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cause, specific, size, interval, .. } = self;
        let (unit, per) = cause.unit(*specific);
        let places = if per > 1.0 { 0 } else { 3 };
        let [size, interval] = [size, interval].map(|value| Decimal(value * per));
        write!(f, "{} {size:+.places$} +- {interval:.places$} {unit}", cause.name())
    }
}

/// Share of an added lag by which it may be off for being a delay, or the other way round.
const SHAPE: f32 = 0.25;

impl Change {
    /// The interval holds the score's own deviation, and the model's errors: half the dead zone is one deviation of them.
    fn of(cause: Cause, found: &Finding, model: &MonitorModel) -> Self {
        let dead_zone = model.tests.get(cause as usize).map_or(0.0, |test| test.dead_zone);
        let shape = if cause == Cause::Lag { 0.5 * SHAPE * found.size } else { 0.0 };
        let open = 0.5 * dead_zone;
        let deviation = libm::sqrtf(1.0 / found.information + open * open + shape * shape);
        let (mut size, mut interval) = (found.size, 1.96 * deviation);
        if cause == Cause::GyroScale {
            // ψ is made of the measured rate, which is (1 + s) q: the score gives s / (1 + s)
            let rest = larger(1.0 - size, 0.1);
            (size, interval) = (size / rest, interval / (rest * rest));
        }
        Self { cause, specific: model.specific > 0.5, size, interval, since: found.since }
    }
}

fn seconds(tick: u32) -> Decimal {
    Decimal(tick as f32 * SAMPLE_PERIOD_S)
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AsIdentified => f.write_str("as identified"),
            Self::Changed(change) => write!(f, "changed: {change} since {:.1} s", seconds(change.since)),
            Self::OneOf(a, b) => write!(f, "changed: {a} or {b} since {:.1} s", seconds(a.since)),
            Self::SomethingElse { since } => {
                write!(f, "changed: something else since {:.1} s", seconds(*since))
            }
            Self::CannotTell(why) => write!(f, "cannot tell: {why}"),
        }
    }
}

/// The verdict as it stands, and what it takes to change it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Judge {
    verdict: Verdict,
    waiting: u32,
}

impl Default for Judge {
    fn default() -> Self {
        Self { verdict: Verdict::CannotTell(Unable::Settling), waiting: 0 }
    }
}

impl Judge {
    pub const fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// True where that is new.
    pub fn unable(&mut self, why: Unable) -> bool {
        self.waiting = 0;
        self.settle(Verdict::CannotTell(why))
    }

    fn settle(&mut self, verdict: Verdict) -> bool {
        let new = !verdict.is_like(&self.verdict);
        self.verdict = verdict;
        new
    }

    /// One block further; true where the verdict changed.
    pub fn step(
        &mut self,
        evidence: &[Evidence; CAUSES],
        motion: &[f32; CAUSES],
        model: &MonitorModel,
        threshold: f32,
    ) -> bool {
        let told = !matches!(self.verdict, Verdict::AsIdentified | Verdict::CannotTell(_));
        let needed = if told { STANDS * threshold } else { threshold };
        let (mut first, mut second) = (None, None);
        let (mut highest, mut next, mut largest) = (0.0, 0.0, 0.0_f32);
        for (cause, evidence) in Cause::ALL.into_iter().zip(evidence) {
            let found = evidence.best();
            largest = larger(largest, found.sum);
            // it stands for all that has no name, and a name that explains as much is better
            let likelihood = match cause {
                Cause::Stiffness => (1.0 - SHARE) * found.likelihood - LEAD,
                _ => found.likelihood,
            };
            if likelihood > highest {
                (second, next) = (first, highest);
                (first, highest) = (Some((cause, *found)), likelihood);
            } else if likelihood > next {
                (second, next) = (Some((cause, *found)), likelihood);
            }
        }
        let Some((cause, found)) = first.filter(|_| largest >= needed) else {
            self.waiting = 0;
            return self.settle(quiet(motion, &model.tests, threshold));
        };
        let change = |(cause, found): (Cause, Finding)| Change::of(cause, &found, model);
        let lead = larger(LEAD, SHARE * highest);
        if let Verdict::Changed(told) = self.verdict {
            // what has been told stays told until something else is clearly better
            let own = Cause::ALL.into_iter().zip(evidence).find(|(of, _)| *of == told.cause);
            let own = own.map(|(of, evidence)| (of, *evidence.best()));
            if let Some(own) = own.filter(|(_, own)| own.sum >= needed && highest - own.likelihood < lead) {
                return self.settle(Verdict::Changed(change(own)));
            }
        }
        let alone = highest - next >= lead;
        self.waiting = if alone { 0 } else { self.waiting.saturating_add(1) };
        match second {
            Some(_) if !alone && self.waiting < PATIENCE => false,
            Some(second) if !alone => self.settle(Verdict::OneOf(change((cause, found)), change(second))),
            _ if cause == Cause::Stiffness => self.settle(Verdict::SomethingElse { since: found.since }),
            _ => self.settle(Verdict::Changed(change((cause, found)))),
        }
    }
}

/// As identified, if a change of effectiveness of the largest size tested would have been seen within the memory.
fn quiet(motion: &[f32; CAUSES], tests: &[Test; CAUSES], threshold: f32) -> Verdict {
    let ([seen, ..], [test, ..]) = (motion, tests);
    let largest = test.sizes.iter().fold(0.0_f32, |largest, size| larger(largest, size.abs()));
    let reach = largest - test.dead_zone;
    if 0.5 * reach * reach * seen >= threshold {
        Verdict::AsIdentified
    } else {
        Verdict::CannotTell(Unable::NotEnoughMotion)
    }
}
