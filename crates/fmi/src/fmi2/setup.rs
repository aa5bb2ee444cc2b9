//! Calls that lead an instance through its run: log, set-up, initialisation, end.

use libc::{c_char, c_int, size_t};

use super::boundary::with;
use super::types::Component;
use crate::c::pointers;
use crate::log::Status;
use crate::slave::Slave;
use crate::unit::{Experiment, Unit};

/// `fmi2SetDebugLogging`: chooses what is logged.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_debug_logging<U: Unit>(
    c: Component,
    logging_on: c_int,
    n_categories: size_t,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match pointers::categories(categories, n_categories) {
            Ok(names) => {
                slave.set_debug_logging(logging_on != 0, &names.iter().map(String::as_str).collect::<Vec<_>>())
            }
            Err(why) => slave.refuse("fmi2SetDebugLogging", why),
        })
    }
}

/// `fmi2SetupExperiment`: sets tolerance, start and stop time.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn setup_experiment<U: Unit>(
    c: Component,
    tolerance_defined: c_int,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> Status {
    let experiment = Experiment::given(
        (tolerance_defined != 0, tolerance),
        start_time,
        (stop_time_defined != 0, stop_time),
    );
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, |slave| slave.setup_experiment(experiment)) }
}

/// `fmi2EnterInitializationMode`: enters initialisation mode.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn enter_initialization_mode<U: Unit>(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, Slave::enter_initialization_mode) }
}

/// `fmi2ExitInitializationMode`: leaves initialisation mode.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn exit_initialization_mode<U: Unit>(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, Slave::exit_initialization_mode) }
}

/// `fmi2Terminate`: ends the run.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn terminate<U: Unit>(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, Slave::terminate) }
}

/// `fmi2Reset`: brings the instance back to where it was instantiated.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn reset<U: Unit>(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, Slave::reset) }
}
