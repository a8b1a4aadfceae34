//! Recordings: CSV with one header line, a unit in every column's name, nothing of the truth.

use estimator_core::Section;
use std::fmt::Write as _;

/// One row. u is held over [t, t + Ts); the readings were taken at t, before u acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Time, s.
    pub t_s: f64,
    /// Command, rad.
    pub u_rad: f32,
    /// Pitch rate, rad/s.
    pub q_rad_s: f32,
    /// Pitch angle, rad.
    pub theta_rad: f32,
    /// Pitch acceleration, rad/s².
    pub qdot_rad_s2: f32,
    /// Part of the test.
    pub section: Section,
    /// True where the supervisor overrode the test.
    pub supervised: bool,
    /// Reference of the controller, rad.
    pub theta_ref_rad: f32,
    /// Roll rate (rad/s), yaw rate (rad/s) and roll angle (rad), where they are logged.
    pub roll_yaw: Option<[f32; 3]>,
    /// Command of the roll axis (rad), where it is logged.
    pub u_roll_rad: Option<f32>,
    /// Collective command, as a share of full thrust, where it is logged.
    pub thrust_norm: Option<f32>,
    /// Supply voltage (V), where it is logged.
    pub battery_v: Option<f32>,
}

/// Name of a column that not every recording has, and what a row has in it.
pub(crate) type Optional = (&'static str, fn(&Row) -> Option<f32>);

/// Columns that a recording has where a row has them.
pub(crate) const OPTIONAL: [Optional; 6] = [
    ("p_rad_s", |row| row.roll_yaw.map(|[p, _, _]| p)),
    ("r_rad_s", |row| row.roll_yaw.map(|[_, r, _]| r)),
    ("phi_rad", |row| row.roll_yaw.map(|[_, _, phi]| phi)),
    ("u_roll_rad", |row| row.u_roll_rad),
    ("thrust_norm", |row| row.thrust_norm),
    ("battery_v", |row| row.battery_v),
];

/// The recording as text, under a comment line. Numbers are written in full, so reading them back gives the
/// very samples that the core saw.
#[must_use]
pub fn to_csv(rows: &[Row], comment: &str) -> String {
    let mut text = format!("# {comment}\n");
    text.push_str("t_s,u_rad,q_rad_s,theta_rad,qdot_rad_s2,section,supervised,theta_ref_rad");
    let logged = OPTIONAL.map(|(_, value)| rows.iter().any(|row| value(row).is_some()));
    let optional = || OPTIONAL.iter().zip(logged).filter(|(_, logged)| *logged).map(|(column, _)| column);
    optional().for_each(|(name, _)| text.extend([",", name]));
    text.push('\n');
    for row in rows {
        let Row { t_s, u_rad, q_rad_s, theta_rad, qdot_rad_s2, section, supervised, theta_ref_rad, .. } = row;
        let supervised = u8::from(*supervised);
        // writing to a string cannot fail
        let _ = write!(
            text,
            "{t_s:.2},{u_rad},{q_rad_s},{theta_rad},{qdot_rad_s2},{section},{supervised},{theta_ref_rad}"
        );
        for (_, value) in optional() {
            let _ = write!(text, ",{}", value(row).unwrap_or_default());
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_reads_back_to_the_same_bits() {
        let row = Row {
            t_s: 12.34,
            u_rad: -0.015,
            q_rad_s: 0.123_456_79,
            theta_rad: -1.0e-7,
            qdot_rad_s2: 3.0,
            section: Section::II,
            supervised: true,
            theta_ref_rad: 0.0,
            roll_yaw: None,
            u_roll_rad: None,
            thrust_norm: None,
            battery_v: None,
        };
        let text = to_csv(&[row], "one row");
        let fields: Vec<&str> = text.lines().nth(2).unwrap().split(',').collect();
        assert_eq!(fields, ["12.34", "-0.015", "0.12345679", "-0.0000001", "3", "II", "1", "0"]);
        assert_eq!(fields[2].parse::<f32>().unwrap().to_bits(), row.q_rad_s.to_bits());
        let text = to_csv(&[Row { roll_yaw: Some([0.1, -0.2, 0.3]), ..row }], "one row");
        assert!(text.lines().nth(1).unwrap().ends_with(",theta_ref_rad,p_rad_s,r_rad_s,phi_rad"));
        assert!(text.lines().nth(2).unwrap().ends_with(",1,0,0.1,-0.2,0.3"));
    }
}
