//! How far ahead the answer's model tells the motion of parts held out.

use super::answer::Predicted;
use super::levels::{SEEN, SEEN_AT_ALL, THE_INPUTS_OWN};
use super::materiality::beyond_the_past;
use super::rotation::{HeldOut, Rotation, Scores};

impl Predicted {
    /// Of the parts held out, by their share of the motion. The free run does not count: in a loop it copies the controller, and not
    /// every loop is seen.
    pub fn new(rotation: &Rotation) -> Self {
        if ahead(rotation) >= SEEN {
            Self::Far
        } else if the_inputs_own(rotation) >= THE_INPUTS_OWN {
            Self::Near
        } else {
            Self::Little
        }
    }
}

/// Whether the answer's model tells nothing of parts held out: not a second ahead, not beyond the past of the next 0.1 s, and less
/// than half by its free run. That nothing is missing from it then says nothing.
pub fn tells_nothing(rotation: &Rotation) -> bool {
    let judged = rotation.parts.iter().any(|part| matches!(part.extended.horizons.last(), Some(Some(_))));
    let free_run = rotation.mean(|part| Some(part.extended.free_run));
    judged && ahead(rotation) < SEEN_AT_ALL && the_inputs_own(rotation) <= 0.0 && free_run < SEEN
}

/// Whether the answer's model tells half of the parts held out, a second ahead or by its free run. Where the input never changes
/// that is all that speaks for it: how a motion goes on for the next 0.1 s follows without any model of what drives it.
pub fn tells_what_was_under_way(rotation: &Rotation) -> bool {
    ahead(rotation).max(rotation.mean(|part| Some(part.extended.free_run))) >= SEEN
}

/// VAF held out at the longest horizon, mean over the parts, per cent.
pub fn ahead(rotation: &Rotation) -> f64 {
    at_the_longest(rotation, |part| &part.extended)
}

/// The same of the baseline, or that of its free run, whichever is less.
pub fn told_without(rotation: &Rotation) -> f64 {
    let free_run = rotation.mean(|part| Some(part.baseline.free_run));
    at_the_longest(rotation, |part| &part.baseline).min(free_run)
}

fn at_the_longest(rotation: &Rotation, model: impl Fn(&HeldOut) -> &Scores) -> f64 {
    rotation.mean(|part| model(part).horizons.last().copied().flatten().map(|(vaf, _)| vaf))
}

/// Share of what the outputs' past alone does not tell at the shortest horizon that the model tells, held out.
fn the_inputs_own(rotation: &Rotation) -> f64 {
    beyond_the_past(rotation.parts.iter().filter_map(|part| {
        let (vaf, error) = part.extended.horizons.first().copied().flatten()?;
        Some((part.share_of_motion, [part.past_alone, vaf, error]))
    }))
}

#[cfg(test)]
mod tests {
    use super::super::rotation::{HeldOut, Scores};
    use super::*;

    /// A part held out, of `share` of the motion: VAF of the past alone, of the model 0.1 and 1 s ahead.
    fn part(share: f64, [past_alone, near, far]: [f64; 3]) -> HeldOut {
        let horizons = [near, 80.0, far].map(|vaf| Some((vaf, 0.5))).into();
        let extended = Scores { free_run: 90.0, horizons };
        HeldOut { extended, past_alone, share_of_motion: share, ..HeldOut::default() }
    }

    fn of(parts: impl IntoIterator<Item = HeldOut>) -> Predicted {
        Predicted::new(&Rotation::of(parts.into_iter().collect()))
    }

    #[test]
    fn half_of_the_motion_a_second_ahead_is_far_whatever_the_free_run() {
        let moving = |far| [part(0.9, [90.0, 90.0, far]), part(0.1, [90.0, 90.0, 0.0])];
        assert_eq!(of(moving(56.0)), Predicted::Far, "0.9 of 56 %");
        assert_eq!(of(moving(55.0)), Predicted::Little);
        assert_eq!(ahead(&Rotation::of(moving(55.0).into())), 49.5);
        let mut short = part(0.6, [90.0, 90.0, 0.0]);
        short.extended.horizons[2] = None;
        assert_eq!(
            ahead(&Rotation::of(vec![short, part(0.4, [90.0, 90.0, 70.0])])),
            70.0,
            "not judged is not 0"
        );
    }

    #[test]
    fn a_model_that_no_part_held_out_follows_tells_nothing() {
        let tells_nothing = |near, far, free_run| {
            let mut all = [part(0.7, [80.0, near, far]), part(0.3, [80.0, near, far])];
            all.iter_mut().for_each(|part| part.extended.free_run = free_run);
            tells_nothing(&Rotation::of(all.into()))
        };
        assert!(tells_nothing(70.0, 0.0, 10.0));
        assert!(!tells_nothing(92.0, 0.0, 10.0), "the next tenth of a second");
        assert!(!tells_nothing(70.0, 5.0, 10.0), "a second");
        assert!(!tells_nothing(70.0, 0.0, 60.0), "the free run");
        assert!(!super::tells_nothing(&Rotation::of(Vec::new())), "no part");
    }

    #[test]
    fn the_next_tenth_of_a_second_alone_is_no_swing_or_decay() {
        let tells = |far, free_run| {
            let mut part = part(1.0, [0.0, 99.0, far]);
            part.extended.free_run = free_run;
            tells_what_was_under_way(&Rotation::of(vec![part]))
        };
        assert!(tells(60.0, 10.0) && tells(10.0, 60.0));
        assert!(!tells(40.0, 40.0));
    }

    #[test]
    fn in_gusts_what_the_past_does_not_tell_of_the_next_tenth_of_a_second_is_near() {
        let near = |vaf| [part(0.8, [80.0, vaf, 0.0]), part(0.2, [80.0, vaf, 0.0])];
        assert_eq!((of(near(92.0)), of(near(90.0))), (Predicted::Near, Predicted::Little));
        let beside_a_quiet_one = [part(0.98, [80.0, 96.0, 0.0]), part(0.02, [0.0, 0.0, 0.0])];
        assert_eq!(of(beside_a_quiet_one), Predicted::Near);
        assert_eq!(of([]), Predicted::Little);
    }
}
