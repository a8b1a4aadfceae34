//! The paper's Table 2 and figures, over many simulated campaigns; public benchmarks in their official split.

pub mod benchmarks;
mod campaign;
mod figures;
pub mod monitor;
pub mod page;
pub mod plans;
mod study;
pub mod supervisor;

pub use campaign::Condition;
pub use study::{MethodFigures, Paper, ParameterErrors, SeedResult, Spread, Study};

use crate::{Error, files};
use campaign::fly_campaign;
use std::path::Path;
use study::study;
use sysid::identify::compare::{Identification, Settings, identify, identify_on};
use sysid::progress::Progress;
use sysid::recording::Recording;

/// Flies `seeds` campaigns of every condition, identifies them, and writes page, pictures and figures into `folder`,
/// which is there; `recordings` of a rig, if any, are identified in the same way. `say` hears what is being done.
///
/// # Errors
/// A campaign that could not be flown, recordings that could not be used, or a file that could not be written.
pub fn paper(
    folder: &Path,
    campaign: u8,
    seeds: u32,
    recordings: &[Recording],
    say: &Progress<'_>,
) -> Result<(Paper, Option<Identification>), Error> {
    let conditions = [Condition::Nominal, Condition::Disturbed, Condition::Realistic];
    let studies = conditions.into_iter().map(|condition| study(condition, campaign, seeds, say));
    let paper = Paper { campaign, seeds, studies: studies.collect::<Result<_, _>>()? };
    say("drawing the first realistic campaign".into());
    let shown = fly_campaign(Condition::Realistic, campaign, 1)?;
    let found = identify_on(&shown.data, &shown.split, &shown.baseline, &Settings::default(), &|_| ())?;
    for (name, picture) in figures::all(&shown, &found) {
        files::write(&folder.join(name), &picture)?;
    }
    let given = if recordings.is_empty() {
        None
    } else {
        say("identifying the given recordings".into());
        Some(identify(recordings, None, &|_| ())?)
    };
    files::write(&folder.join("paper.json"), &files::json(&paper)?)?;
    files::write(&folder.join("paper.md"), &page::markdown(&paper, &found, given.as_ref()))?;
    Ok((paper, given))
}
