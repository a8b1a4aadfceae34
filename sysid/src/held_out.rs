//! Which sections are kept aside to judge by.

use crate::dataset::{Dataset, Place};

/// Share of a recording without sections that is kept aside, at its end.
const LAST_SHARE: f64 = 0.3;
/// Share of the motion (squares about the mean) that has to be left to fit on.
const LEFT_TO_FIT: f64 = 1.0 / 3.0;

/// Sections, split into those that are fitted on and those that are held out.
#[derive(Clone, Debug)]
pub struct Split {
    /// Fitted on.
    pub training: Vec<Place>,
    /// Kept aside.
    pub held_out: Vec<Place>,
}

impl Split {
    /// Section IV (the closed loop) is held out; without one, the last section; with one section alone, or where the others hold
    /// less than a third of the motion, the last 30 % of all.
    pub fn new(data: &Dataset) -> Self {
        let places = data.places();
        let file_label =
            |p: &Place| p.label.rsplit(':').next().unwrap_or("").split('#').next().unwrap_or("").to_owned();
        let mut labels: Vec<String> = places.iter().map(file_label).collect();
        let is_last: Box<dyn Fn(&Place) -> bool> = if labels.iter().any(|l| l == "IV") {
            Box::new(move |p| file_label(p) == "IV")
        } else {
            labels.dedup();
            let last = places.last().map(|p| p.label.clone()).unwrap_or_default();
            if labels.len() < 2 {
                return Self::by_time(&places);
            }
            Box::new(move |p| p.label == last)
        };
        let (held_out, training): (Vec<Place>, Vec<Place>) = places.iter().cloned().partition(|p| is_last(p));
        if enough(data, &training) { Self { training, held_out } } else { Self::by_time(&places) }
    }

    /// For validation of identified models: as [`Self::new`], and the last of the sections that are left (an unused PRBS) is held out
    /// too, where the others hold a third of the motion.
    pub fn for_validation(data: &Dataset) -> Self {
        let mut split = Self::new(data);
        if let [others @ .., unused] = &split.training[..]
            && enough(data, others)
        {
            split.held_out.insert(0, unused.clone());
            split.training.pop();
        }
        split
    }

    fn by_time(places: &[Place]) -> Self {
        let total: usize = places.iter().map(|p| p.rows.len()).sum();
        let mut kept = (total as f64 * (1.0 - LAST_SHARE)) as usize;
        let (mut training, mut held_out) = (Vec::new(), Vec::new());
        for place in places {
            let cut = place.rows.start + kept.min(place.rows.len());
            kept -= cut - place.rows.start;
            let push = |list: &mut Vec<Place>, name: &str, rows: core::ops::Range<usize>| {
                if !rows.is_empty() {
                    list.push(Place { label: format!("{} ({name})", place.label), run: place.run, rows });
                }
            };
            push(&mut training, "first part", place.rows.start..cut);
            push(&mut held_out, "last part", cut..place.rows.end);
        }
        Self { training, held_out }
    }

    /// All sections.
    pub fn all(&self) -> Vec<Place> {
        [self.training.clone(), self.held_out.clone()].concat()
    }
}

/// Whether a third of the motion is in `training`: a fit to what hardly moves is a fit to the disturbance.
fn enough(data: &Dataset, training: &[Place]) -> bool {
    !training.is_empty() && data.motion(training) >= LEFT_TO_FIT * data.motion(&data.places())
}

/// Labels of places, each once: a gap cuts a section into several places.
pub fn labels(places: &[Place]) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for place in places {
        if !labels.contains(&place.label) {
            labels.push(place.label.clone());
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, parse};

    /// What is fitted on and what is held out of four seconds of each section, which moves by `size` rad/s.
    fn split(sections: &[(&str, f64)]) -> [Vec<String>; 2] {
        let mut text = String::from("t_s,u_rad,q_rad_s,section\n");
        let rows = sections.iter().flat_map(|section| (0..200).map(move |_| section));
        for (k, (label, size)) in rows.enumerate() {
            let t = 0.02 * k as f64;
            let (sin, cos) = (7.0 * t).sin_cos();
            text += &format!("{t:.2},{:.6},{:.6},{label}\n", 0.1 * size * cos, size * sin);
        }
        let recording = parse("sections.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let split = Split::for_validation(&Dataset::new(&[recording]).unwrap());
        [labels(&split.training), labels(&split.held_out)]
    }

    #[test]
    fn what_is_left_to_fit_on_moves() {
        let two = ["I", "II"].map(|label| (label, 1.0));
        assert_eq!(
            split(&[&two[..], &[("III", 1.0), ("IV", 1.0)]].concat()),
            [vec!["I", "II"], vec!["III", "IV"]]
        );
        assert_eq!(split(&[("rest", 0.1), ("I", 1.0), ("IV", 1.0)]), [vec!["rest", "I"], vec!["IV"]]);
        assert_eq!(split(&two), [vec!["I"], vec!["II"]]);
        let most_in_the_last = split(&[("I", 0.1), ("II", 1.0)]);
        assert_eq!(most_in_the_last, [vec!["I (first part)", "II (first part)"], vec!["II (last part)"]]);
    }
}
