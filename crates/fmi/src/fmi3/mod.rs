//! FMI 3.0 for co-simulation: its C functions for any unit, and its XML.
//!
//! As in [`fmi2`](super::fmi2), the functions convert raw pointers to references and slices, and the calls themselves are in
//! [`slave`](super::slave). No panic leaves a function. The caller of a function grants, beyond what the function itself requires:
//!
//! - an instance comes from `fmi3InstantiateCoSimulation`, has not been freed, and is used by one call at a time (within
//!   `fmi3DoStep` its intermediate update callback may use it, the callback for messages may not);
//! - a stored state is null, or it comes from `fmi3GetFMUState` or `fmi3DeserializeFMUState` and has not been freed;
//! - an array argument is null or points to as many elements as its count; a string is null or ends with a zero;
//! - a pointer for a result is null or points to writable memory;
//! - a pointer is aligned for its type, and memory from the caller is initialised.
//!
//! The status is an error for a null pointer where the standard requires a value.
//!
//! By the standard, an instance is terminated after an error. Here a refused call leaves it unchanged.
//!
//! | file | content |
//! |---|---|
//! | `types` | the standard's types |
//! | `functions` | the table of the C functions |
//! | `creation` | creation of an instance |
//! | `steps` | communication steps, with intermediate update mode |
//! | `terminals` | `terminalsAndIcons.xml` |

mod creation;
#[doc(hidden)]
pub mod functions;
mod steps;
#[forbid(unsafe_code)]
mod terminals;
mod types;

pub use functions::NAMES;
pub use terminals::{HALF_SIZE, Terminal, terminals_and_icons};
pub use types::{Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text};
