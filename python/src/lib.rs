//! The native part of the Python package `pitchid`: recordings, questions and answers. The package's Python files give
//! them their shape.

mod answer;
mod failure;
mod page;
mod proof;
mod recording;
mod work;

use pyo3::prelude::*;

/// The module `pitchid._native`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    pitchid::answers::be_quiet();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<recording::Recording>()?;
    module.add_class::<answer::Answer>()?;
    module.add_class::<proof::Proof>()?;
    recording::add(module)?;
    answer::add(module)?;
    proof::add(module)?;
    page::add(module)
}
