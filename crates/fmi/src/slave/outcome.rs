//! The ways in which a call can end.

use crate::table::Inadmissible;

/// Why a call was not done.
#[derive(Debug)]
pub(super) enum Trouble {
    /// Nothing has changed.
    Refused(String),
    /// The instance needs a reset or a stored state.
    Failed(String),
    /// A value was not taken, or a step was completed in part only. The master may go on.
    Discarded(String),
}

impl From<Inadmissible> for Trouble {
    fn from(reason: Inadmissible) -> Self {
        Self::Discarded(reason.to_string())
    }
}

/// How a call ended.
pub(super) type Outcome = Result<(), Trouble>;

/// A refusal with this text.
pub(super) fn refused<T>(text: impl Into<String>) -> Result<T, Trouble> {
    Err(Trouble::Refused(text.into()))
}
