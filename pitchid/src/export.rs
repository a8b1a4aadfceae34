//! The linear part of a model as a script for MATLAB or Python.

use crate::failure::Failure;
use std::fmt::Write as _;
use std::path::Path;
use sysid::model::file::ModelFile;

/// Rows of a matrix.
type Matrix = Vec<Vec<f64>>;

/// A language of scripts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// Control System Toolbox.
    Matlab,
    /// numpy, with scipy and python-control.
    Python,
}

impl Language {
    /// What a line of comment begins with.
    pub fn comment(self) -> &'static str {
        match self {
            Self::Matlab => "% ",
            Self::Python => "# ",
        }
    }

    /// By the end of the file's name.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|end| end.to_str()) {
            Some("m") => Ok(Self::Matlab),
            Some("py") => Ok(Self::Python),
            _ => Err(Failure::new(
                format!("{}: neither .m nor .py", path.display()),
                "name a MATLAB script (.m) or a Python module (.py)",
            )),
        }
    }
}

/// The plant from the delayed input to measured rate and angle, in continuous time.
pub struct Linear {
    /// A, row by row.
    pub a: Matrix,
    /// B.
    pub b: Matrix,
    /// C.
    pub c: Matrix,
    /// Delay of the input, s.
    pub delay_s: f64,
    /// Names of the states.
    pub states: &'static [&'static str],
}

/// The plant of `model`; `None` where it has no effectiveness or damping.
pub fn linear(model: &ModelFile) -> Option<Linear> {
    let plant = &model.plant;
    let j = plant.inertia_kg_m2;
    let (damping, gain) = (plant.dm_dq?, plant.dm_du?);
    let delay_s = plant.delay_s.unwrap_or(0.0);
    let Some(((k, c), jp)) = plant.mount_k.zip(plant.mount_c).zip(plant.mount_j) else {
        let a = vec![vec![damping / j, 0.0], vec![1.0, 0.0]];
        let c = vec![vec![1.0, 0.0], vec![0.0, 1.0]];
        return Some(Linear { a, b: vec![vec![gain / j], vec![0.0]], c, delay_s, states: &["q", "theta"] });
    };
    let a = vec![
        vec![(damping - c) / j, c / j, -k / j, k / j],
        vec![c / jp, -c / jp, k / jp, -k / jp],
        vec![1.0, 0.0, 0.0, 0.0],
        vec![0.0, 1.0, 0.0, 0.0],
    ];
    let c = vec![vec![0.0, 1.0, 0.0, 0.0], vec![0.0, 0.0, 0.0, 1.0]];
    let b = vec![vec![gain / j], vec![0.0], vec![0.0], vec![0.0]];
    Some(Linear { a, b, c, delay_s, states: &["q", "q_imu", "theta", "theta_imu"] })
}

/// The script; `input_unit` is that of the recording's input.
///
/// # Errors
/// A model without effectiveness or damping.
pub fn script(model: &ModelFile, input_unit: &str, language: Language) -> Result<String, Failure> {
    let linear = linear(model).ok_or_else(|| {
        let help = "the data did not determine them; excite the axis more, or leave out --export";
        Failure::new("the model has no effectiveness or no damping to write", help)
    })?;
    Ok(match language {
        Language::Matlab => matlab(&linear, model, input_unit),
        Language::Python => python(&linear, model, input_unit),
    })
}

/// What stands above the matrices, each line behind `mark`.
fn head(model: &ModelFile, mark: &str) -> String {
    let mut lines = vec![
        format!("Linear part of a model of one axis, written by pitchid {}.", env!("CARGO_PKG_VERSION")),
        format!(
            "Moment of inertia {} kg m2; with 1 every moment is per unit inertia.",
            model.plant.inertia_kg_m2
        ),
    ];
    let left_out: Vec<&str> = model.effects.iter().map(|effect| effect.id.as_str()).collect();
    if !left_out.is_empty() {
        lines.push(format!(
            "Not in it, as the model file has them beside the linear part: {}.",
            left_out.join(", ")
        ));
    }
    lines.iter().fold(String::new(), |mut text, line| {
        let _ = writeln!(text, "{mark}{line}");
        text
    })
}

fn matlab(linear: &Linear, model: &ModelFile, input_unit: &str) -> String {
    let rows = |matrix: &Matrix| {
        let row = |row: &Vec<f64>| row.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
        format!("[{}]", matrix.iter().map(row).collect::<Vec<_>>().join("; "))
    };
    let names = |names: &[&str]| {
        format!("{{{}}}", names.iter().map(|n| format!("'{n}'")).collect::<Vec<_>>().join(", "))
    };
    format!(
        "{head}A = {a};\nB = {b};\nC = {c};\nD = [0; 0];\ndelay_s = {delay:?};\n\
         sys = ss(A, B, C, D, 'InputDelay', delay_s, ...\n    'StateName', {states}, ...\n    'InputName', {{'u'}}, 'InputUnit', {{'{input_unit}'}}, ...\n    \
         'OutputName', {{'q', 'theta'}}, 'OutputUnit', {{'rad/s', 'rad'}}, 'TimeUnit', 'seconds');\n",
        head = head(model, Language::Matlab.comment()),
        a = rows(&linear.a),
        b = rows(&linear.b),
        c = rows(&linear.c),
        delay = linear.delay_s,
        states = names(linear.states),
    )
}

fn python(linear: &Linear, model: &ModelFile, input_unit: &str) -> String {
    let rows = |matrix: &Matrix| {
        let row = |row: &Vec<f64>| {
            format!("[{}]", row.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", "))
        };
        format!("np.array([{}])", matrix.iter().map(row).collect::<Vec<_>>().join(", "))
    };
    format!(
        "{head}import numpy as np\n\nA = {a}\nB = {b}\nC = {c}\nD = np.zeros((2, 1))\ndelay_s = {delay:?}\n\
         states = {states:?}\ninputs = [\"u\"]  # {unit}\noutputs = [\"q\", \"theta\"]  # rad/s, rad\n\n\n\
         def scipy_system():\n    \"\"\"scipy.signal, without the delay: shift the input by delay_s.\"\"\"\n    from scipy.signal import StateSpace\n\n    \
         return StateSpace(A, B, C, D)\n\n\n\
         def control_system(order=4):\n    \"\"\"python-control, the delay as a Pade approximation of this order.\"\"\"\n    import control\n\n    \
         plant = control.ss(A, B, C, D, states=states, inputs=inputs, outputs=outputs)\n    if delay_s == 0:\n        return plant\n    \
         return plant * control.ss(control.tf(*control.pade(delay_s, order)))\n",
        head = head(model, Language::Python.comment()),
        a = rows(&linear.a),
        b = rows(&linear.b),
        c = rows(&linear.c),
        delay = linear.delay_s,
        states = linear.states,
        unit = if input_unit == "1" { "no unit" } else { input_unit },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(mount: bool) -> ModelFile {
        let mut model = ModelFile::unknown();
        model.plant.inertia_kg_m2 = 0.5;
        model.plant.dm_dq = Some(-0.25);
        model.plant.dm_du = Some(20.0);
        model.plant.delay_s = Some(0.06);
        if mount {
            (model.plant.mount_k, model.plant.mount_c, model.plant.mount_j) =
                (Some(8.0), Some(0.5), Some(0.25));
        }
        model
    }

    #[test]
    fn matrices_are_those_of_the_plant() {
        let script = script(&model(false), "rad", Language::Matlab).unwrap();
        assert!(script.contains("A = [-0.5, 0.0; 1.0, 0.0];\nB = [40.0; 0.0];"), "{script}");
        assert!(script.contains("delay_s = 0.06;") && script.contains("'InputUnit', {'rad'}"), "{script}");
        let with_mount = linear(&model(true)).unwrap();
        // a mount only passes moments on: what it takes from one side it gives to the other
        let [body, imu] = [&with_mount.a[0], &with_mount.a[1]];
        assert_eq!(0.5 * body[1], 0.5);
        assert_eq!((0.5 * body[3], 0.25 * imu[2]), (8.0, 8.0));
        assert_eq!(with_mount.c, [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]);
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        assert!(script(&ModelFile::unknown(), "rad", Language::Python).is_err());
        assert!(Language::of(Path::new("model.txt")).is_err());
        assert_eq!(Language::of(Path::new("a/model.py")).unwrap(), Language::Python);
    }
}
