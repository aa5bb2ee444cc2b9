//! Creation of an instance.

use libc::{c_char, c_int, c_void};

use super::{CallbackFunctions, Component, Logger};
use crate::c::creation::{Texts, c_string, create};
use crate::c::entry::CO_SIMULATION_ONLY;
use crate::c::floating_point::in_hosts;
use crate::description::Version;
use crate::instance::Importer;
use crate::log::{Sink, Status};
use crate::processor;
use crate::unit::Unit;

/// Whether the processor has the instructions that the code is compiled for; if not, logs an error.
/// No other code may run before it, not even the packing of arguments.
///
/// # Safety
/// The name is null or ends with a zero. `functions` is null or points to the standard's structure,
/// whose logger is null or can be called with its environment.
pub(super) unsafe fn processor_suffices(name: *const c_char, functions: *const CallbackFunctions) -> bool {
    if processor::suffices() {
        return true;
    }
    // Not through a `Sink`, whose code may need what the processor lacks.
    // SAFETY: the caller grants that it is null or points to the structure.
    if let Some(functions) = unsafe { functions.as_ref() }
        && let Some(logger) = functions.logger
    {
        let (environment, status) = (functions.component_environment, Status::Error as c_int);
        let (category, text) = (c"logStatusError".as_ptr(), processor::NO_AVX2.as_ptr());
        // SAFETY: the caller grants that the logger can be called. The texts are constants that end
        // with a zero.
        unsafe { logger(environment, name, status, category, text) };
    }
    false
}

/// `fmi2Instantiate`: creates an instance; null if the arguments don't fit this FMU. Never
/// inlined: none of its code may run before [`processor_suffices`].
///
/// # Safety
/// Each of the texts is null or ends with a zero. `functions` is null or points to the standard's
/// structure, whose logger is null or can be called with its environment until the instance is
/// freed.
#[inline(never)]
pub(super) unsafe fn instantiate<U: Unit>(
    texts: Texts<*const c_char>,
    fmu_type: c_int,
    functions: *const CallbackFunctions,
    debug: bool,
) -> Component {
    // SAFETY: the caller grants that it is null or points to the structure, during this call.
    let functions = unsafe { functions.as_ref() };
    let messages = |instance: &str| {
        let functions = functions?;
        Some(sink(functions.logger?, functions.component_environment, instance))
    };
    let importer = |_: &dyn Fn(&str)| match fmu_type {
        CO_SIMULATION => Ok(Importer::default()),
        _ => Err(CO_SIMULATION_ONLY.to_owned()),
    };
    // SAFETY: the caller grants this of the texts.
    unsafe { create::<U>(Version::Two, texts, debug, messages, importer) }
}

/// `fmi2CoSimulation` of the standard's `fmi2Type`.
const CO_SIMULATION: c_int = 1;

/// Passes messages of an instance on to its logger.
fn sink(logger: Logger, environment: *mut c_void, instance: &str) -> Sink {
    let instance = c_string(instance);
    Box::new(move |status, category, text| {
        // Loggers that take no arguments, as those of Python, write the format itself. A text with
        // a percent sign is the argument of "%s".
        let format = if text.contains('%') {
            c"%s".to_owned()
        } else {
            c_string(text)
        };
        let [category, text] = [category.name(), text].map(c_string);
        let (instance, category, text) = (instance.as_ptr(), category.as_ptr(), text.as_ptr());
        let (status, format) = (status as c_int, format.as_ptr());
        // SAFETY: the importer gave the function, with this environment, for the lifetime of the
        // instance, in which the log owns this sink. The strings end with a zero and exist during
        // the call. The format has no directive, or one with its argument; C ignores further
        // arguments.
        in_hosts(|| unsafe { logger(environment, instance, status, category, format, text) });
    })
}
