//! One instance, in the order of the standard's state machine.
//!
//! Every call ends in one of four ways. *Done*. *Refused* (wrong state, unknown value reference, nothing to offer):
//! an error for the master, and nothing has changed. *Failed* (no initial state, a panic): an error, after which only
//! [`Slave::reset`], a stored state or the end of the instance go on. *Discarded*: a value out of range, and nothing has
//! changed, or a step that was completed in part only. The master decides whether to go on.
//!
//! | file | what it holds |
//! |---|---|
//! | `outcome` | the four ways |
//! | `instance` | the instance, and what every call goes through |
//! | `lifecycle` | log, set-up, initialisation, end |
//! | `values` | reading and writing of variables |
//! | `derivatives` | derivatives of inputs and outputs with respect to time |
//! | `states` | stored states |
//! | `steps` | communication steps, and how the last one ended |
//! | `answers` | questions beyond the standard |
//! | `modes` | what FMI 3.0 adds: initialisation with its experiment, event mode |
//! | `typed` | its other types of variables |
//! | `own_steps` | its communication steps, one own step of the unit after the other |

mod answers;
mod derivatives;
mod instance;
mod lifecycle;
mod modes;
mod outcome;
mod own_steps;
mod states;
mod steps;
mod typed;
mod values;

pub use instance::{Slave, Version};
pub use own_steps::Underway;
pub use steps::StatusKind;
