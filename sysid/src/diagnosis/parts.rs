//! The parts of the data that are held out in turn.

use crate::dataset::{Dataset, Place};

/// Span below which its ends are told to the tenth, s.
const SHORT_S: f64 = 2.0;
/// Most parts that are held out in turn.
const MOST_PARTS: usize = 8;
/// Share of an equal span that every span has at least: a burst of motion is no part by itself, and nothing is predicted over one
/// that is shorter than the prediction.
const LEAST_SHARE: f64 = 0.5;

/// A part of the data that is held out at once.
#[derive(Clone, Debug)]
pub struct Part {
    /// Section, or span of time.
    pub label: String,
    /// Where it is.
    pub places: Vec<Place>,
}

/// The parts of the data that are held out in turn: the sections; of more than a few, the recordings; of one section alone,
/// `pieces` spans of time in each of which the vehicle moves as much.
pub fn parts(data: &Dataset, pieces: usize) -> Vec<Part> {
    let places = data.places();
    let by = |key: &dyn Fn(&Place) -> String| -> Vec<Part> {
        let mut parts: Vec<Part> = Vec::new();
        for place in &places {
            let label = key(place);
            match parts.iter_mut().find(|part| part.label == label) {
                Some(part) => part.places.push(place.clone()),
                None => parts.push(Part { label, places: vec![place.clone()] }),
            }
        }
        parts
    };
    let sections = by(&|place| place.label.clone());
    if sections.len() < 2 {
        return spans(data, &places, pieces);
    }
    if sections.len() <= MOST_PARTS {
        return sections;
    }
    let recordings = by(&|place| format!("recording {}", data.runs[place.run].recording + 1));
    if (2..=MOST_PARTS).contains(&recordings.len()) {
        return recordings;
    }
    let size = sections.len().div_ceil(MOST_PARTS);
    let merged = |some: &[Part]| {
        let labels: Vec<&str> = some.iter().map(|part| part.label.as_str()).collect();
        Part { label: labels.join(", "), places: some.iter().flat_map(|part| part.places.clone()).collect() }
    };
    sections.chunks(size).map(merged).collect()
}

/// Spans of time with equal shares of the motion's power, as far as none is much shorter than the others, over `places` one after
/// the other.
fn spans(data: &Dataset, places: &[Place], pieces: usize) -> Vec<Part> {
    let power = |place: &Place| -> Vec<f64> {
        let rate = data.runs[place.run].rate_or_slope();
        let rate = &rate[place.rows.clone()];
        let mean = rate.iter().sum::<f64>() / rate.len().max(1) as f64;
        rate.iter().map(|q| (q - mean) * (q - mean)).collect()
    };
    let powers: Vec<Vec<f64>> = places.iter().map(power).collect();
    let total: f64 = powers.iter().flatten().sum();
    let rows: usize = powers.iter().map(Vec::len).sum();
    let least = (LEAST_SHARE * rows as f64 / pieces as f64) as usize;
    let mut parts: Vec<Part> = Vec::new();
    let (mut sum, mut seen, mut cut) = (0.0, 0, 0);
    for (place, powers) in places.iter().zip(&powers) {
        let mut begin = place.rows.start;
        for (i, power) in powers.iter().enumerate() {
            sum += power;
            seen += 1;
            let (row, last) = (place.rows.start + i + 1, i + 1 == powers.len());
            let to_come = pieces.saturating_sub(parts.len() + 1);
            let has_its_share = sum >= total * (parts.len() + 1) as f64 / pieces as f64;
            // the spans to come need their rows
            let must = rows - seen <= to_come * least;
            let full = to_come > 0 && seen - cut >= least && (has_its_share || must);
            if full || last {
                let run = &data.runs[place.run];
                let label = span(run.time(begin), run.time(row));
                let piece = Place { label: label.clone(), run: place.run, rows: begin..row };
                parts.push(Part { label, places: vec![piece] });
                begin = row;
                cut = seen;
            }
            if full && last {
                break;
            }
        }
    }
    parts.retain(|part| part.places.iter().all(|place| !place.rows.is_empty()));
    parts
}

/// A span of time in words, a short one to the tenth.
fn span(from: f64, to: f64) -> String {
    let tenths = if to - from < SHORT_S { 10.0 } else { 1.0 };
    // Adding 0 makes 0 of −0.
    let [from, to] = [from, to].map(|t| (t * tenths).round() / tenths + 0.0);
    format!("{from} to {to} s")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::{Flight, STEP, flight};
    use crate::diagnosis::fixture::asked;

    fn lengths(flight: &Flight) -> Vec<f64> {
        let rows =
            |part: &Part| part.places.iter().map(|place| place.rows.len()).sum::<usize>() as f64 * STEP;
        asked(flight, |problem, _| parts(problem.data, 4).iter().map(rows).collect())
    }

    #[test]
    fn a_burst_of_motion_is_no_part_by_itself() {
        let even = flight(1, 0.0);
        let all = even.q.len() as f64 * STEP;
        let mut burst = even.clone();
        for (k, q) in burst.q.iter_mut().enumerate() {
            *q += if (600..620).contains(&k) { 20.0 } else { 0.0 };
        }
        for flight in [even, burst] {
            let lengths = lengths(&flight);
            assert_eq!(lengths.len(), 4, "{lengths:?}");
            assert!(lengths.iter().all(|length| *length > 0.12 * all), "{lengths:?}");
        }
    }
}
