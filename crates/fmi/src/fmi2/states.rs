//! Stored states of an instance, and their bytes.

use libc::{c_char, size_t};

use super::boundary::with;
use super::types::{Component, FmuState};
use crate::c::stored;
use crate::log::Status;
use crate::unit::Unit;

/// `fmi2GetFMUstate`: stores the state, in a new object if `*state` is null, otherwise in the object that it points to.
///
/// # Safety
/// `*state` is null or a state from this function that has not been freed.
pub unsafe fn get_fmu_state<U: Unit>(c: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, |slave| stored::get(slave, "fmi2GetFMUstate", state)) }
}

/// `fmi2SetFMUstate`: goes back to a stored state, which stays as it is.
///
/// # Safety
/// `state` is null or a state from [`get_fmu_state`] that has not been freed.
pub unsafe fn set_fmu_state<U: Unit>(c: Component, state: FmuState) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, |slave| stored::set(slave, "fmi2SetFMUstate", state)) }
}

/// `fmi2FreeFMUstate`: frees a stored state and sets it to null; null is legal.
///
/// # Safety
/// `*state` is null or a state from [`get_fmu_state`] that has not been freed.
pub unsafe fn free_fmu_state<U: Unit>(c: Component, state: *mut FmuState) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, |_| stored::free::<U>(state)) }
}

/// `fmi2SerializedFMUstateSize`: number of bytes of a stored state.
///
/// # Safety
/// `state` is null or a state from [`get_fmu_state`] or [`deserialize_fmu_state`] that has not been freed.
pub unsafe fn serialized_fmu_state_size<U: Unit>(c: Component, state: FmuState, size: *mut size_t) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| {
            stored::size(slave, "fmi2SerializedFMUstateSize", state, size)
        })
    }
}

/// `fmi2SerializeFMUstate`: writes a stored state as bytes, `size` of them as [`serialized_fmu_state_size`] counts them.
///
/// # Safety
/// As for [`serialized_fmu_state_size`]; `bytes` is null or points to `size` bytes.
pub unsafe fn serialize_fmu_state<U: Unit>(c: Component, state: FmuState, bytes: *mut c_char, size: size_t) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| {
            stored::serialize(slave, "fmi2SerializeFMUstate", state, (bytes.cast(), size))
        })
    }
}

/// `fmi2DeSerializeFMUstate`: makes a stored state of bytes. What `*state` was before does not matter: it is not freed.
///
/// # Safety
/// `bytes` is null or points to `size` bytes.
pub unsafe fn deserialize_fmu_state<U: Unit>(
    c: Component,
    bytes: *const c_char,
    size: size_t,
    state: *mut FmuState,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| {
            stored::deserialize(slave, "fmi2DeSerializeFMUstate", (bytes.cast(), size), state)
        })
    }
}
