//! The types of the standard (`fmi3PlatformTypes.h`, `fmi3FunctionTypes.h`).

use libc::{c_char, c_int, c_void};

/// `fmi3Instance`: an instance.
pub type Instance = *mut c_void;
/// `fmi3FMUState`: a stored state.
pub type FmuState = *mut c_void;
/// `fmi3InstanceEnvironment`: what the importer wants back with each callback.
pub type Environment = *mut c_void;
/// `fmi3ValueReference`.
pub type Reference = u32;
/// `fmi3Boolean` and `fmi3Clock`: one byte, 0 or 1. Not `bool`: an importer may pass what is neither.
pub type Boolean = u8;
/// `fmi3String`.
pub type Text = *const c_char;
/// `fmi3Binary`.
pub type Binary = *const u8;

/// `fmi3LogMessageCallback`: environment, status, category, message.
pub type LogMessage = unsafe extern "C" fn(Environment, c_int, Text, Text);

/// `fmi3IntermediateUpdateCallback`: environment, time, whether inputs may be set, whether outputs may be read, whether the unit's
/// step is accepted, whether an early return may be asked for; whether it is, and for when.
pub type IntermediateUpdate =
    unsafe extern "C" fn(Environment, f64, Boolean, Boolean, Boolean, Boolean, *mut Boolean, *mut f64);
