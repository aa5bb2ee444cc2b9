//! FMI 3.0 for co-simulation: its C functions for any unit, and its XML.
//!
//! As in [`fmi2`](super::fmi2), raw pointers become references and slices here, and the calls themselves are in
//! [`slave`](super::slave). `export!` gives the functions the standard's names and signatures (`fmi3FunctionTypes.h`) for one unit.
//! No panic leaves a function. The caller of a function grants, beyond what the function itself asks for:
//!
//! - an instance comes from `fmi3InstantiateCoSimulation`, has not been freed, and is used by one call at a time (within
//!   `fmi3DoStep` its intermediate update callback may use it, the callback for messages may not);
//! - an array argument is null or points to as many elements as its count; a string is null or ends with a zero;
//! - a pointer for a result is null or points to writable memory;
//! - a pointer is aligned for its type, and memory that comes from beyond the boundary holds some value or other.
//!
//! A null pointer where the standard wants a value is answered with an error.
//!
//! Where the standard would have an instance terminated by an error, a call that could not be made sense of leaves it as it was.
//!
//! | file | what it holds |
//! |---|---|
//! | `types` | the standard's types |
//! | `description` | `modelDescription.xml` and the instantiation token made from it |
//! | `terminals` | `terminalsAndIcons.xml` |
//! | `instance` | a slave with what its master handles, and the communication step under way |
//! | `boundary` | pointers to instances; panics to errors |
//! | `creation` | creation and destruction of an instance |
//! | `setup` | log, initialisation, event mode, end |
//! | `layout`, `values` | where values lie in an array; reading and writing of variables |
//! | `states` | stored states and their bytes |
//! | `derivatives` | derivatives with respect to time |
//! | `steps` | communication steps, and the master's part in them |
//! | `elsewhere` | functions of what this FMU is not or has not |
//! | `exports` | the table of the exported names |

mod boundary;
#[doc(hidden)]
pub mod creation;
#[doc(hidden)]
pub mod derivatives;
#[forbid(unsafe_code)]
mod description;
#[doc(hidden)]
pub mod elsewhere;
#[doc(hidden)]
pub mod exports;
#[forbid(unsafe_code)]
mod instance;
#[forbid(unsafe_code)]
mod layout;
#[doc(hidden)]
pub mod setup;
#[doc(hidden)]
pub mod states;
#[doc(hidden)]
pub mod steps;
#[forbid(unsafe_code)]
mod terminals;
mod types;
#[doc(hidden)]
pub mod values;

pub use description::{instantiation_token, model_description};
pub use terminals::{HALF_SIZE, Terminal, terminals_and_icons};
pub use types::{Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text};
