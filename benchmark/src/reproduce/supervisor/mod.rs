//! The supervisor where tests go wrong: thousands of them, on craft from stable to unstable, with physics concealed, gusts and faults.
//!
//! Every tick of every test is watched from outside. Promised, of any of them:
//!
//! 1. beyond the limit the airframe goes no further than the bound of [`excursion`];
//! 2. the excitation and the manual reference never reach the servo in a tick that finds angle or rate beyond its limit;
//! 3. where the controller leads, the command is that of its law;
//! 4. every recovery ends or is broken off within its time, and every test ends;
//! 5. the taps rest wherever the supervisor or the controller leads;
//! 6. no number is other than finite.

pub mod excursion;
mod flight;
pub mod page;

pub use flight::{Watched, watch};

use crate::{Error, files};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;
use sysid::progress::{Counted, Progress};

/// What the study found.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Seed of everything.
    pub seed: u64,
    /// Every test.
    pub tests: Vec<Watched>,
}

/// Flies `tests` tests, and writes `supervisor.md` and `supervisor.json` into `folder`, which is there.
///
/// # Errors
/// A file that cannot be written.
pub fn supervisor(folder: &Path, tests: u64, seed: u64, say: &Progress<'_>) -> Result<Study, Error> {
    let counted = Counted::new(say, "flying", tests as usize);
    let one = |number: u64| {
        let watched = watch(seed, number);
        counted.one();
        watched
    };
    let tests: Vec<Watched> = (0..tests).into_par_iter().map(one).collect::<Result<_, Error>>()?;
    let study = Study { seed, tests };
    files::write(&folder.join("supervisor.json"), &files::json(&study)?)?;
    files::write(&folder.join("supervisor.md"), &page::markdown(&study))?;
    Ok(study)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Out of 10,000 tests of seed 1 those that came nearest to their bound, and how far beyond the limit they went, rad.
    const WORST: [(u64, f64); 10] = [
        (6768, 0.1599),
        (4629, 0.3407),
        (8022, 0.2027),
        (647, 0.2170),
        (4039, 0.2421),
        (4029, 0.0895),
        (858, 0.2084),
        (5441, 0.2287),
        (4619, 0.0725),
        (8759, 0.1726),
    ];

    #[test]
    fn the_worst_of_ten_thousand_stay_within_their_bound_and_go_no_further_than_they_did() {
        for (number, excess_rad) in WORST {
            let watched = watch(1, number).unwrap();
            assert!(watched.broken.is_empty(), "{number}: {:?}", watched.broken);
            let (nearest, _) = watched.nearest.unwrap();
            assert!((nearest.excess_rad - excess_rad).abs() < 2e-3, "{number}: {nearest:?}");
        }
    }

    #[test]
    fn no_promise_is_broken_and_the_same_seed_gives_the_same_tests() {
        let folder = tempfile::tempdir().unwrap();
        let study = supervisor(folder.path(), 200, 2, &|_| ()).unwrap();
        assert_eq!(page::broken(&study), Vec::<String>::new());
        let recoveries: u32 = study.tests.iter().map(|test| test.recoveries).sum();
        assert!(recoveries > 1000, "the limits are met: {recoveries}");
        assert!(study.tests.iter().filter(|test| test.ended == "done").count() > 100);
        let again = supervisor(folder.path(), 200, 2, &|_| ()).unwrap();
        assert_eq!(files::json(&study).unwrap(), files::json(&again).unwrap());
    }
}
