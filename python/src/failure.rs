//! Failures as exceptions.

use pitchid::Failure;
use pyo3::prelude::*;

/// The exception `pitchid.PitchidError` of a failure.
pub fn raised(py: Python<'_>, failure: &Failure) -> PyErr {
    let place = failure.place();
    let arguments = (failure.to_string(), failure.help(), &place.file, place.line, &place.column);
    let made = py
        .import("pitchid._errors")
        .and_then(|module| module.getattr("PitchidError"))
        .and_then(|class| class.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}
