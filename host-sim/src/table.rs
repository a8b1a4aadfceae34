//! A recording as a table: named columns over time, whatever a rig logs. What crosses to the identification side is its
//! text alone.

use std::fmt::Write as _;

use crate::flight::Flight;
use crate::recording::Row;

/// One recording. Every column has a value for each time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Comment line above the header.
    pub comment: String,
    /// Time stamps, s.
    pub t_s: Vec<f64>,
    /// The columns after the time, in order.
    pub columns: Vec<Column>,
    /// Label of the section at each row; empty where the recording has no such column.
    pub sections: Vec<String>,
}

/// One column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name, with the unit.
    pub name: String,
    /// Its values; written with the seven or so digits of an `f32`, as a rig logs.
    pub values: Vec<f64>,
}

impl Table {
    /// An empty recording under a comment line.
    #[must_use]
    pub fn new(comment: impl Into<String>, t_s: Vec<f64>) -> Self {
        Self { comment: comment.into(), t_s, ..Self::default() }
    }

    /// What a flight logged, with its sections, the reference and the supervisor's flag.
    #[must_use]
    pub fn of(flight: &Flight) -> Self {
        let rows = &flight.rows;
        let of = |value: fn(&Row) -> f32| rows.iter().map(|row| f64::from(value(row))).collect();
        let mut table = Self::new("a pitch test", rows.iter().map(|row| row.t_s).collect())
            .with("u_rad", of(|row| row.u_rad))
            .with("q_rad_s", of(|row| row.q_rad_s))
            .with("theta_rad", of(|row| row.theta_rad))
            .with("qdot_rad_s2", of(|row| row.qdot_rad_s2))
            .with("supervised", of(|row| f32::from(u8::from(row.supervised))))
            .with("theta_ref_rad", of(|row| row.theta_ref_rad));
        for (name, value) in crate::recording::OPTIONAL {
            let values: Vec<f64> = rows.iter().filter_map(value).map(f64::from).collect();
            if values.len() == rows.len() {
                table = table.with(name, values);
            }
        }
        table.sections = rows.iter().map(|row| row.section.to_string()).collect();
        table
    }

    /// The same with one more column at the end; where it has fewer values than rows the last one stays, and nought
    /// where it has none.
    #[must_use]
    pub fn with(mut self, name: impl Into<String>, mut values: Vec<f64>) -> Self {
        values.resize(self.t_s.len(), values.last().copied().unwrap_or_default());
        self.columns.push(Column { name: name.into(), values });
        self
    }

    /// The values of a column; none where there is no such column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|column| column.name == name).map(|column| column.values.as_slice())
    }

    /// The recording as text: comment, header, one line a row. Times are written to the microsecond.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut text = format!("# {}\nt_s", self.comment);
        self.columns.iter().for_each(|column| text.extend([",", column.name.as_str()]));
        text.push_str(if self.sections.is_empty() { "\n" } else { ",section\n" });
        for (k, t_s) in self.t_s.iter().enumerate() {
            // writing to a string cannot fail
            let _ = write!(text, "{}", (t_s * 1e6).round() / 1e6);
            for column in &self.columns {
                let _ = write!(text, ",{}", column.values.get(k).copied().unwrap_or_default() as f32);
            }
            if let Some(label) = self.sections.get(k) {
                text.extend([",", label.as_str()]);
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::fly;
    use crate::scenario::Scenario;

    #[test]
    fn a_flight_as_a_table_has_the_numbers_of_its_recording() {
        let flight = fly(&Scenario::campaign(4, 0.015, 1).unwrap()).unwrap();
        let table = Table::of(&flight).to_csv();
        let recording = flight.recording();
        let read = |text: &str, name: &str| -> Vec<String> {
            let lines = || text.lines().skip(1).map(|line| line.split(','));
            let place = lines().next().unwrap().position(|column| column == name).unwrap();
            lines().skip(1).map(|mut line| line.nth(place).unwrap().to_owned()).collect()
        };
        for name in ["u_rad", "q_rad_s", "theta_rad", "section", "supervised"] {
            assert_eq!(read(&table, name), read(&recording, name), "{name}");
        }
        let times =
            |text: &str| -> Vec<f64> { read(text, "t_s").iter().map(|t| t.parse().unwrap()).collect() };
        assert_eq!(times(&table), times(&recording));
    }
}
