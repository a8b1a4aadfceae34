//! What is left beside the names: small names, terms without a name, and the tests that fail.

use super::adequacy::Test;
use super::answer::{FailedTest, FitAnswer, Remainder, Verdict};
use super::judgement::Judgement;
use super::posterior::Finding;

/// Failed tests that are told in words, those with the least p-value; the others by name.
const TESTS_IN_WORDS: usize = 2;

impl Judgement<'_, '_> {
    /// Terms without a name that are told as what is left: where no name explains the data they are the answer.
    pub(super) fn shapes_left(&self) -> &[Finding] {
        if self.verdict == Verdict::Unlisted { &[] } else { &self.shapes }
    }

    /// What is left; `None` where nothing is.
    pub(super) fn remainder(&self, fit: &FitAnswer) -> Option<Remainder> {
        let shapes = self.shapes_left();
        let failed: Vec<&Test> = self.failed.iter().filter(|test| test.of_physics).collect();
        if shapes.is_empty() && self.small.is_empty() && failed.is_empty() {
            return None;
        }
        let abouts = self.small.iter().chain(shapes).map(|f| f.effect.about());
        let of = self.rotation.parts.len();
        let small = |f: &Finding| {
            let id = f.effect.about().id;
            let chosen = self.rotation.gain(id).map_or(0, |gain| gain.chosen);
            format!("{} ({id}, chosen in {chosen} of {of} rotations)", f.effect.about().sentence)
        };
        let mut words: Vec<String> = self.small.iter().map(small).collect();
        words.extend(shapes.iter().map(|f| f.effect.about().sentence.to_owned()));
        words.extend(failed.iter().take(TESTS_IN_WORDS).map(|test| test.words.clone()));
        Some(Remainder {
            words: words.join("; "),
            variable: abouts.clone().next().map_or("none", |about| about.variable).into(),
            equation: {
                let small = self.small.iter().map(|f| f.effect.about().equation.to_owned());
                small.chain(shapes.iter().map(|f| self.formula(f))).collect::<Vec<_>>().join("; ")
            },
            parameters: abouts.flat_map(|about| self.own(fit, about.id)).collect(),
            share: 1.0 - self.grounds.share_of_names(),
            tests: failed.iter().map(|t| FailedTest { name: t.name, p_value: t.p_value }).collect(),
        })
    }
}
