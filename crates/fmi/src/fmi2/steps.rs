//! Communication steps, and how the last one ended.

use libc::{c_char, c_int};

use super::boundary::{NULL_RESULT, with};
use super::types::Component;
use crate::log::Status;
use crate::slave::{Slave, StatusKind};
use crate::unit::Unit;

/// `fmi2DoStep`: advances by one communication step. Whether the master will come back before this point does not matter here:
/// states are stored on request only.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn do_step<U: Unit>(
    c: Component,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: c_int,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| {
            slave.do_step(current_communication_point, communication_step_size)
        })
    }
}

/// `fmi2CancelStep`: refused: no step is ever pending.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn cancel_step<U: Unit>(c: Component) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, Slave::cancel_step) }
}

fn status_kind(kind: c_int) -> Option<StatusKind> {
    match kind {
        0 => Some(StatusKind::DoStep),
        1 => Some(StatusKind::Pending),
        2 => Some(StatusKind::LastSuccessfulTime),
        3 => Some(StatusKind::Terminated),
        _ => None,
    }
}

const UNKNOWN_KIND: &str = "the kind of status is not one of the standard's";

/// `fmi2GetStatus`: how the last step ended.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_status<U: Unit>(c: Component, kind: c_int, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (status_kind(kind), value.as_mut()) {
            (Some(kind), Some(value)) => slave.step_status(kind, value),
            (None, _) => slave.refuse("fmi2GetStatus", UNKNOWN_KIND),
            (_, None) => slave.refuse("fmi2GetStatus", NULL_RESULT),
        })
    }
}

/// `fmi2GetRealStatus`: the last successful time.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_real_status<U: Unit>(c: Component, kind: c_int, value: *mut f64) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (status_kind(kind), value.as_mut()) {
            (Some(kind), Some(value)) => slave.real_status(kind, value),
            (None, _) => slave.refuse("fmi2GetRealStatus", UNKNOWN_KIND),
            (_, None) => slave.refuse("fmi2GetRealStatus", NULL_RESULT),
        })
    }
}

/// `fmi2GetIntegerStatus`: nothing can be asked as an integer.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_integer_status<U: Unit>(c: Component, kind: c_int, _value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match status_kind(kind) {
            Some(kind) => slave.no_status("fmi2GetIntegerStatus", kind),
            None => slave.refuse("fmi2GetIntegerStatus", UNKNOWN_KIND),
        })
    }
}

/// `fmi2GetBooleanStatus`: whether the slave wants the run to end.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_boolean_status<U: Unit>(c: Component, kind: c_int, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (status_kind(kind), value.as_mut()) {
            (Some(kind), Some(value)) => slave.boolean_status(kind, value),
            (None, _) => slave.refuse("fmi2GetBooleanStatus", UNKNOWN_KIND),
            (_, None) => slave.refuse("fmi2GetBooleanStatus", NULL_RESULT),
        })
    }
}

/// `fmi2GetStringStatus`: nothing can be asked as a string.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_string_status<U: Unit>(c: Component, kind: c_int, _value: *mut *const c_char) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match status_kind(kind) {
            Some(kind) => slave.no_status("fmi2GetStringStatus", kind),
            None => slave.refuse("fmi2GetStringStatus", UNKNOWN_KIND),
        })
    }
}
