//! FMI 3.0 for co-simulation: its C functions for any unit, and its XML.
//!
//! The caller of a function grants what [`fmi2`](super::fmi2) lists, with instances from `fmi3InstantiateCoSimulation` and stored states
//! from `fmi3GetFMUState` or `fmi3DeserializeFMUState`. Within `fmi3DoStep` the intermediate update callback may use the instance; the
//! callback for messages may not.
//!
//! By the standard, an instance is terminated after an error. Here a refused call leaves it unchanged.

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
