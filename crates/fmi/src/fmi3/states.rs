//! Stored states of an instance, and their bytes.

use libc::size_t;

use super::boundary::with;
use super::types::{FmuState, Instance};
use crate::c::stored;
use crate::log::Status;
use crate::stepping::OwnSteps;

/// `fmi3GetFMUState`: stores the state, in a new object if `*state` is null, otherwise in the object that it points to.
///
/// # Safety
/// `*state` is null or a state from this function that has not been freed.
pub unsafe fn get_fmu_state<U: OwnSteps>(c: Instance, state: *mut FmuState) -> Status {
    let function = "fmi3GetFMUState";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            stored::get(&mut instance.slave, function, state)
        })
    }
}

/// `fmi3SetFMUState`: goes back to a stored state, which stays as it is.
///
/// # Safety
/// `state` is null or a state from [`get_fmu_state`] that has not been freed.
pub unsafe fn set_fmu_state<U: OwnSteps>(c: Instance, state: FmuState) -> Status {
    let function = "fmi3SetFMUState";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            stored::set(&mut instance.slave, function, state)
        })
    }
}

/// `fmi3FreeFMUState`: frees a stored state and sets it to null; null is legal.
///
/// # Safety
/// `*state` is null or a state from [`get_fmu_state`] that has not been freed.
pub unsafe fn free_fmu_state<U: OwnSteps>(c: Instance, state: *mut FmuState) -> Status {
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, "fmi3FreeFMUState", |_| stored::free::<U>(state)) }
}

/// `fmi3SerializedFMUStateSize`: number of bytes of a stored state.
///
/// # Safety
/// `state` is null or a state from [`get_fmu_state`] or [`deserialize_fmu_state`] that has not been freed.
pub unsafe fn serialized_fmu_state_size<U: OwnSteps>(c: Instance, state: FmuState, size: *mut size_t) -> Status {
    let function = "fmi3SerializedFMUStateSize";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            stored::size(&mut instance.slave, function, state, size)
        })
    }
}

/// `fmi3SerializeFMUState`: writes a stored state as bytes, `size` of them as [`serialized_fmu_state_size`] counts them.
///
/// # Safety
/// As for [`serialized_fmu_state_size`]; `bytes` is null or points to `size` bytes.
pub unsafe fn serialize_fmu_state<U: OwnSteps>(c: Instance, state: FmuState, bytes: *mut u8, size: size_t) -> Status {
    let function = "fmi3SerializeFMUState";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            stored::serialize(&mut instance.slave, function, state, (bytes, size))
        })
    }
}

/// `fmi3DeserializeFMUState`: makes a stored state of bytes. What `*state` was before does not matter: it is not freed.
///
/// # Safety
/// `bytes` is null or points to `size` bytes.
pub unsafe fn deserialize_fmu_state<U: OwnSteps>(
    c: Instance,
    bytes: *const u8,
    size: size_t,
    state: *mut FmuState,
) -> Status {
    let function = "fmi3DeserializeFMUState";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            stored::deserialize(&mut instance.slave, function, (bytes, size), state)
        })
    }
}
