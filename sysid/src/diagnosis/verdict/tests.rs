//! The table of cases.

use super::super::answer::Verdict::{self, Ambiguous, CheckData, Named, NoMismatch, NotExcited, Unlisted};
use super::{Grounds, Objection};

/// Named terms, shapes, rivals, gain of the names, of all, untold → verdict.
type Case = (usize, usize, bool, f64, f64, f64, Verdict);

const CASES: [Case; 40] = [
    // nothing found
    (0, 0, false, 0.0, 0.0, 0.0, NoMismatch),
    (0, 0, true, 0.0, 0.0, 0.0, NoMismatch),
    (0, 0, false, 0.0, 0.0, 0.1, Unlisted),
    (0, 0, false, 0.0, 0.0, 500.0, Unlisted),
    // a fuller model was visited, and is not more probable
    (0, 0, false, 0.0, 3.0, 0.0, NoMismatch),
    // shapes alone
    (0, 1, false, 0.0, 20.0, 0.0, Unlisted),
    (0, 2, false, 0.0, 2000.0, 0.0, Unlisted),
    (0, 1, false, 0.0, 20.0, 20.0, Unlisted),
    (0, 1, true, 0.0, 20.0, 0.0, Unlisted),
    // one name that explains all
    (1, 0, false, 5.0, 5.0, 0.0, Named),
    (1, 0, false, 50.0, 50.0, 0.0, Named),
    (1, 0, false, 5000.0, 5000.0, 0.0, Named),
    (1, 0, true, 50.0, 50.0, 0.0, Ambiguous),
    (1, 0, true, 5000.0, 5000.0, 0.0, Ambiguous),
    // a gust has no share in what a simulation gains
    (1, 0, false, 0.0, 0.0, 0.0, Named),
    (1, 0, false, 0.0, 0.0, 4.0, Unlisted),
    (2, 0, false, 60.0, 60.0, 0.0, Named),
    (2, 0, true, 60.0, 60.0, 0.0, Ambiguous),
    // a small remainder in a shape
    (1, 1, false, 95.0, 100.0, 0.0, Named),
    (1, 1, true, 95.0, 100.0, 0.0, Ambiguous),
    (1, 1, false, 81.0, 100.0, 0.0, Named),
    (2, 1, false, 810.0, 1000.0, 0.0, Named),
    (3, 2, false, 990.0, 1000.0, 0.0, Named),
    // a large one
    (1, 1, false, 79.0, 100.0, 0.0, Unlisted),
    (1, 1, true, 79.0, 100.0, 0.0, Unlisted),
    (2, 1, false, 300.0, 1000.0, 0.0, Unlisted),
    (1, 2, false, 1.0, 1000.0, 0.0, Unlisted),
    (4, 1, false, 700.0, 1000.0, 0.0, Unlisted),
    // a shape in place of the names is fuller, though it is not in the model
    (1, 0, false, 70.0, 100.0, 0.0, Unlisted),
    (1, 0, false, 90.0, 100.0, 0.0, Named),
    (1, 0, true, 90.0, 100.0, 0.0, Ambiguous),
    // tests that fail: a little, and much
    (1, 0, false, 100.0, 100.0, 10.0, Named),
    (1, 0, true, 100.0, 100.0, 10.0, Ambiguous),
    (1, 0, false, 100.0, 100.0, 24.0, Named),
    (1, 0, false, 100.0, 100.0, 26.0, Unlisted),
    (1, 0, false, 10.0, 10.0, 30.0, Unlisted),
    (3, 0, false, 4000.0, 4000.0, 30.0, Named),
    (1, 1, false, 90.0, 100.0, 20.0, Unlisted),
    (1, 1, false, 95.0, 100.0, 5.0, Named),
    // names that gain more than the fullest of the models (they were fitted again)
    (1, 0, false, 101.0, 100.0, 0.0, Named),
];

#[test]
fn every_case_has_its_verdict() {
    for (named, shapes, rivals, names, all, untold, verdict) in CASES {
        let grounds = Grounds {
            named,
            shapes,
            rivals,
            gained_by_names: names,
            gained_by_all: all,
            untold,
            ..Grounds::default()
        };
        assert_eq!(grounds.verdict(), verdict, "{grounds:?}");
    }
}

#[test]
fn what_is_left_of_a_motion_told_to_its_last_hundredths_is_no_mismatch() {
    let slight = Grounds { untold: 500.0, slight: true, ..Grounds::default() };
    assert_eq!(slight.verdict(), NoMismatch);
    assert_eq!(Grounds { shapes: 1, ..slight }.verdict(), Unlisted);
}

#[test]
fn what_speaks_against_a_name_is_told_the_loop_first() {
    let one = Grounds { named: 1, gained_by_names: 70.0, gained_by_all: 100.0, ..Grounds::default() };
    assert_eq!(one.objection(), Some(Objection::Partly(0.7)));
    let unstable = Grounds { unstable: true, ..one };
    assert_eq!(unstable.objection(), Some(Objection::Unstable));
    assert_eq!(Grounds { unseen: true, ..unstable }.objection(), Some(Objection::Unseen));
    assert_eq!(Grounds { named: 0, ..unstable }.objection(), None);
    assert_eq!(Grounds { gained_by_names: 90.0, ..one }.objection(), None);
}

#[test]
fn a_name_that_no_rotation_chooses_is_none() {
    for (named, shapes, rivals, names, all, untold, verdict) in CASES {
        let grounds = Grounds {
            named,
            shapes,
            rivals,
            unstable: named > 0,
            gained_by_names: names,
            gained_by_all: all,
            untold,
            ..Grounds::default()
        };
        assert_eq!(grounds.verdict(), if named > 0 { Unlisted } else { verdict }, "{grounds:?}");
    }
}

#[test]
fn the_data_come_first_and_silence_before_physics() {
    for (named, shapes, rivals, names, all, untold, _) in CASES {
        let grounds = Grounds {
            not_excited: true,
            named,
            shapes,
            rivals,
            gained_by_names: names,
            gained_by_all: all,
            untold,
            ..Grounds::default()
        };
        assert_eq!(grounds.verdict(), NotExcited);
        assert_eq!(Grounds { data_first: true, ..grounds }.verdict(), CheckData);
    }
}

#[test]
fn shares_lie_between_nothing_and_all() {
    for (named, _, _, names, all, untold, _) in CASES {
        let grounds =
            Grounds { named, gained_by_names: names, gained_by_all: all, untold, ..Grounds::default() };
        assert!((0.0..=1.0).contains(&grounds.share_of_names()), "{grounds:?}");
    }
}

#[test]
fn names_that_leave_next_to_nothing_of_the_motion_are_the_answer_whatever_is_significant() {
    let left = Grounds {
        named: 1,
        shapes: 1,
        gained_by_names: 600.0,
        gained_by_all: 1000.0,
        untold: 300.0,
        ..Grounds::default()
    };
    assert_eq!(left.verdict(), Unlisted);
    assert_eq!(Grounds { closed: 0.79, ..left }.verdict(), Unlisted);
    assert_eq!(Grounds { closed: 0.97, ..left }.verdict(), Named);
    assert_eq!(Grounds { closed: 0.97, rivals: true, ..left }.verdict(), Ambiguous);
    assert_eq!(Grounds { closed: 0.97, unstable: true, ..left }.verdict(), Unlisted);
    assert_eq!(Grounds { closed: 0.97, unseen: true, ..left }.verdict(), Unlisted);
}

#[test]
fn names_that_close_just_enough_are_named() {
    let grounds = Grounds { named: 1, gained_by_names: 80.0, gained_by_all: 100.0, ..Grounds::default() };
    assert_eq!((grounds.share_of_names(), grounds.objection()), (0.8, None));
    assert_eq!(grounds.verdict(), Named);
}
