//! What stops a benchmark.

use std::io::{self, ErrorKind};
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
    pub fn unwritable(path: &Path, error: &io::Error) -> Self {
        let help = match error.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
                "make room there, or name a file on another disk"
            }
            _ => "name a file in a folder that you may write to",
        };
        // a file that is written beside its place has a name that says nothing
        let inner = error.get_ref().and_then(|inner| inner.source());
        let why = inner.map_or_else(|| error.to_string(), ToString::to_string);
        Self::new(format!("{}: cannot be written: {why}", path.display()), help)
    }
}
