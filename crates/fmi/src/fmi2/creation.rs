//! Creation of an instance.

use libc::{c_char, c_int};
use std::ptr;

use super::types::{CallbackFunctions, Component};
use crate::c::creation::{Messages, create};
use crate::log::Status;
use crate::processor;
use crate::slave::{Master, Version};
use crate::unit::Unit;

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
        // Not through `Messages`, whose code may need what the processor lacks.
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
    let messages = |instance| {
        let functions = functions?;
        Some(Messages::Two {
            logger: functions.logger?,
            environment: functions.component_environment,
            instance,
        })
    };
    let master = |_: &mut Vec<String>| match fmu_type {
        CO_SIMULATION => Ok(Master::default()),
        _ => Err("this FMU is for co-simulation only".to_owned()),
    };
    // SAFETY: as the caller grants.
    unsafe { create::<U>(Version::Two, texts, debug, messages, master) }
}

/// `fmi2CoSimulation` of the standard's `fmi2Type`.
const CO_SIMULATION: c_int = 1;
