//! Questions, and their answers.

use crate::failure::raised;
use crate::recording::Recording;
use crate::work::beside;
use numpy::ndarray::Array2;
use numpy::{PyArray2, ToPyArray};
use pitchid::answers::{self, Question};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::Arc;

/// An answer with all that it can be shown as.
#[pyclass(frozen, module = "pitchid._native")]
pub struct Answer(answers::Answer);

/// A linear model: A, B, C, D, step in s (none in continuous time), delay of the input in s, names of the states.
type Linear<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Option<f64>,
    f64,
    Vec<String>,
);

#[pymethods]
impl Answer {
    /// What the command writes with `--json`.
    #[getter]
    fn json<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.0.json.as_bytes())
    }
    /// What the command prints.
    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }
    /// The report; none of an answer that has no report.
    fn html(&self, py: Python<'_>) -> PyResult<Option<String>> {
        py.detach(|| self.0.html()).map_err(|failure| raised(py, &failure))
    }
    /// The pictures: name and SVG.
    fn pictures(&self, py: Python<'_>) -> Vec<(String, String)> {
        py.detach(|| self.0.pictures())
    }
    /// The model that was found, as a model file.
    #[getter]
    fn model(&self) -> Option<&str> {
        self.0.model.as_ref().map(|model| model.toml.as_str())
    }
    /// The linear part of that model.
    fn linear<'py>(&self, py: Python<'py>) -> Option<Linear<'py>> {
        let linear = self.0.model.as_ref()?.linear.as_ref()?;
        let matrix = |rows: &[Vec<f64>]| {
            let columns = rows.first().map_or(0, Vec::len);
            Array2::from_shape_fn((rows.len(), columns), |(i, j)| rows[i][j]).to_pyarray(py)
        };
        let d = Array2::zeros((linear.c.len(), 1)).to_pyarray(py);
        let states = linear.states.iter().map(|&name| name.to_owned()).collect();
        Some((matrix(&linear.a), matrix(&linear.b), matrix(&linear.c), d, None, linear.delay_s, states))
    }
    /// Sampled state-space models, by the method that found them.
    fn methods<'py>(&self, py: Python<'py>) -> Vec<(String, Linear<'py>)> {
        let all = self.0.methods.iter().map(|(name, model)| {
            let order = model.order();
            let a = Array2::from_shape_fn((order, order), |(i, j)| model.a()[(i, j)]).to_pyarray(py);
            let b = Array2::from_shape_fn((order, 1), |(i, _)| model.b()[i]).to_pyarray(py);
            let c = Array2::from_shape_fn((1, order), |(_, j)| model.c()[j]).to_pyarray(py);
            let d = Array2::from_elem((1, 1), model.d()).to_pyarray(py);
            let delay = model.delay_samples() as f64 * model.step();
            let states = (1..=order).map(|k| format!("x{k}")).collect();
            (name.clone(), (a, b, c, d, Some(model.step()), delay, states))
        });
        all.collect()
    }
}

/// The question that recordings at hand are about.
fn question(py: Python<'_>, recordings: &[Py<Recording>], model: Option<PathBuf>) -> PyResult<Question> {
    let axis = recordings.first().map_or("pitch", |first| first.get().axis.as_str());
    let all = match recordings {
        [one] => Arc::clone(&one.get().of),
        several => several.iter().map(|one| one.get().of[0].clone()).collect(),
    };
    Question::of_recordings(all, axis, model.as_deref()).map_err(|failure| raised(py, &failure))
}

#[pyfunction]
fn diagnose_files(py: Python<'_>, words: Vec<String>) -> PyResult<Answer> {
    beside(py, move |progress| answers::diagnose_files(&words, progress)).map(Answer)
}

#[pyfunction]
#[pyo3(signature = (recordings, model))]
fn diagnose(py: Python<'_>, recordings: Vec<Py<Recording>>, model: Option<PathBuf>) -> PyResult<Answer> {
    let question = question(py, &recordings, model)?;
    beside(py, move |progress| answers::diagnose(question, progress)).map(Answer)
}

#[pyfunction]
fn identify_files(py: Python<'_>, words: Vec<String>) -> PyResult<Answer> {
    let ask = move |progress: &sysid::progress::Progress<'_>| {
        answers::identify(Question::read("identify", &words)?, progress)
    };
    beside(py, ask).map(Answer)
}

#[pyfunction]
#[pyo3(signature = (recordings, model))]
fn identify(py: Python<'_>, recordings: Vec<Py<Recording>>, model: Option<PathBuf>) -> PyResult<Answer> {
    let question = question(py, &recordings, model)?;
    beside(py, move |progress| answers::identify(question, progress)).map(Answer)
}

#[pyfunction]
fn compare_files(py: Python<'_>, words: Vec<String>) -> PyResult<Answer> {
    beside(py, move |progress| answers::compare_files(&words, progress)).map(Answer)
}

#[pyfunction]
#[pyo3(signature = (before, after, model, friction))]
fn compare(
    py: Python<'_>,
    before: &Recording,
    after: &Recording,
    model: Option<PathBuf>,
    friction: bool,
) -> PyResult<Answer> {
    let sides = [before, after].map(|side| side.of[0].clone());
    let axis = before.axis.clone();
    let ask = move |progress: &sysid::progress::Progress<'_>| {
        answers::compare(sides, &axis, model.as_deref(), friction, progress)
    };
    beside(py, ask).map(Answer)
}

#[pyfunction]
fn plan(py: Python<'_>, words: Vec<String>) -> PyResult<Answer> {
    beside(py, move |progress| answers::plan(&words, progress)).map(Answer)
}

#[pyfunction]
fn show_files(py: Python<'_>, words: Vec<String>) -> PyResult<Answer> {
    beside(py, move |_| answers::show_files(&words)).map(Answer)
}

#[pyfunction]
fn show(py: Python<'_>, recording: &Recording) -> PyResult<Answer> {
    let (of, axis) = (Arc::clone(&recording.of), recording.axis.clone());
    beside(py, move |_| answers::show(&of[0], &axis)).map(Answer)
}

/// A flight in the simulator: what was flown, the truth as JSON, the recording as CSV.
#[pyfunction]
fn simulate(py: Python<'_>, words: Vec<String>) -> PyResult<(Answer, String, String)> {
    let flight = beside(py, move |_| answers::simulate(&words))?;
    Ok((Answer(flight.answer), flight.truth, flight.recording))
}

/// Adds what belongs here to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(diagnose_files, module)?)?;
    module.add_function(wrap_pyfunction!(diagnose, module)?)?;
    module.add_function(wrap_pyfunction!(identify_files, module)?)?;
    module.add_function(wrap_pyfunction!(identify, module)?)?;
    module.add_function(wrap_pyfunction!(compare_files, module)?)?;
    module.add_function(wrap_pyfunction!(compare, module)?)?;
    module.add_function(wrap_pyfunction!(plan, module)?)?;
    module.add_function(wrap_pyfunction!(show_files, module)?)?;
    module.add_function(wrap_pyfunction!(show, module)?)?;
    module.add_function(wrap_pyfunction!(simulate, module)?)
}
