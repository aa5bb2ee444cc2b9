//! What a run reports beside messages: errors, events, outputs around a moment.

use crate::pulley::Pulley;
use crate::variator::pulleys::rows::Stop;
use crate::variator::settings::ParameterError;

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

/// What a master may want to handle when it happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The belt begins to slip through.
    Slips,
    /// The belt grips again.
    Grips,
    /// A movable sheave reaches an end stop.
    Reaches(Pulley, Stop),
}

impl Event {
    /// The belt slips through from now on, or grips.
    pub(super) fn of_slip(slips: bool) -> Self {
        if slips { Self::Slips } else { Self::Grips }
    }

    /// The event in words.
    pub fn text(self) -> String {
        match self {
            Self::Slips => "the belt begins to slip through (macro-slip)".into(),
            Self::Grips => "the belt grips again".into(),
            Self::Reaches(pulley, stop) => format!("the {} sheave reaches its {} stop", pulley.name(), stop.name()),
        }
    }
}
