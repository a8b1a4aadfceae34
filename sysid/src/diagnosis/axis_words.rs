//! The words of an answer for another axis than pitch, whose equations are the same while the axes beside it change places, and for a
//! craft whose inertia is not known.

use super::answer::Answer;
use crate::estimate::per_inertia;

/// `words` of pitch, said of `axis` (`roll`, `pitch` or `yaw`): pitch and that axis change places wherever one of them stands as
/// a word.
pub fn of_axis(words: &str, axis: &str) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut said = String::with_capacity(words.len());
    let mut rest = words;
    while !rest.is_empty() {
        let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(length);
        said.push_str(match word {
            "pitch" => axis,
            word if word == axis => "pitch",
            word => word,
        });
        let between = after.find(is_part).unwrap_or(after.len());
        said.push_str(&after[..between]);
        rest = &after[between..];
    }
    said
}

impl Answer {
    /// Says of `axis` what was found where the axis stood as pitch does.
    pub fn tell_of(&mut self, axis: &str) {
        for text in self.words() {
            *text = of_axis(text, axis);
        }
    }

    /// Tells moments per unit inertia: the inertia is not known.
    pub fn tell_per_inertia(&mut self) {
        self.per_unit_inertia = true;
        for text in self.words() {
            *text = per_inertia(text);
        }
        let equations = self.effects.iter_mut().map(|effect| &mut effect.equation);
        for equation in equations.chain(self.remainder.iter_mut().map(|remainder| &mut remainder.equation)) {
            *equation = per_inertia(equation);
        }
        let fits = [&mut self.fit.baseline, &mut self.fit.extended].map(|model| &mut model.parameters);
        let terms = self.effects.iter_mut().map(|effect| &mut effect.parameters);
        let left = self.remainder.iter_mut().map(|remainder| &mut remainder.parameters);
        for parameter in fits.into_iter().chain(terms).chain(left).flatten() {
            parameter.unit = per_inertia(&parameter.unit);
        }
    }

    /// All that is told in sentences.
    fn words(&mut self) -> Vec<&mut String> {
        let mut words: Vec<&mut String> = vec![&mut self.summary];
        words.extend(self.questions.iter_mut().map(|question| &mut question.answer));
        words.extend(self.balance.iter_mut().map(|balance| &mut balance.words));
        words.extend(self.data_checks.iter_mut().map(|check| &mut check.words));
        words.extend(self.remainder.iter_mut().map(|remainder| &mut remainder.words));
        words.extend(self.location.iter_mut().map(|location| &mut location.condition));
        words.extend(self.next_experiment.iter_mut().map(|next| &mut next.why));
        words
    }
}

#[cfg(test)]
mod tests {
    use super::of_axis;

    #[test]
    fn axes_change_places_as_words_alone() {
        let words = "roll and yaw rates couple into pitch; Pitch, u_pitch_norm and θ stay: pitch";
        assert_eq!(
            of_axis(words, "roll"),
            "pitch and yaw rates couple into roll; Pitch, u_pitch_norm and θ stay: roll"
        );
        assert_eq!(of_axis("roll, pitch, yaw", "yaw"), "roll, yaw, pitch");
        assert_eq!(of_axis(words, "pitch"), words);
        assert_eq!(of_axis("", "roll"), "");
    }
}
