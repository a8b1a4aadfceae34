//! What can be wrong with a scenario or a file.

/// An error with what was found and what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The core refused its configuration.
    #[error("the test cannot be flown: {0}")]
    Core(#[from] estimator_core::ConfigError),
    /// No effect of this name.
    #[error("no effect is called `{id}`; the simulator knows {known}")]
    UnknownEffect {
        /// The name asked for.
        id: String,
        /// The names there are.
        known: String,
    },
    /// No air of this name.
    #[error("no air is called `{word}`; it is one of {known}")]
    UnknownAir {
        /// The word asked for.
        word: String,
        /// The words there are.
        known: String,
    },
    /// A parameter is missing, unknown or no number.
    #[error("effect `{id}`: {problem}")]
    Parameter {
        /// The effect.
        id: &'static str,
        /// What is wrong and what to write.
        problem: String,
    },
    /// A plant that no vehicle can have.
    #[error("plant: {name} is {found}; it must be {expected}")]
    Plant {
        /// The parameter.
        name: &'static str,
        /// Its value.
        found: f64,
        /// The legal range in words.
        expected: &'static str,
    },
    /// The motion leaves every bound: the equations have no such vehicle as their solution, and no sensor is at fault.
    #[error(
        "the simulation blew up at step {step} ({t_s:.2} s): the pitch rate had passed 1000 rad/s; {culprit}"
    )]
    BlownUp {
        /// Tick that saw it.
        step: u32,
        /// Its time, s.
        t_s: f64,
        /// Which parameter it hangs on, as a sentence.
        culprit: String,
    },
    /// A campaign that the paper does not have.
    #[error("there is no campaign {found}; the campaigns are 1 to 4")]
    Campaign {
        /// The number asked for.
        found: usize,
    },
    /// No size of the effect costs that much.
    #[error(
        "leaving out `{id}` costs {low:.1} to {high:.1} points within its usual range; {target} cannot be reached"
    )]
    Unreachable {
        /// The effect.
        id: &'static str,
        /// Cost at the small end, points.
        low: f64,
        /// Cost at the large end, points.
        high: f64,
        /// Cost asked for, points.
        target: f64,
    },
    /// No effect of the catalogue costs that much.
    #[error(
        "no effect of the catalogue can cost {target:.1} points in this scenario; try a larger amplitude"
    )]
    NoneReaches {
        /// Cost asked for, points.
        target: f64,
    },
    /// Whatever was drawn, the supervisor broke the test off.
    #[error("case {seed}: no attempt to conceal {ids} ended as a test should")]
    AlwaysBrokenOff {
        /// Seed of the case.
        seed: u64,
        /// What was to be concealed.
        ids: String,
    },
    /// The truth could not be put into JSON.
    #[error("cannot serialise the truth: {0}")]
    Json(#[from] serde_json::Error),
}
