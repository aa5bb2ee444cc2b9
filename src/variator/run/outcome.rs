//! Errors, events and outputs around a moment.

use crate::pulley::Pulley;
use crate::variator::pulleys::loads::SHORTEST_STEP;
use crate::variator::pulleys::rows::Stop;
use crate::variator::settings::{Outputs, ParameterError};

/// A time out of the range of a run.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the time {to} s is out of range: {} to {:.3e} s, above which there is no room for steps of a nanosecond",
    from.unwrap_or(-Self::latest()),
    Self::latest()
)]
pub struct TimeError {
    /// The time, s.
    pub to: f64,
    /// Present time, s; none at a start.
    pub from: Option<f64>,
}

impl TimeError {
    /// Latest time of a run, and the earliest one with the other sign, s: 52 days.
    fn latest() -> f64 {
        SHORTEST_STEP / f64::EPSILON
    }

    /// Checks the next time of a run, s: not before the present one, except by rounding.
    pub(super) fn check(from: Option<f64>, to: f64) -> Result<(), Self> {
        let is_ahead = from.is_none_or(|from| to > from - SHORTEST_STEP);
        if is_ahead && to.abs() <= Self::latest() {
            Ok(())
        } else {
            Err(Self { to, from })
        }
    }
}

/// Why a variator could not be initialised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InitialisationError {
    /// An input is out of its range.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// The time of the start.
    #[error(transparent)]
    Time(#[from] TimeError),
    /// No state was found to start from.
    #[error("the initial state could not be found: {0}")]
    NoState(String),
}

/// Why a communication step could not be done. The variator is in the state of before.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// An input is out of its range; nothing was changed.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// The end of the step; nothing was changed.
    #[error(transparent)]
    Time(#[from] TimeError),
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
    /// The step took more work than under any load within a belt's capacity.
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

/// Outputs a moment before and a moment after the present, for time derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Outputs before.
    pub before: Box<Outputs>,
    /// Outputs after.
    pub after: Box<Outputs>,
    /// Time between them, s.
    pub span: f64,
}

/// An event in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The belt begins to slip through.
    Slips,
    /// The belt grips again.
    Grips,
    /// A movable sheave reaches an end stop.
    Reaches {
        /// The pulley of the sheave.
        pulley: Pulley,
        /// The stop.
        stop: Stop,
    },
}

impl Event {
    pub(super) fn of_slip(slips: bool) -> Self {
        if slips { Self::Slips } else { Self::Grips }
    }

    /// The event in words.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            Self::Slips => "the belt begins to slip through (macro-slip)".into(),
            Self::Grips => "the belt grips again".into(),
            Self::Reaches { pulley, stop } => {
                format!("the {} sheave reaches its {} stop", pulley.name(), stop.name())
            }
        }
    }
}

/// Why a start is not the requested one, what it is instead, and what helps.
pub(super) struct OtherStart<'a> {
    pub why: &'a str,
    pub instead: &'a str,
    pub helps: &'a str,
}
