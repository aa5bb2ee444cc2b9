//! FMI 3.0 for co-simulation: its C functions for any unit, and its XML.
//!
//! The caller of a function grants what [`fmi2`](super::fmi2) lists, with the functions of FMI 3.0.
//! Within `fmi3DoStep` the intermediate update callback may use the instance; the callback for
//! messages may not. By the standard, an instance is terminated after an error. Here a refused call
//! leaves it unchanged.

#[cfg(feature = "c")]
use std::ffi::c_int;
use std::ffi::{c_char, c_void};

#[cfg(feature = "c")]
mod creation;
#[cfg(feature = "c")]
#[doc(hidden)]
pub mod functions;
#[cfg(feature = "c")]
mod steps;
#[forbid(unsafe_code)]
mod terminals;

#[cfg(feature = "c")]
pub use crate::instance::{Environment, IntermediateUpdate};
#[cfg(feature = "c")]
pub use functions::NAMES;
pub use terminals::{Terminal, terminals_and_icons};

/// `fmi3Instance`: an instance.
pub type Instance = *mut c_void;
/// `fmi3FMUState`: a stored state.
pub type FmuState = *mut c_void;
/// `fmi3ValueReference`.
pub type Reference = u32;
/// `fmi3Boolean` and `fmi3Clock`: one byte, 0 or 1. Not `bool`: an importer may pass another
/// number.
pub type Boolean = u8;
/// `fmi3String`.
pub type Text = *const c_char;
/// `fmi3Binary`.
pub type Binary = *const u8;

/// `fmi3LogMessageCallback`: environment, status, category, message.
#[cfg(feature = "c")]
pub type LogMessage = unsafe extern "C" fn(Environment, c_int, Text, Text);
