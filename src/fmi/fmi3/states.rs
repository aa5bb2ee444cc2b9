//! Stored states of an instance, and their bytes.

use std::ptr;

use libc::size_t;

use super::boundary::{NULL_ARRAY, NULL_RESULT, array, array_mut, with};
use super::types::{FmuState, Instance};
use crate::fmi::log::Status;
use crate::fmi::snapshot::Snapshot;
use crate::fmi::stepping::OwnSteps;

/// `fmi3GetFMUState`: stores the state, in a new object if `*state` is null, otherwise in the object that it points to.
///
/// # Safety
/// `*state` is null or a state from this function that has not been freed.
pub(crate) unsafe fn get_fmu_state<U: OwnSteps>(c: Instance, state: *mut FmuState) -> Status {
    let function = "fmi3GetFMUState";
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>` released below.
    unsafe {
        with::<U>(c, function, |instance| {
            let Some(state) = state.as_mut() else {
                return instance.slave.refuse(function, NULL_RESULT);
            };
            let (status, saved) = instance.slave.save();
            if let Some(saved) = saved {
                match state.cast::<Snapshot<U>>().as_mut() {
                    Some(existing) => *existing = saved,
                    None => *state = Box::into_raw(Box::new(saved)).cast(),
                }
            }
            status
        })
    }
}

/// `fmi3SetFMUState`: goes back to a stored state, which stays as it is.
///
/// # Safety
/// `state` is null or a state from [`get_fmu_state`] that has not been freed.
pub(crate) unsafe fn set_fmu_state<U: OwnSteps>(c: Instance, state: FmuState) -> Status {
    let function = "fmi3SetFMUState";
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`.
    unsafe {
        with::<U>(c, function, |instance| match state.cast::<Snapshot<U>>().as_ref() {
            Some(snapshot) => instance.slave.restore(snapshot),
            None => instance.slave.refuse(function, NULL_STATE),
        })
    }
}

/// `fmi3FreeFMUState`: frees a stored state and sets it to null; null is legal.
///
/// # Safety
/// `*state` is null or a state from [`get_fmu_state`] that has not been freed.
pub(crate) unsafe fn free_fmu_state<U: OwnSteps>(c: Instance, state: *mut FmuState) -> Status {
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`, which the caller gives back.
    unsafe {
        with::<U>(c, "fmi3FreeFMUState", |_| {
            if let Some(state) = state.as_mut()
                && !state.is_null()
            {
                let freed = std::mem::replace(state, ptr::null_mut());
                drop(Box::from_raw(freed.cast::<Snapshot<U>>()));
            }
            Status::Ok
        })
    }
}

const NULL_STATE: &str = "the state is null";

/// `fmi3SerializedFMUStateSize`: number of bytes of a stored state.
///
/// # Safety
/// `state` is null or a state from [`get_fmu_state`] or [`deserialize_fmu_state`] that has not been freed.
pub(crate) unsafe fn serialized_fmu_state_size<U: OwnSteps>(c: Instance, state: FmuState, size: *mut size_t) -> Status {
    let function = "fmi3SerializedFMUStateSize";
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`.
    unsafe {
        with::<U>(c, function, |instance| {
            let slave = &mut instance.slave;
            match (state.cast::<Snapshot<U>>().as_ref(), size.as_mut()) {
                (Some(snapshot), Some(size)) => {
                    let (status, bytes) = slave.serialize(function, snapshot);
                    *size = bytes.map_or(*size, |bytes| bytes.len());
                    status
                }
                (None, _) => slave.refuse(function, NULL_STATE),
                (_, None) => slave.refuse(function, NULL_RESULT),
            }
        })
    }
}

/// `fmi3SerializeFMUState`: writes a stored state as bytes, `size` of them as [`serialized_fmu_state_size`] counts them.
///
/// # Safety
/// As for [`serialized_fmu_state_size`]; `bytes` is null or points to `size` bytes.
pub(crate) unsafe fn serialize_fmu_state<U: OwnSteps>(
    c: Instance,
    state: FmuState,
    bytes: *mut u8,
    size: size_t,
) -> Status {
    let function = "fmi3SerializeFMUState";
    // SAFETY: as the caller grants; a state that is not null is a `Box<Snapshot>`.
    unsafe {
        with::<U>(c, function, |instance| {
            let slave = &mut instance.slave;
            let Some(snapshot) = state.cast::<Snapshot<U>>().as_ref() else {
                return slave.refuse(function, NULL_STATE);
            };
            let Some(target) = array_mut(bytes, size) else {
                return slave.refuse(function, NULL_ARRAY);
            };
            let (status, bytes) = slave.serialize(function, snapshot);
            let Some(bytes) = bytes else { return status };
            match target.get_mut(..bytes.len()) {
                Some(target) => target.copy_from_slice(&bytes),
                None => {
                    let why = format!("the state takes {} bytes, {size} are not enough", bytes.len());
                    return slave.refuse(function, &why);
                }
            }
            status
        })
    }
}

/// `fmi3DeserializeFMUState`: makes a stored state of bytes. What `*state` was before does not matter: it is not freed.
///
/// # Safety
/// `bytes` is null or points to `size` bytes.
pub(crate) unsafe fn deserialize_fmu_state<U: OwnSteps>(
    c: Instance,
    bytes: *const u8,
    size: size_t,
    state: *mut FmuState,
) -> Status {
    let function = "fmi3DeserializeFMUState";
    // SAFETY: as the caller grants; the pointer for the result is written, not read.
    unsafe {
        with::<U>(c, function, |instance| {
            let slave = &mut instance.slave;
            let Some(bytes) = array(bytes, size) else {
                return slave.refuse(function, NULL_ARRAY);
            };
            if state.is_null() {
                return slave.refuse(function, NULL_RESULT);
            }
            let (status, snapshot) = slave.deserialize(bytes);
            if let Some(snapshot) = snapshot {
                state.write(Box::into_raw(Box::new(snapshot)).cast());
            }
            status
        })
    }
}
