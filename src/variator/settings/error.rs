//! The error that names the value out of its range.

/// A value out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{variable} = {value} is out of range: {range}")]
pub struct ParameterError {
    /// Name of the variable in the interface, e.g. `geometry.wedgeAngle`.
    pub variable: &'static str,
    /// The value that was set.
    pub value: Value,
    /// The allowed range in words.
    pub range: String,
}

impl ParameterError {
    /// The error of a number that is out of its `range`, in words.
    #[must_use]
    pub fn new(variable: &'static str, value: f64, range: String) -> Self {
        let value = Value::Number(value);
        Self { variable, value, range }
    }

    /// The error of a Boolean that other parameters don't allow.
    #[must_use]
    pub fn of_flag(variable: &'static str, value: bool, range: &str) -> Self {
        Self {
            variable,
            value: Value::Flag(value),
            range: range.to_string(),
        }
    }
}

/// A value that is out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Value of a real, integer or enumeration.
    Number(f64),
    /// Value of a Boolean.
    Flag(bool),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(value) => value.fmt(f),
            Self::Flag(value) => value.fmt(f),
        }
    }
}
