//! Calls that lead an instance through its run: log, initialisation, event mode, end.

use libc::size_t;

use super::boundary::{NULL_RESULT, with};
use super::types::{Boolean, Instance, Text};
use crate::c::pointers;
use crate::log::Status;
use crate::stepping::OwnSteps;
use crate::unit::Experiment;

/// `fmi3SetDebugLogging`: chooses what is logged.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_debug_logging<U: OwnSteps>(
    c: Instance,
    logging_on: Boolean,
    n_categories: size_t,
    categories: *const Text,
) -> Status {
    let function = "fmi3SetDebugLogging";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            match pointers::categories(categories, n_categories) {
                Ok(names) => instance
                    .slave
                    .set_debug_logging(logging_on != 0, &names.iter().map(String::as_str).collect::<Vec<_>>()),
                Err(why) => instance.slave.refuse(function, why),
            }
        })
    }
}

/// `fmi3EnterInitializationMode`: sets tolerance, start and stop time, and enters initialisation mode.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn enter_initialization_mode<U: OwnSteps>(
    c: Instance,
    tolerance_defined: Boolean,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: Boolean,
    stop_time: f64,
) -> Status {
    let experiment = Experiment::given(
        (tolerance_defined != 0, tolerance),
        start_time,
        (stop_time_defined != 0, stop_time),
    );
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, "fmi3EnterInitializationMode", |instance| {
            instance.slave.initialize(experiment)
        })
    }
}

/// `fmi3ExitInitializationMode`: leaves initialisation mode, for event mode if the master handles events.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn exit_initialization_mode<U: OwnSteps>(c: Instance) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, "fmi3ExitInitializationMode", |instance| {
            instance.slave.exit_initialization_mode()
        })
    }
}

/// `fmi3EnterEventMode`: enters event mode.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn enter_event_mode<U: OwnSteps>(c: Instance) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, "fmi3EnterEventMode", |instance| instance.slave.enter_event_mode()) }
}

/// `fmi3EnterStepMode`: leaves event mode.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn enter_step_mode<U: OwnSteps>(c: Instance) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, "fmi3EnterStepMode", |instance| instance.slave.enter_step_mode()) }
}

/// `fmi3UpdateDiscreteStates`: nothing needs an update, and no event is known ahead.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn update_discrete_states<U: OwnSteps>(
    c: Instance,
    discrete_states_need_update: *mut Boolean,
    terminate_simulation: *mut Boolean,
    nominals_changed: *mut Boolean,
    values_changed: *mut Boolean,
    next_event_time_defined: *mut Boolean,
    next_event_time: *mut f64,
) -> Status {
    let function = "fmi3UpdateDiscreteStates";
    let flags = [
        discrete_states_need_update,
        terminate_simulation,
        nominals_changed,
        values_changed,
        next_event_time_defined,
    ];
    // SAFETY: as the caller grants; each place is checked before it is written.
    unsafe {
        with::<U>(c, function, |instance| {
            if flags.iter().any(|flag| flag.is_null()) || next_event_time.is_null() {
                return instance.slave.refuse(function, NULL_RESULT);
            }
            let status = instance.slave.update_discrete_states();
            if status == Status::Ok {
                for flag in flags {
                    flag.write(0);
                }
                next_event_time.write(0.0);
            }
            status
        })
    }
}

/// `fmi3Terminate`: ends the run.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn terminate<U: OwnSteps>(c: Instance) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, "fmi3Terminate", |instance| instance.slave.terminate()) }
}

/// `fmi3Reset`: brings the instance back to where it was instantiated.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn reset<U: OwnSteps>(c: Instance) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, "fmi3Reset", |instance| instance.slave.reset()) }
}
