//! The types of the standard (`fmi2FunctionTypes.h`).

use libc::{c_char, c_int, c_void};

/// `fmi2Component`: an instance.
pub type Component = *mut c_void;
/// `fmi2FMUstate`: a stored state.
pub type FmuState = *mut c_void;

/// `fmi2CallbackLogger`: environment, instance name, status, category, message format, arguments of the format.
pub type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`. Only the logger is used: memory is the library's own, and steps finish before they return.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct CallbackFunctions {
    /// The importer's function for messages; may be null.
    pub logger: Option<Logger>,
    /// Not called.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not called.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not called.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// First argument of the logger.
    pub component_environment: *mut c_void,
}
