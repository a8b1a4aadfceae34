//! What stops a benchmark.

use std::path::Path;

/// What was found and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The simulator could not fly.
    #[error(transparent)]
    Simulator(#[from] host_sim::Error),
    /// A recording or a model could not be used.
    #[error(transparent)]
    Estimation(#[from] sysid::error::Error),
    /// A plan could not be made.
    #[error(transparent)]
    Plan(#[from] experiment::Error),
    /// A file, a folder or a page.
    #[error("{message}")]
    Place {
        /// What was found, and where.
        message: String,
        /// What to do.
        help: &'static str,
    },
}

impl Error {
    /// A message and what to do.
    pub(crate) fn new(message: impl Into<String>, help: &'static str) -> Self {
        Self::Place { message: message.into(), help }
    }

    /// A file or folder that could not be written.
    pub(crate) fn unwritable(path: &Path, error: &std::io::Error) -> Self {
        let message = format!("{}: cannot be written: {error}", path.display());
        Self::new(message, "name a file in a folder that you may write to")
    }
}
