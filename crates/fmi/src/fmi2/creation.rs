//! Creation of an instance.

use std::ffi::CString;

use libc::{c_char, c_int, c_void};
use std::ptr;

use super::description::guid_with;
use super::types::{CallbackFunctions, Component, Logger};
use crate::c::creation::{Arguments, create};
use crate::c::entry::{contain, text};
use crate::c::floating_point::in_hosts;
use crate::c::instances::instance_created;
use crate::log::{Category, Sink, Status};
use crate::processor;
use crate::slave::Master;
use crate::unit::Unit;

/// The importer's logger, with the arguments that every message has in common.
struct Importer {
    logger: Logger,
    environment: *mut c_void,
    instance: CString,
}

impl Sink for Importer {
    fn send(&self, status: Status, category: Category, text: &str) {
        let category = CString::new(category.name()).unwrap_or_default();
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        // SAFETY: the importer gave this function as a logger, with this environment, for the lifetime of the
        // instance. The strings end with a zero and exist during the call. The message is the argument of "%s", so
        // that a percent sign in it is not taken for a format.
        in_hosts(|| unsafe {
            (self.logger)(
                self.environment,
                self.instance.as_ptr(),
                status as c_int,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        });
    }
}

/// `fmi2Instantiate`: creates an instance; null if the arguments don't fit this FMU.
///
/// # Safety
/// The strings and `functions` are null or valid during the call; the logger in it can be called, with the environment
/// in it, until the instance is freed.
pub(super) unsafe fn instantiate<U: Unit>(
    name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resource_location: *const c_char,
    functions: *const CallbackFunctions,
    logging_on: bool,
) -> Component {
    // SAFETY: null or valid, as the caller grants.
    let functions = unsafe { functions.as_ref() };
    if !processor::suffices() {
        // Not through `Importer`, whose code may need what the processor lacks.
        if let Some(functions) = functions
            && let Some(logger) = functions.logger
        {
            let (environment, status) = (functions.component_environment, Status::Error as c_int);
            let (category, text) = (c"logStatusError".as_ptr(), processor::NO_AVX2.as_ptr());
            // SAFETY: the caller grants that the logger can be called.
            unsafe { logger(environment, name, status, category, c"%s".as_ptr(), text) };
        }
        return ptr::null_mut();
    }
    // SAFETY: as the caller grants.
    unsafe { instantiate_here::<U>([name, guid, resource_location], fmu_type, functions, logging_on) }
}

/// [`instantiate`] on a processor that has the instructions that the code is compiled for. Never inlined: none of its code may
/// run before the check.
///
/// # Safety
/// As there.
#[inline(never)]
unsafe fn instantiate_here<U: Unit>(
    texts: [*const c_char; 3],
    fmu_type: c_int,
    functions: Option<&CallbackFunctions>,
    debug: bool,
) -> Component {
    contain(ptr::null_mut(), || {
        // SAFETY: null or valid, as the caller grants.
        let [name, token, location] = texts.map(|pointer| unsafe { text(pointer) });
        let importer = functions.and_then(|functions| {
            Some(Importer {
                logger: functions.logger?,
                environment: functions.component_environment,
                instance: CString::new(name.clone().unwrap_or_default()).unwrap_or_default(),
            })
        });
        let arguments = Arguments {
            function: "fmi2Instantiate",
            name: name.as_deref(),
            token: ("GUID", token.as_deref()),
            expected: guid_with::<U>,
            resources: location.as_deref(),
            debug,
        };
        let master = |_: &mut Vec<String>| match fmu_type {
            CO_SIMULATION => Ok(Master::default()),
            _ => Err("this FMU is for co-simulation only".to_owned()),
        };
        let slave = create::<U>(
            arguments,
            master,
            importer.map(|importer| Box::new(importer) as Box<dyn Sink>),
        );
        slave.map_or(ptr::null_mut(), |slave| {
            instance_created();
            Box::into_raw(Box::new(slave)).cast()
        })
    })
}

/// `fmi2CoSimulation` of the standard's `fmi2Type`.
const CO_SIMULATION: c_int = 1;
