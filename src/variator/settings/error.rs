//! The error that names the value out of its range.

/// A value out of its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{variable} = {value} is out of range: {range}")]
pub struct ParameterError {
    /// Name of the variable in the interface, e.g. `geometry.wedgeAngle`.
    pub variable: String,
    /// The value that was set.
    pub value: String,
    /// The allowed range in words.
    pub range: String,
}

impl ParameterError {
    /// The error of a value that is out of its `range`, in words.
    #[must_use]
    pub fn new(variable: impl Into<String>, value: impl ToString, range: impl Into<String>) -> Self {
        Self {
            variable: variable.into(),
            value: value.to_string(),
            range: range.into(),
        }
    }
}
