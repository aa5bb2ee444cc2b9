//! What a run reports: remarks, errors, outputs around a moment.

use crate::variator::settings::error::ParameterError;
use crate::variator::settings::signals::Outputs;

/// A remark for the user's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether the user should act on it.
    pub warning: bool,
    /// Text of the remark, one sentence.
    pub text: String,
}

/// Why a variator could not be initialised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InitialisationError {
    /// An input is out of its range.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// No state was found to start from.
    #[error("the initial state could not be found: {0}")]
    NoState(String),
}

/// Why a communication step could not be done. The variator is in the state of before: a shorter step, or one with other inputs, may be
/// possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// An input is out of its range; nothing was changed.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// The step size fell below the smallest useful one.
    #[error("the step from {from} s stalled at {reached} s: {reason}")]
    Stalled {
        /// Start of the step, s.
        from: f64,
        /// How far it came, s.
        reached: f64,
        /// Cause, as the solver reports it.
        reason: String,
    },
    /// The step took more work than any load within a belt's capacity does.
    #[error(
        "the step from {from} s to {to} s was given up at {reached} s after {residuals} residuals: the loads are far beyond what \
         the belt transmits, or the step is too long for them"
    )]
    Exhausted {
        /// Start of the step, s.
        from: f64,
        /// Its end, s.
        to: f64,
        /// How far it came, s.
        reached: f64,
        /// Residuals that it took.
        residuals: u64,
    },
}

/// Outputs a moment before and after the present, along the tangent of the state.
#[derive(Debug)]
pub struct Moment {
    /// Outputs a moment before.
    pub before: Box<Outputs>,
    /// Outputs a moment after.
    pub after: Box<Outputs>,
    /// Time between the two, s.
    pub span: f64,
}
