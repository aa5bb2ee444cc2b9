//! One instance: its calls, for both versions of the standard.
//!
//! A call is [done](crate::log::Status), or it ends with a [`CallError`]: *refused* (wrong state, unknown value reference, not
//! supported), and nothing has changed; *failed* (no initial state, a panic), and only [`Slave::reset`], a stored state or the
//! end of the instance follow; *discarded* (a value out of range, a step that was not completed): all is as before, and the master decides.
//!
//! Methods have the names of the C functions. [`Slave::call`] makes a call: it logs errors and contains panics.
//!
//! | file | content |
//! |---|---|
//! | `error` | the reasons why a call was not completed |
//! | `instance` | the instance, and the common parts of all calls |
//! | `lifecycle` | log, set-up, initialisation, event mode, end |
//! | `values` | reading and writing of variables |
//! | `clock` | the time of the master and that of the unit |
//! | `derivatives` | derivatives of inputs and outputs with respect to time |
//! | `states` | stored states |
//! | `steps` | communication steps, and how the last one ended |

mod clock;
mod derivatives;
mod error;
mod instance;
mod lifecycle;
mod states;
mod steps;
mod values;

pub(crate) use clock::Clock;
pub(crate) use error::refused;
pub use error::{CallError, Outcome};
pub use instance::{Environment, IntermediateUpdate, Master, Slave, Version};
pub use steps::{Ended, Next, StatusKind, Update};
pub(crate) use values::TIME;
pub use values::{Number, Type};
