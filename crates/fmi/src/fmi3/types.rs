//! The types of the standard (`fmi3PlatformTypes.h`, `fmi3FunctionTypes.h`).

use libc::{c_char, c_int, c_void};

pub use crate::slave::{Environment, IntermediateUpdate};

/// `fmi3Instance`: an instance.
pub type Instance = *mut c_void;
/// `fmi3FMUState`: a stored state.
pub type FmuState = *mut c_void;
/// `fmi3ValueReference`.
pub type Reference = u32;
/// `fmi3Boolean` and `fmi3Clock`: one byte, 0 or 1. Not `bool`: an importer may pass another number.
pub type Boolean = u8;
/// `fmi3String`.
pub type Text = *const c_char;
/// `fmi3Binary`.
pub type Binary = *const u8;

/// `fmi3LogMessageCallback`: environment, status, category, message.
pub type LogMessage = unsafe extern "C" fn(Environment, c_int, Text, Text);
