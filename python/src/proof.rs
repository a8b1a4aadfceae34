//! The proof, case by case.

use crate::failure::raised;
use crate::work::beside;
use benchmark::Case;
use host_sim::Air;
use pitchid::answers;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The folder of a proof.
#[pyclass(frozen, module = "pitchid._native")]
pub struct Proof(benchmark::Proof);

fn air(py: Python<'_>, word: &str) -> PyResult<Air> {
    word.parse().map_err(|error: host_sim::Error| raised(py, &error.into()))
}

#[pymethods]
impl Proof {
    #[new]
    fn new(
        py: Python<'_>,
        folder: PathBuf,
        seed: u64,
        cases: u64,
        air: &str,
        resume: bool,
    ) -> PyResult<Self> {
        let proof = benchmark::Proof::open(&folder, seed, cases, self::air(py, air)?, resume);
        proof.map(Self).map_err(|error| raised(py, &error.into()))
    }

    /// Whether a case is sealed.
    fn is_sealed(&self, case: u64) -> bool {
        self.0.is_sealed(case)
    }

    /// Writes a case and its seal: recording, model, truth.
    fn keep(
        &self,
        py: Python<'_>,
        case: u64,
        recording: String,
        model: String,
        truth: String,
    ) -> PyResult<()> {
        let kept = self.0.keep(case, &Case { recording, model, truth });
        kept.map_err(|error| raised(py, &error.into()))
    }

    /// Writes the hashes of all truths; what the command prints of them.
    fn seals(&self, py: Python<'_>) -> PyResult<String> {
        let seals = self.0.seals().map_err(|error| raised(py, &error.into()))?;
        Ok(answers::told_seals(&seals))
    }

    /// Whether a case was diagnosed.
    fn is_answered(&self, case: u64) -> bool {
        self.0.is_answered(case)
    }

    /// What a diagnosis sees of a case: name, recording, model.
    fn question(&self, py: Python<'_>, case: u64) -> PyResult<[String; 3]> {
        self.0.question(case).map_err(|error| raised(py, &error.into()))
    }

    /// Writes the answers to a case.
    fn keep_answer(&self, py: Python<'_>, case: u64, answer: [String; 2]) -> PyResult<()> {
        self.0.keep_answer(case, &answer).map_err(|error| raised(py, &error.into()))
    }

    /// Opens the truths, counts, writes the results; what the command prints of them.
    fn count(&self, py: Python<'_>) -> PyResult<String> {
        let tables = py.detach(|| self.0.count(&|| ())).map_err(|error| raised(py, &error.into()))?;
        Ok(answers::told_proof(&tables, &self.0))
    }
}

/// Draws a case and flies it: recording, model, truth.
#[pyfunction]
fn conceal(py: Python<'_>, seed: u64, air: &str, case: u64) -> PyResult<(String, String, String)> {
    let air = self::air(py, air)?;
    let Case { recording, model, truth } = beside(py, move |_| Ok(benchmark::conceal(seed, air, case)?))?;
    Ok((recording, model, truth))
}

/// Diagnoses a case from its recording and its model: the JSON of the answer, and of the methods beside it.
#[pyfunction]
fn answer(py: Python<'_>, name: String, recording: String, model: String) -> PyResult<[String; 2]> {
    beside(py, move |_| Ok(benchmark::answer(&name, &recording, &model)?))
}

/// Adds what belongs here to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(conceal, module)?)?;
    module.add_function(wrap_pyfunction!(answer, module)?)
}
