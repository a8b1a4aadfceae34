//! Recordings, and their columns as arrays of numpy.

use crate::failure::raised;
use crate::work::beside;
use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pitchid::answers::Question;
use pyo3::prelude::*;
use std::sync::Arc;
use sysid::recording::{Column, ReadOptions, from_columns, parse};

/// A recording of one axis on a uniform clock, SI units.
#[pyclass(frozen, module = "pitchid._native")]
pub struct Recording {
    /// One recording, shared with every answer about it.
    pub of: Arc<[sysid::recording::Recording]>,
    /// Its axis.
    pub axis: String,
}

impl Recording {
    fn get(&self) -> &sysid::recording::Recording {
        &self.of[0]
    }
}

#[pymethods]
impl Recording {
    /// What messages call it.
    #[getter]
    fn name(&self) -> &str {
        &self.get().name
    }
    /// The axis.
    #[getter]
    fn axis(&self) -> &str {
        &self.axis
    }
    /// Step of the clock, s.
    #[getter]
    fn step(&self) -> f64 {
        self.get().step
    }
    /// Unit of the input; `1` for a normalised command.
    #[getter]
    fn input_unit(&self) -> &'static str {
        self.get().u_unit.symbol()
    }
    /// Sections: name, first row, row behind the last.
    #[getter]
    fn sections(&self) -> Vec<(&str, usize, usize)> {
        let sections = self.get().sections.iter();
        sections.map(|section| (section.label.as_str(), section.rows.start, section.rows.end)).collect()
    }
    /// What was done to the data and what looks wrong.
    #[getter]
    fn notes(&self) -> Vec<&str> {
        self.get().notes.iter().map(|note| note.text.as_str()).collect()
    }
    /// Rows where the supervisor overrode the excitation.
    #[getter]
    fn supervised(&self) -> Vec<bool> {
        self.get().supervised.clone()
    }
    /// Rows in which neither rate nor angle was measured.
    #[getter]
    fn unmeasured(&self) -> Vec<bool> {
        let mut rows = self.get().unmeasured.clone();
        rows.resize(self.get().len(), false);
        rows
    }

    fn __len__(&self) -> usize {
        self.get().len()
    }

    /// Names of the columns of numbers.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.get().number_columns().into_iter().map(|(name, _)| name).collect()
    }

    /// A column as a read-only array that shares the recording's memory; none where there is no such column.
    #[allow(unsafe_code)]
    fn column<'py>(slf: &Bound<'py, Self>, name: &str) -> Option<Bound<'py, PyArray1<f64>>> {
        let columns = slf.get().get().number_columns();
        let (_, values) = columns.into_iter().find(|(known, _)| *known == name)?;
        // SAFETY: the values belong to a frozen object that nothing changes, and the array keeps that object alive.
        let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), slf.clone().into_any()) };
        array.readwrite().make_nonwriteable();
        Some(array)
    }

    /// The recording as CSV, as the command reads it.
    fn csv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyBytes>> {
        let mut bytes = Vec::new();
        let written = self.get().write_csv(&mut bytes);
        written.map_err(|error| raised(py, &error.into()))?;
        Ok(pyo3::types::PyBytes::new(py, &bytes))
    }
}

/// Labels of sections: the names, and for each row an index into them.
type Labels<'py> = (Vec<String>, PyReadonlyArray1<'py, u32>);

/// Makes a recording of columns.
#[pyfunction]
#[pyo3(signature = (name, axis, columns, labels, splits, sections, hold))]
#[allow(clippy::too_many_arguments, clippy::needless_pass_by_value)]
fn recording_of(
    py: Python<'_>,
    name: &str,
    axis: String,
    columns: Vec<(String, PyReadonlyArray1<'_, f64>)>,
    labels: Option<Labels<'_>>,
    splits: Vec<f64>,
    sections: Vec<String>,
    hold: &str,
) -> PyResult<Recording> {
    let raise = |error: sysid::error::Error| raised(py, &error.into());
    let mut all: Vec<(String, Column)> = columns
        .into_iter()
        .map(|(name, values)| (name, Column::Numbers(values.as_array().to_vec())))
        .collect();
    if let Some((names, rows)) = labels {
        all.push(("section".to_owned(), Column::Labels { names, rows: rows.as_array().to_vec() }));
    }
    let options = ReadOptions {
        splits,
        sections: sections.iter().map(|of| of.parse()).collect::<Result<_, _>>().map_err(raise)?,
        input_hold: hold.parse().map_err(raise)?,
        ..ReadOptions::default()
    };
    let recording = py.detach(|| from_columns(name, all, &options)).map_err(raise)?;
    Ok(Recording { of: Arc::new([recording]), axis })
}

/// Reads a recording of the text of a CSV file.
#[pyfunction]
fn recording_of_csv(py: Python<'_>, name: &str, text: &str) -> PyResult<Recording> {
    let read = py.detach(|| parse(name, text.as_bytes(), &ReadOptions::default()));
    let recording = read.map_err(|error| raised(py, &error.into()))?;
    Ok(Recording { of: Arc::new([recording]), axis: "pitch".to_owned() })
}

/// Reads recordings: file names and options of `pitchid diagnose`.
#[pyfunction]
fn read(py: Python<'_>, words: Vec<String>) -> PyResult<Vec<Recording>> {
    let (all, axis) = beside(py, move |_| Ok(Question::read("diagnose", &words)?.recordings()))?;
    if all.len() == 1 {
        return Ok(vec![Recording { of: all, axis }]);
    }
    let of =
        |one: &sysid::recording::Recording| Recording { of: Arc::new([one.clone()]), axis: axis.clone() };
    Ok(all.iter().map(of).collect())
}

/// Adds what belongs here to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(recording_of, module)?)?;
    module.add_function(wrap_pyfunction!(recording_of_csv, module)?)?;
    module.add_function(wrap_pyfunction!(read, module)?)
}
