//! Reading and writing of variables.

use libc::{c_char, c_int, c_uint, size_t};

use super::boundary::{NULL_ARRAY, array, array_mut, with};
use super::types::Component;
use crate::log::Status;
use crate::state::Call;
use crate::unit::Unit;

/// `fmi2GetReal`: reads reals.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_real<U: Unit>(c: Component, vr: *const c_uint, nvr: size_t, value: *mut f64) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (array(vr, nvr), array_mut(value, nvr)) {
            (Some(references), Some(values)) => slave.get_real(references, values),
            _ => slave.refuse("fmi2GetReal", NULL_ARRAY),
        })
    }
}

/// `fmi2GetInteger`: reads integers and enumerations.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_integer<U: Unit>(c: Component, vr: *const c_uint, nvr: size_t, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (array(vr, nvr), array_mut(value, nvr)) {
            (Some(references), Some(values)) => slave.get_integer(references, values),
            _ => slave.refuse("fmi2GetInteger", NULL_ARRAY),
        })
    }
}

/// `fmi2GetBoolean`: reads Booleans.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_boolean<U: Unit>(c: Component, vr: *const c_uint, nvr: size_t, value: *mut c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (array(vr, nvr), array_mut(value, nvr)) {
            (Some(references), Some(values)) => slave.get_boolean(references, values),
            _ => slave.refuse("fmi2GetBoolean", NULL_ARRAY),
        })
    }
}

/// `fmi2GetString`: reads strings; there are none.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_string<U: Unit>(c: Component, vr: *const c_uint, nvr: size_t, _value: *mut *const c_char) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match array(vr, nvr) {
            Some(references) => slave.no_such_type("fmi2GetString", Call::Get, references, "string"),
            None => slave.refuse("fmi2GetString", NULL_ARRAY),
        })
    }
}

/// `fmi2SetReal`: writes reals.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_real<U: Unit>(c: Component, vr: *const c_uint, nvr: size_t, value: *const f64) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (array(vr, nvr), array(value, nvr)) {
            (Some(references), Some(values)) => slave.set_real(references, values),
            _ => slave.refuse("fmi2SetReal", NULL_ARRAY),
        })
    }
}

/// `fmi2SetInteger`: writes integers and enumerations.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_integer<U: Unit>(c: Component, vr: *const c_uint, nvr: size_t, value: *const c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (array(vr, nvr), array(value, nvr)) {
            (Some(references), Some(values)) => slave.set_integer(references, values),
            _ => slave.refuse("fmi2SetInteger", NULL_ARRAY),
        })
    }
}

/// `fmi2SetBoolean`: writes Booleans.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_boolean<U: Unit>(c: Component, vr: *const c_uint, nvr: size_t, value: *const c_int) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match (array(vr, nvr), array(value, nvr)) {
            (Some(references), Some(values)) => slave.set_boolean(references, values),
            _ => slave.refuse("fmi2SetBoolean", NULL_ARRAY),
        })
    }
}

/// `fmi2SetString`: writes strings; there are none.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_string<U: Unit>(
    c: Component,
    vr: *const c_uint,
    nvr: size_t,
    _value: *const *const c_char,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| match array(vr, nvr) {
            Some(references) => slave.no_such_type("fmi2SetString", Call::Set, references, "string"),
            None => slave.refuse("fmi2SetString", NULL_ARRAY),
        })
    }
}
