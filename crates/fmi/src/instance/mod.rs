//! One instance: its calls, for both versions of the standard.
//!
//! A call is [done](crate::log::Status), or it ends with a [`CallError`]: *refused* (wrong state,
//! unknown value reference, not supported), and nothing has changed; *failed* (no initial state, a
//! panic), and only [`FmuInstance::reset`], a stored state or the end of the instance follow;
//! *discarded* (a value out of range, a step that was not completed), and all is as before. Each
//! call is refused in a state that does not allow it; the sections on errors have the other
//! reasons.
//!
//! Methods have the names of the C functions; a call that only changes the state is `enter`.
//! [`FmuInstance::call`] makes a call: it logs errors and contains panics.

mod bytes;
mod calls;
mod clock;
mod derivatives;
mod lifecycle;
mod snapshot;
mod steps;
mod values;

pub use calls::{Callback, Environment, FmuInstance, Importer, IntermediateUpdate};
pub use snapshot::Snapshot;
pub use steps::{Ended, Next, Update};
pub use values::Type;

/// Why a call was not done.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub enum CallError {
    /// The call is not allowed or makes no sense; nothing has changed.
    Refused(String),
    /// The instance needs a reset or a stored state.
    Failed(String),
    /// A value was not set, or a step was completed in part only. The importer may continue.
    Discarded(String),
}

/// How a call ended.
pub type Outcome = Result<(), CallError>;

pub(crate) fn refused<T>(text: impl Into<String>) -> Result<T, CallError> {
    Err(CallError::Refused(text.into()))
}
