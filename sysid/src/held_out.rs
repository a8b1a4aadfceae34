//! Which sections are kept aside to judge by.

use crate::dataset::{Dataset, Place};

/// Share of a recording without sections that is kept aside, at its end.
const LAST_SHARE: f64 = 0.3;

/// Sections, split into those that are fitted on and those that are held out.
#[derive(Clone, Debug)]
pub struct Split {
    /// Fitted on.
    pub training: Vec<Place>,
    /// Kept aside.
    pub held_out: Vec<Place>,
}

impl Split {
    /// Section IV (the closed loop) is held out; without one, the last section; with one section alone, its last
    /// third (less a little).
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
        let (held_out, training): (Vec<Place>, Vec<Place>) = places.into_iter().partition(|p| is_last(p));
        if training.is_empty() { Self::by_time(&held_out) } else { Self { training, held_out } }
    }

    /// For validation of identified models: as [`Self::new`], and where two or more sections are left, the last of
    /// them (an unused PRBS) is held out too.
    pub fn for_validation(data: &Dataset) -> Self {
        let mut split = Self::new(data);
        if split.training.len() >= 2
            && let Some(unused) = split.training.pop()
        {
            split.held_out.insert(0, unused);
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

/// Labels of places.
pub fn labels(places: &[Place]) -> Vec<String> {
    places.iter().map(|p| p.label.clone()).collect()
}
