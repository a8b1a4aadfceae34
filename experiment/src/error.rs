//! What stops a plan.

/// What was found and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The simulator could not fly.
    #[error(transparent)]
    Simulator(#[from] host_sim::Error),
    /// What was flown could not be estimated from.
    #[error(transparent)]
    Estimation(#[from] sysid::error::Error),
    /// The craft, the limits or the rivals cannot be as they are given.
    #[error("{message}")]
    Craft {
        /// What was found.
        message: String,
        /// What to do.
        help: String,
    },
}
