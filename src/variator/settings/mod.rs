//! Parameters with their ranges, inputs, outputs.

pub(crate) mod capacity;
pub(crate) mod parameters;
pub(crate) mod signals;
pub(crate) mod validation;

pub use parameters::*;
pub use signals::*;
pub use validation::{ParameterError, Value, range_of};
