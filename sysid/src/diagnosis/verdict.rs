//! The verdict: a pure function of evidence, tests and shares.

use super::answer::Verdict;
use super::levels::MATERIAL;

/// What speaks against names as the answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objection {
    /// Most of the motion does not follow from the input.
    Unseen,
    /// A name does not stand on data that were held out.
    Unstable,
    /// Names close this share of what can be closed.
    Partly(f64),
}

/// What a verdict is made of. Gains are those of the log posterior over the baseline, in the same units.
#[derive(Clone, Copy, Debug, Default)]
pub struct Grounds {
    /// Something about the recording has to be put right first.
    pub data_first: bool,
    /// The data cannot tell.
    pub not_excited: bool,
    /// Named terms in the model, a gust among them.
    pub named: usize,
    /// Terms without a name in the model.
    pub shapes: usize,
    /// Whether a named term has a rival that the data cannot rule out.
    pub rivals: bool,
    /// Whether a named term is chosen by fewer than half of the rotations, or gains no more on held-out data than chance gives.
    pub unstable: bool,
    /// Whether most of the motion does not follow from the input, and the loop was closed unsaid, or a name is known by how it does.
    pub unseen: bool,
    /// Share of what the baseline leaves of the motion, the noise included, that the named terms close in prediction.
    pub closed: f64,
    /// What the named terms alone gain.
    pub gained_by_names: f64,
    /// What the fullest model gains.
    pub gained_by_all: f64,
    /// What the tests that fail say that nothing in the model closes.
    pub untold: f64,
    /// Whether the motion is told to its last hundredths and nothing in the model is missing from the baseline.
    pub slight: bool,
}

impl Grounds {
    /// Share of all that can be closed which the named terms close: of the gain in evidence, or of the motion, whichever is
    /// more. What is left of a motion that is explained to its last hundredths is significant, and not material.
    pub fn share_of_names(&self) -> f64 {
        let all = self.gained_by_all.max(self.gained_by_names) + self.untold;
        let of_evidence = if all > 0.0 { self.gained_by_names / all } else { 1.0 };
        of_evidence.max(self.closed).clamp(0.0, 1.0)
    }

    /// What speaks against the names that there are.
    pub fn objection(&self) -> Option<Objection> {
        let share = self.share_of_names();
        match self.named {
            0 => None,
            _ if self.unseen => Some(Objection::Unseen),
            _ if self.unstable => Some(Objection::Unstable),
            _ if share < MATERIAL => Some(Objection::Partly(share)),
            _ => None,
        }
    }

    /// The verdict.
    pub fn verdict(&self) -> Verdict {
        if self.data_first {
            return Verdict::CheckData;
        }
        if self.not_excited {
            return Verdict::NotExcited;
        }
        if self.named == 0 {
            let missing = self.shapes > 0 || self.untold > 0.0 && !self.slight;
            return if missing { Verdict::Unlisted } else { Verdict::NoMismatch };
        }
        if self.objection().is_some() {
            Verdict::Unlisted
        } else if self.rivals {
            Verdict::Ambiguous
        } else {
            Verdict::Named
        }
    }
}

#[cfg(test)]
mod tests;
