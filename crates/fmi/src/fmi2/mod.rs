//! The C functions of FMI 2.0 for co-simulation. With those of FMI 3.0 and what both share they are the only `unsafe` code.
//!
//! Here raw pointers become references and slices, and nothing else happens: the calls themselves are in
//! [`slave`](super::slave). Each function here is generic over the unit. `export!` gives them the standard's names and
//! signatures (`fmi2FunctionTypes.h`) for one unit. No panic leaves a function. The caller of a function grants, beyond
//! what the function itself asks for:
//!
//! - a component comes from `fmi2Instantiate`, has not been freed, and is used by one call at a time
//!   (not from within its own logger callback either);
//! - an array argument is null or points to as many elements as its count; a string is null or ends with a zero;
//! - a pointer for a result is null or points to writable memory;
//! - a pointer is aligned for its type, and memory that comes from beyond the boundary holds some value or other.
//!
//! A null pointer where the standard wants a value is answered with an error.
//!
//! | file | what it holds |
//! |---|---|
//! | `types` | the standard's types |
//! | `boundary` | pointers to references, slices and strings; panics to errors |
//! | `creation` | creation and destruction of an instance |
//! | `resources` | the resource location, a URI |
//! | `setup` | log, set-up, initialisation, end |
//! | `values` | reading and writing of variables |
//! | `states` | stored states and their bytes |
//! | `derivatives` | derivatives with respect to time |
//! | `steps` | communication steps, and how the last one ended |
//! | `answers` | text beyond the standard |
//! | `exports` | the table of the exported names |

pub mod answers;
mod boundary;
#[doc(hidden)]
pub mod creation;
#[doc(hidden)]
pub mod derivatives;
#[doc(hidden)]
pub mod exports;
#[forbid(unsafe_code)]
mod resources;
#[doc(hidden)]
pub mod setup;
#[doc(hidden)]
pub mod states;
#[doc(hidden)]
pub mod steps;
mod types;
#[doc(hidden)]
pub mod values;

pub use types::{CallbackFunctions, Component, FmuState, Logger};
