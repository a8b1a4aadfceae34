//! Writes a recording in the format in which it is read.

use std::io::Write;

use super::{Recording, sections::WHOLE};
use crate::error::Error;

impl Recording {
    /// Writes the CSV format; every number is the shortest text that reads back to the same value.
    /// Rows outside all sections get the label `-`; the `section` column is left out where the file named none, the
    /// `supervised` and the `unmeasured` column where it is all 0. Columns that were ignored and notes are not written.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write_csv(&self, out: impl Write) -> Result<(), Error> {
        self.write_rows(out).map_err(|error| Error::from_io(&self.name, &error))
    }

    /// The columns that are there, with their names in the format.
    #[must_use]
    pub fn number_columns(&self) -> Vec<(&str, &[f64])> {
        let mut columns: Vec<(&str, &[f64])> = vec![("t_s", &self.t), (self.u_unit.column(), &self.u)];
        let optional = [
            ("q_rad_s", &self.q),
            ("theta_rad", &self.theta),
            ("qdot_rad_s2", &self.qdot),
            ("p_rad_s", &self.p),
            ("r_rad_s", &self.r),
            ("phi_rad", &self.phi),
            ("theta_ref_rad", &self.theta_ref),
            (self.roll_column(), &self.u_roll),
            ("thrust_norm", &self.thrust),
            ("battery_v", &self.battery),
        ];
        columns.extend(optional.into_iter().filter_map(|(name, values)| Some((name, values.as_deref()?))));
        columns
    }

    fn write_rows(&self, out: impl Write) -> std::io::Result<()> {
        let columns = self.number_columns();
        let labels = self.row_labels();
        let flags = self.flags();

        let mut writer = csv::Writer::from_writer(out);
        for (name, _) in &columns {
            writer.write_field(name)?;
        }
        let section = labels.as_ref().map(|_| "section");
        writer.write_record(section.into_iter().chain(flags.iter().map(|(name, _)| *name)))?;
        let mut cell = String::new();
        for row in 0..self.t.len() {
            for (_, values) in &columns {
                cell.clear();
                std::fmt::Write::write_fmt(&mut cell, format_args!("{}", values[row]))
                    .map_err(std::io::Error::other)?;
                writer.write_field(&cell)?;
            }
            let label = labels.as_ref().map(|labels| labels[row]);
            let flags = flags.iter().map(|(_, set)| if set[row] { "1" } else { "0" });
            writer.write_record(label.into_iter().chain(flags))?;
        }
        writer.flush()
    }

    /// The columns of flags that are set in any row.
    pub(super) fn flags(&self) -> Vec<(&'static str, &[bool])> {
        let flags = [("supervised", self.supervised.as_slice()), ("unmeasured", self.unmeasured.as_slice())];
        flags.into_iter().filter(|(_, set)| set.contains(&true)).collect()
    }

    /// The same, 1 where they are set and else 0.
    pub(super) fn flags_as_numbers(&self) -> Vec<(&'static str, Vec<f64>)> {
        let number = |set: &[bool]| set.iter().map(|&set| f64::from(u8::from(set))).collect();
        self.flags().into_iter().map(|(name, set)| (name, number(set))).collect()
    }

    /// Name of the column of the roll axis' command.
    fn roll_column(&self) -> &str {
        let is_roll = |target: &&str| target.starts_with("u_roll_");
        let unit = self.u_unit.roll_column();
        self.columns.iter().map(|map| map.target.as_str()).find(is_roll).unwrap_or(unit)
    }

    /// The file's label of each row; `None` where one section called `all` is everything.
    pub(super) fn row_labels(&self) -> Option<Vec<&str>> {
        let mut labels = vec!["-"; self.t.len()];
        for section in &self.sections {
            labels[section.rows.clone()].fill(&section.file_label);
        }
        (!labels.iter().all(|&label| label == WHOLE)).then_some(labels)
    }
}
