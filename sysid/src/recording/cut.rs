//! A part of a recording by time.

use std::ops::Range;

use super::{Recording, Section};
use crate::error::{Error, ErrorKind};

/// Rows that a segment of a part needs.
const LEAST_ROWS: usize = 3;

impl Recording {
    /// Leaves the rows with `from` ≤ t < `to`, s.
    ///
    /// # Errors
    /// No segment of three rows is left; the error tells from when to when there is one.
    pub fn cut(&mut self, from: f64, to: f64) -> Result<(), Error> {
        let rows = self.t.partition_point(|t| *t < from)..self.t.partition_point(|t| *t < to);
        let within = |own: &Range<usize>| {
            let part = own.start.max(rows.start)..own.end.min(rows.end);
            (part.start < part.end).then(|| part.start - rows.start..part.end - rows.start)
        };
        let segments: Vec<Range<usize>> = self.segments.iter().filter_map(within).collect();
        if !segments.iter().any(|segment| segment.len() >= LEAST_ROWS) {
            let [first, last] = [self.t.first(), self.t.last()].map(|t| t.copied().unwrap_or_default());
            let found = format!("nothing is recorded in --time {from}..{to}");
            let advice = format!("its clock runs from {first:.3} to {last:.3} s");
            return Err(Error::new(ErrorKind::Section, found, advice).in_file(self.name.as_str()));
        }
        let section = |section: &Section| Some(Section { rows: within(&section.rows)?, ..section.clone() });
        self.sections = self.sections.iter().filter_map(section).collect();
        self.segments = segments;
        self.supervised = self.supervised[rows.clone()].to_vec();
        if !self.unmeasured.is_empty() {
            self.unmeasured = self.unmeasured[rows.clone()].to_vec();
        }
        let signals = [
            &mut self.q,
            &mut self.theta,
            &mut self.qdot,
            &mut self.p,
            &mut self.r,
            &mut self.phi,
            &mut self.theta_ref,
            &mut self.u_roll,
            &mut self.thrust,
            &mut self.battery,
        ];
        for values in signals.into_iter().flatten().chain([&mut self.t, &mut self.u]) {
            values.truncate(rows.end);
            values.drain(..rows.start);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ReadOptions, parse};

    #[test]
    fn a_part_has_its_rows_and_sections_alone() {
        let mut text = "t_s,u_rad,q_rad_s,section\n".to_owned();
        for k in 0..300 {
            let x = f64::from(k);
            text += &format!("{:.2},{x},{},{}\n", 0.02 * x, x.sin(), ["I", "II", "IV"][k as usize / 100]);
        }
        let whole = parse("a.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let mut part = whole.clone();
        part.cut(1.0, 3.0).unwrap();
        assert_eq!((part.t[0], part.len(), part.supervised.len()), (1.0, 100, 100));
        assert_eq!(part.q.as_deref(), whole.q.as_ref().map(|q| &q[50..150]));
        let rows = |label: &str| part.section(label).map(|section| section.rows.clone());
        assert_eq!((rows("I").unwrap(), rows("II").unwrap()), (0..50, 50..100));
        assert!(rows("IV").is_err() && part.segments.first() == Some(&(0..100)));
        let refused = part.cut(7.0, 9.0).unwrap_err().to_string();
        assert!(refused.contains("--time 7..9") && refused.contains("from 1.000 to 2.980 s"), "{refused}");
    }
}
