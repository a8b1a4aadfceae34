//! What a test consists of: lead-in, I, pause, II, pause, III, pause, IV.
//!
//! I to III are quasi-open loop, the same excitation with three sequences of one seed; in between and in the
//! lead-in the controller holds the vehicle level; in IV it follows the manual reference. The clock of I to
//! III stands still during a recovery, so each of them delivers its whole excitation; the clock of the others
//! goes on.

use core::fmt;

use crate::config_error::{ConfigError, within};
use crate::constants::ticks;

/// Label of a part of a test, as in the recordings.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Section {
    /// Before, between and after the sections.
    #[default]
    Between,
    /// First excitation.
    I,
    /// Second excitation.
    II,
    /// Third excitation.
    III,
    /// Controller on, manual reference.
    IV,
}

impl Section {
    /// Number of the excitation sequence flown in this section, if it flies one.
    #[must_use]
    pub const fn sequence(&self) -> Option<u64> {
        match self {
            Self::I => Some(1),
            Self::II => Some(2),
            Self::III => Some(3),
            Self::Between | Self::IV => None,
        }
    }
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Between => "-",
            Self::I => "I",
            Self::II => "II",
            Self::III => "III",
            Self::IV => "IV",
        })
    }
}

/// Durations in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanConfig {
    /// Controller on before section I, s, 0 to 600.
    pub lead_in_s: f32,
    /// Each of sections I to III, s of excitation, 0.02 to 3600. Three of 25 s are the paper's 3750 samples.
    pub section_s: f32,
    /// Pauses between sections, s, 0 to 600.
    pub pause_s: f32,
    /// Section IV, s, 0 to 3600; 0 leaves it out.
    pub closed_loop_s: f32,
}

impl Default for PlanConfig {
    fn default() -> Self {
        Self { lead_in_s: 5.0, section_s: 25.0, pause_s: 5.0, closed_loop_s: 25.0 }
    }
}

impl PlanConfig {
    pub(crate) fn build(&self) -> Result<Plan, ConfigError> {
        within("plan.lead_in_s", "s", self.lead_in_s, [0.0, 600.0])?;
        within("plan.section_s", "s", self.section_s, [0.02, 3600.0])?;
        within("plan.pause_s", "s", self.pause_s, [0.0, 600.0])?;
        within("plan.closed_loop_s", "s", self.closed_loop_s, [0.0, 3600.0])?;
        let (lead_in, section, pause) = (ticks(self.lead_in_s), ticks(self.section_s), ticks(self.pause_s));
        let stage = |section, ticks| Stage { section, ticks };
        Ok(Plan {
            stages: [
                stage(Section::Between, lead_in),
                stage(Section::I, section),
                stage(Section::Between, pause),
                stage(Section::II, section),
                stage(Section::Between, pause),
                stage(Section::III, section),
                stage(Section::Between, pause),
                stage(Section::IV, ticks(self.closed_loop_s)),
            ],
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Stage {
    section: Section,
    ticks: u32,
}

/// Stages of a test, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    stages: [Stage; 8],
}

/// Place in the plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanState {
    stage: u8,
    elapsed: u32,
}

impl PlanState {
    /// True in the first tick of a stage.
    #[must_use]
    pub const fn begins(&self) -> bool {
        self.elapsed == 0
    }
}

impl Plan {
    /// The section that the coming tick belongs to, none when the plan is complete. Stages of no length are
    /// passed.
    pub fn current(&self, state: &mut PlanState) -> Option<Section> {
        while let Some(stage) = self.stages.get(usize::from(state.stage)) {
            if state.elapsed < stage.ticks {
                return Some(stage.section);
            }
            *state = PlanState { stage: state.stage.saturating_add(1), elapsed: 0 };
        }
        None
    }

    /// One tick of the current stage is done.
    pub fn advance(&self, state: &mut PlanState) {
        state.elapsed = state.elapsed.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn labels(config: PlanConfig) -> Vec<Section> {
        let plan = config.build().unwrap();
        let mut state = PlanState::default();
        core::iter::from_fn(|| {
            let section = plan.current(&mut state)?;
            plan.advance(&mut state);
            Some(section)
        })
        .collect()
    }

    #[test]
    fn stages_follow_each_other_with_their_durations() {
        let labels = labels(PlanConfig::default());
        let count = |section| labels.iter().filter(|&&s| s == section).count();
        assert_eq!([Section::I, Section::II, Section::III, Section::IV].map(count), [1250; 4]);
        assert_eq!(count(Section::Between), 4 * 250);
        assert_eq!((labels[249], labels[250], labels[1499]), (Section::Between, Section::I, Section::I));
        assert_eq!(labels.last(), Some(&Section::IV));
    }

    #[test]
    fn stages_without_length_are_passed() {
        let config = PlanConfig { lead_in_s: 0.0, section_s: 0.02, pause_s: 0.0, closed_loop_s: 0.0 };
        assert_eq!(labels(config), [Section::I, Section::II, Section::III]);
    }
}
