//! The C functions of FMI 2.0 for co-simulation, for any unit.
//!
//! The functions convert raw pointers to references and slices; the module `instance` makes the
//! calls. No panic leaves a function. The caller of a function grants, beyond what the function
//! itself requires:
//!
//! - a component comes from `fmi2Instantiate`, has not been freed, and is used by one call at a
//!   time (not from within its own logger callback either);
//! - a stored state is null, or it comes from `fmi2GetFMUstate` or `fmi2DeSerializeFMUstate` and
//!   has not been freed;
//! - callbacks are null or can be called with their environment until the instance is freed;
//! - an array argument is null or points to as many elements as its count; a string is null or ends
//!   with a zero;
//! - a pointer for a result is null or points to writable memory, which no other array or string
//!   argument contains;
//! - a pointer is aligned for its type, and memory from the caller is initialised, but for the
//!   memory of results, which is only written to.
//!
//! The status is an error for a null pointer where the standard requires a value.

use libc::{c_char, c_int, c_void};

mod creation;
#[doc(hidden)]
pub mod functions;
pub mod query;

pub use functions::NAMES;

/// `fmi2Component`: an instance.
pub type Component = *mut c_void;
/// `fmi2FMUstate`: a stored state.
pub type FmuState = *mut c_void;

/// `fmi2CallbackLogger`: environment, instance name, status, category, message format, arguments of
/// the format.
pub type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`. Only the logger is used: memory is the library's own, and steps finish
/// before they return.
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
