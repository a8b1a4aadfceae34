//! Units where the inertia is not known: every moment is then one per unit inertia.

/// Units of moments and of their slopes, the longest first, and those per unit inertia.
const UNITS: [(&str, &str); 7] = [
    ("N m s^2/rad^2", "1/rad"),
    ("N m s/rad", "1/s"),
    ("N m s/unit", "rad/s per unit"),
    ("N m/rad^3", "1/(s² rad²)"),
    ("N m/rad", "1/s²"),
    ("N m/unit", "rad/s² per unit"),
    ("N m", "rad/s²"),
];

/// `words`, each unit of a moment in them replaced by that of the moment per unit inertia.
pub fn per_inertia(words: &str) -> String {
    UNITS.iter().fold(words.to_owned(), |words, (moment, specific)| words.replace(moment, specific))
}

#[cfg(test)]
mod tests {
    use super::per_inertia;

    #[test]
    fn a_moment_becomes_an_acceleration_and_a_slope_its_slope() {
        let words =
            "Mc = 0.6 N m (0.5 to 0.7), dM_dq = -1 N m s/rad, dM_du = 130 N m/rad or 20 N m/unit; 3 N m.";
        assert_eq!(
            per_inertia(words),
            "Mc = 0.6 rad/s² (0.5 to 0.7), dM_dq = -1 1/s, dM_du = 130 1/s² or 20 rad/s² per unit; 3 rad/s²."
        );
    }
}
