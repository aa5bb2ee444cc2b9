//! Why a call was not done.

/// Why a call was not done.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// The call is not allowed or makes no sense; nothing has changed.
    #[error("{0}")]
    Refused(String),
    /// The instance needs a reset or a stored state.
    #[error("{0}")]
    Failed(String),
    /// A value was not set, or a step was completed in part only. The master may continue.
    #[error("{0}")]
    Discarded(String),
}

/// How a call ended.
pub type Outcome = Result<(), CallError>;

/// A refusal with this text.
pub(crate) fn refused<T>(text: impl Into<String>) -> Result<T, CallError> {
    Err(CallError::Refused(text.into()))
}
