//! Parameters with their ranges, inputs, outputs.

pub(crate) mod capacity;
pub(crate) mod choices;
pub(crate) mod error;
pub(crate) mod parameters;
pub(crate) mod signals;
pub(crate) mod table;
pub(crate) mod validation;

pub use error::ParameterError;
pub use parameters::*;
pub use signals::*;
pub use table::{InputRows, ParameterRows, Row, RowField, RowValue, range_of};
pub use validation::bisected;
