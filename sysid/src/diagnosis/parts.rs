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
/// the other, whatever gaps lie between them.
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
    let mut open: Vec<Place> = Vec::new();
    let (mut sum, mut seen, mut cut) = (0.0, 0, 0);
    for (place, powers) in places.iter().zip(&powers) {
        let mut begin = place.rows.start;
        for (row, power) in (begin + 1..).zip(powers) {
            sum += power;
            seen += 1;
            let to_come = pieces.saturating_sub(parts.len() + 1);
            let has_its_share = sum >= total * (parts.len() + 1) as f64 / pieces as f64;
            // the spans to come need their rows
            let must = rows - seen <= to_come * least;
            if to_come > 0 && seen - cut >= least && (has_its_share || must) {
                open.push(Place { label: String::new(), run: place.run, rows: begin..row });
                parts.push(part_of(data, core::mem::take(&mut open)));
                begin = row;
                cut = seen;
            }
        }
        if begin < place.rows.end {
            open.push(Place { label: String::new(), run: place.run, rows: begin..place.rows.end });
        }
    }
    if !open.is_empty() {
        parts.push(part_of(data, open));
    }
    parts
}

/// A part called by the time from the first of its places to the end of the last.
fn part_of(data: &Dataset, places: Vec<Place>) -> Part {
    let at = |place: &Place, row: usize| data.runs[place.run].time(row);
    let begin = places.first().map_or(0.0, |place| at(place, place.rows.start));
    let end = places.last().map_or(0.0, |place| at(place, place.rows.end));
    let label = span(begin, end);
    let places = places.into_iter().map(|place| Place { label: label.clone(), ..place }).collect();
    Part { label, places }
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
    use crate::diagnosis::data_checks::fixture::{Flight, GAIN, STEP, fitted, flight, model, read};
    use crate::diagnosis::fixture::asked;

    fn lengths(flight: &Flight) -> Vec<f64> {
        let rows =
            |part: &Part| part.places.iter().map(|place| place.rows.len()).sum::<usize>() as f64 * STEP;
        asked(flight, |problem, _| parts(problem.data, 4).iter().map(rows).collect())
    }

    #[test]
    fn a_gap_does_not_make_parts() {
        let sound = Flight { section: "-", ..flight(1, 0.0) };
        let rows: Vec<String> = sound.text().lines().map(|line| line.to_owned() + "\n").collect();
        let cut = [&rows[..400], &rows[410..1900], &rows[1930..]].concat().concat();
        let of = |text: &str| fitted(&read(text), &model(GAIN, 0.06), |_, problem, _| parts(problem.data, 4));
        let (whole, cut) = (of(&rows.concat()), of(&cut));
        assert_eq!(cut.len(), 4);
        for (a, b) in whole.iter().zip(&cut) {
            let ends = |part: &Part| {
                let row = |part: &str| part.parse::<f64>().unwrap();
                let (from, to) = part.label.trim_end_matches(" s").split_once(" to ").unwrap();
                [row(from), row(to)]
            };
            assert!(
                ends(a).iter().zip(ends(b)).all(|(a, b)| (a - b).abs() <= 1.0),
                "{} {}",
                a.label,
                b.label
            );
        }
        assert_eq!(cut.iter().map(|part| part.places.len()).sum::<usize>(), 6);
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
