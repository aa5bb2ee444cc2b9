//! The C functions of FMI 2.0 for co-simulation, for any unit.
//!
//! The functions convert raw pointers to references and slices; the module `slave` makes the calls.
//! No panic leaves a function. The caller of a function grants, beyond what the function itself requires:
//!
//! - a component comes from `fmi2Instantiate`, has not been freed, and is used by one call at a time
//!   (not from within its own logger callback either);
//! - a stored state is null, or it comes from `fmi2GetFMUstate` or `fmi2DeSerializeFMUstate` and has not been freed;
//! - an array argument is null or points to as many elements as its count; a string is null or ends with a zero;
//! - a pointer for a result is null or points to writable memory;
//! - a pointer is aligned for its type, and memory from the caller is initialised.
//!
//! The status is an error for a null pointer where the standard requires a value.

mod creation;
#[doc(hidden)]
pub mod functions;
pub mod query;
mod types;

pub use functions::NAMES;
pub use types::{CallbackFunctions, Component, FmuState, Logger};
