//! The columns of the format: their names, units and roles.

/// Units of a command, as they end its name.
pub const INPUT_UNITS: [&str; 8] = ["rad", "deg", "pct", "V", "A", "N_m", "N", "norm"];

/// Names a file may use, in the order of the format's table.
pub const KNOWN_COLUMNS: [&str; 35] = [
    "t_s",
    "u_rad",
    "u_deg",
    "u_pct",
    "u_V",
    "u_A",
    "u_N_m",
    "u_N",
    "u_norm",
    "q_rad_s",
    "q_deg_s",
    "theta_rad",
    "theta_deg",
    "qdot_rad_s2",
    "section",
    "supervised",
    "unmeasured",
    "theta_ref_rad",
    "theta_ref_deg",
    "p_rad_s",
    "p_deg_s",
    "r_rad_s",
    "r_deg_s",
    "phi_rad",
    "phi_deg",
    "u_roll_rad",
    "u_roll_deg",
    "u_roll_pct",
    "u_roll_V",
    "u_roll_A",
    "u_roll_N_m",
    "u_roll_N",
    "u_roll_norm",
    "thrust_norm",
    "battery_v",
];

/// The unit of the input; it follows into ∂M/∂u (N m per unit).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputUnit {
    /// Blade pitch difference, rad.
    Rad,
    /// Per cent of the actuator's range.
    Percent,
    /// Volt.
    Volt,
    /// Current of a motor, A.
    Ampere,
    /// Moment command, N m.
    NewtonMetre,
    /// Force, N.
    Newton,
    /// Normalised command, no unit.
    Normalised,
}

impl InputUnit {
    /// The column's name in a recording.
    #[must_use]
    pub fn column(self) -> &'static str {
        match self {
            Self::Rad => "u_rad",
            Self::Percent => "u_pct",
            Self::Volt => "u_V",
            Self::Ampere => "u_A",
            Self::NewtonMetre => "u_N_m",
            Self::Newton => "u_N",
            Self::Normalised => "u_norm",
        }
    }

    /// The name of the roll axis' command in a recording.
    #[must_use]
    pub fn roll_column(self) -> &'static str {
        match self {
            Self::Rad => "u_roll_rad",
            Self::Percent => "u_roll_pct",
            Self::Volt => "u_roll_V",
            Self::Ampere => "u_roll_A",
            Self::NewtonMetre => "u_roll_N_m",
            Self::Newton => "u_roll_N",
            Self::Normalised => "u_roll_norm",
        }
    }

    /// The unit as it is printed; `1` for a normalised command.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Rad => "rad",
            Self::Percent => "%",
            Self::Volt => "V",
            Self::Ampere => "A",
            Self::NewtonMetre => "N m",
            Self::Newton => "N",
            Self::Normalised => "1",
        }
    }

    /// `unit`, that of a size of the command where it is in rad; a moment per angle is no such size.
    pub(crate) fn in_place_of_rad(self, unit: &str) -> String {
        match (self, unit) {
            (Self::Normalised, "1/rad") => "1".into(),
            (_, "N m/rad") => unit.into(),
            _ => unit.replace("rad", self.symbol()),
        }
    }

    /// The unit of ∂M/∂u; `unit` stands for a full command.
    #[must_use]
    pub fn gain_unit(self) -> &'static str {
        match self {
            Self::Rad => "N m/rad",
            Self::Percent => "N m/%",
            Self::Volt => "N m/V",
            Self::Ampere => "N m/A",
            Self::NewtonMetre => "1",
            Self::Newton => "N m/N",
            Self::Normalised => "N m/unit",
        }
    }
}

/// Whether a column of a free vehicle has this name, which that of one axis alone has no place for.
pub(super) fn is_of_another_axis(name: &str) -> bool {
    let command = ["u_pitch_", "u_yaw_"].iter().find_map(|begin| name.strip_prefix(begin));
    command.is_some_and(|unit| INPUT_UNITS.contains(&unit)) || matches!(name, "psi_rad" | "psi_deg")
}

/// What a column means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Input(InputUnit),
    Q,
    Theta,
    Qdot,
    P,
    R,
    Phi,
    ThetaRef,
    RollInput(InputUnit),
    Thrust,
    Battery,
    Section,
    Supervised,
    Unmeasured,
}

impl Role {
    /// The role of a name of the format and the factor to SI; `None` for a name of no meaning.
    pub(super) fn of(name: &str) -> Option<(Self, f64)> {
        const DEGREE: f64 = std::f64::consts::PI / 180.0;
        Some(match name {
            "t_s" => (Self::Time, 1.0),
            "u_rad" => (Self::Input(InputUnit::Rad), 1.0),
            "u_deg" => (Self::Input(InputUnit::Rad), DEGREE),
            "u_pct" => (Self::Input(InputUnit::Percent), 1.0),
            "u_V" => (Self::Input(InputUnit::Volt), 1.0),
            "u_A" => (Self::Input(InputUnit::Ampere), 1.0),
            "u_N_m" => (Self::Input(InputUnit::NewtonMetre), 1.0),
            "u_N" => (Self::Input(InputUnit::Newton), 1.0),
            "u_norm" => (Self::Input(InputUnit::Normalised), 1.0),
            "q_rad_s" => (Self::Q, 1.0),
            "q_deg_s" => (Self::Q, DEGREE),
            "theta_rad" => (Self::Theta, 1.0),
            "theta_deg" => (Self::Theta, DEGREE),
            "qdot_rad_s2" => (Self::Qdot, 1.0),
            "p_rad_s" => (Self::P, 1.0),
            "p_deg_s" => (Self::P, DEGREE),
            "r_rad_s" => (Self::R, 1.0),
            "r_deg_s" => (Self::R, DEGREE),
            "phi_rad" => (Self::Phi, 1.0),
            "phi_deg" => (Self::Phi, DEGREE),
            "theta_ref_rad" => (Self::ThetaRef, 1.0),
            "theta_ref_deg" => (Self::ThetaRef, DEGREE),
            "u_roll_rad" => (Self::RollInput(InputUnit::Rad), 1.0),
            "u_roll_deg" => (Self::RollInput(InputUnit::Rad), DEGREE),
            "u_roll_pct" => (Self::RollInput(InputUnit::Percent), 1.0),
            "u_roll_V" => (Self::RollInput(InputUnit::Volt), 1.0),
            "u_roll_A" => (Self::RollInput(InputUnit::Ampere), 1.0),
            "u_roll_N_m" => (Self::RollInput(InputUnit::NewtonMetre), 1.0),
            "u_roll_N" => (Self::RollInput(InputUnit::Newton), 1.0),
            "u_roll_norm" => (Self::RollInput(InputUnit::Normalised), 1.0),
            "thrust_norm" => (Self::Thrust, 1.0),
            "battery_v" => (Self::Battery, 1.0),
            "section" => (Self::Section, 1.0),
            "supervised" => (Self::Supervised, 1.0),
            "unmeasured" => (Self::Unmeasured, 1.0),
            _ => return None,
        })
    }

    /// The SI name of the column that plays this role.
    pub(super) fn column(self) -> &'static str {
        match self {
            Self::Time => "t_s",
            Self::Input(unit) => unit.column(),
            Self::Q => "q_rad_s",
            Self::Theta => "theta_rad",
            Self::Qdot => "qdot_rad_s2",
            Self::P => "p_rad_s",
            Self::R => "r_rad_s",
            Self::Phi => "phi_rad",
            Self::ThetaRef => "theta_ref_rad",
            Self::RollInput(unit) => unit.roll_column(),
            Self::Thrust => "thrust_norm",
            Self::Battery => "battery_v",
            Self::Section => "section",
            Self::Supervised => "supervised",
            Self::Unmeasured => "unmeasured",
        }
    }

    /// Where a flag is set, as advice.
    pub(super) fn set_where(self) -> &'static str {
        match self {
            Self::Unmeasured => "write 1 where neither rate nor angle was measured in the row",
            _ => "write 1 where the supervisor overrode the excitation",
        }
    }

    /// Two columns with the same slot compete; all inputs of one axis share one.
    pub(super) fn same_slot(self, other: Self) -> bool {
        matches!((self, other), (Self::Input(_), Self::Input(_)) | (Self::RollInput(_), Self::RollInput(_)))
            || self == other
    }

    /// Any of the input columns.
    pub(super) fn is_input(self) -> bool {
        matches!(self, Self::Input(_))
    }

    /// A measured motion, of whichever axis.
    pub(super) fn is_motion(self) -> bool {
        matches!(self, Self::Q | Self::Theta | Self::Qdot | Self::P | Self::R | Self::Phi)
    }

    /// A command, of whichever axis: between samples as the option for the input says.
    pub(super) fn is_command(self) -> bool {
        self.is_input() || matches!(self, Self::RollInput(_) | Self::Thrust)
    }

    /// Commands and flags keep their value until the next sample; measured signals run straight between samples.
    pub(super) fn is_held(self) -> bool {
        self.is_command()
            || matches!(self, Self::ThetaRef | Self::Section | Self::Supervised | Self::Unmeasured)
    }
}

#[cfg(test)]
mod tests {
    use super::InputUnit;

    #[test]
    fn what_is_of_the_command_is_in_its_unit() {
        let units = ["rad", "rad/s", "1/rad", "s", "N m/rad"];
        let of = |input: InputUnit| units.map(|unit| input.in_place_of_rad(unit));
        assert_eq!(of(InputUnit::Rad), units.map(String::from));
        assert_eq!(of(InputUnit::Volt), ["V", "V/s", "1/V", "s", "N m/rad"].map(String::from));
        assert_eq!(of(InputUnit::Normalised), ["1", "1/s", "1", "s", "N m/rad"].map(String::from));
    }
}
