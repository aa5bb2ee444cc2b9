//! Stored states as an importer holds them, whatever the version: a pointer to a boxed snapshot, and its bytes.
//!
//! The caller of each function grants, beyond what the function itself asks for, what the C functions' own callers do: see the
//! heads of `fmi2` and `fmi3`.

use std::ptr;

use libc::{c_void, size_t};

use super::pointers::{NULL_ARRAY, NULL_RESULT, array, array_mut};
use crate::log::Status;
use crate::slave::Slave;
use crate::snapshot::Snapshot;
use crate::unit::Unit;

/// A stored state: null, or a `Box<Snapshot<U>>` that [`get`] or [`deserialize`] has released.
type Stored = *mut c_void;

const NULL_STATE: &str = "the state is null";

/// Stores the state, in a new object if `*state` is null, otherwise in the object that it points to.
///
/// # Safety
/// `*state` is null or a stored state that has not been freed.
pub(crate) unsafe fn get<U: Unit>(slave: &mut Slave<U>, function: &'static str, state: *mut Stored) -> Status {
    // SAFETY: as the caller grants.
    let Some(state) = (unsafe { state.as_mut() }) else {
        return slave.refuse(function, NULL_RESULT);
    };
    let (status, saved) = slave.save();
    if let Some(saved) = saved {
        // SAFETY: a state that is not null is a `Box<Snapshot>` released below.
        match unsafe { state.cast::<Snapshot<U>>().as_mut() } {
            Some(existing) => *existing = saved,
            None => *state = Box::into_raw(Box::new(saved)).cast(),
        }
    }
    status
}

/// Goes back to a stored state, which stays as it is.
///
/// # Safety
/// `state` is null or a stored state that has not been freed.
pub(crate) unsafe fn set<U: Unit>(slave: &mut Slave<U>, function: &'static str, state: Stored) -> Status {
    // SAFETY: as the caller grants.
    match unsafe { snapshot::<U>(state) } {
        Some(snapshot) => slave.restore(snapshot),
        None => slave.refuse(function, NULL_STATE),
    }
}

/// Frees a stored state and sets it to null; null is legal.
///
/// # Safety
/// `*state` is null or a stored state that has not been freed.
pub(crate) unsafe fn free<U: Unit>(state: *mut Stored) -> Status {
    // SAFETY: as the caller grants.
    if let Some(state) = unsafe { state.as_mut() }
        && !state.is_null()
    {
        let freed = std::mem::replace(state, ptr::null_mut());
        // SAFETY: a `Box<Snapshot>`, which the caller gives back.
        drop(unsafe { Box::from_raw(freed.cast::<Snapshot<U>>()) });
    }
    Status::Ok
}

/// Number of bytes of a stored state.
///
/// # Safety
/// `state` is null or a stored state that has not been freed.
pub(crate) unsafe fn size<U: Unit>(
    slave: &mut Slave<U>,
    function: &'static str,
    state: Stored,
    size: *mut size_t,
) -> Status {
    // SAFETY: as the caller grants.
    let (snapshot, size) = unsafe { (snapshot::<U>(state), size.as_mut()) };
    let Some(snapshot) = snapshot else {
        return slave.refuse(function, NULL_STATE);
    };
    let Some(size) = size else {
        return slave.refuse(function, NULL_RESULT);
    };
    let (status, bytes) = slave.serialize(function, snapshot);
    if let Some(bytes) = bytes {
        *size = bytes.len();
    }
    status
}

/// Writes a stored state as bytes, `size` of them as [`size`] counts them.
///
/// # Safety
/// `state` is null or a stored state that has not been freed; `bytes` is null or points to `size` bytes.
pub(crate) unsafe fn serialize<U: Unit>(
    slave: &mut Slave<U>,
    function: &'static str,
    state: Stored,
    (bytes, size): (*mut u8, size_t),
) -> Status {
    // SAFETY: as the caller grants.
    let (snapshot, target) = unsafe { (snapshot::<U>(state), array_mut(bytes, size)) };
    let Some(snapshot) = snapshot else {
        return slave.refuse(function, NULL_STATE);
    };
    let Some(target) = target else {
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
}

/// Makes a stored state of bytes. What `*state` was before does not matter: it is not freed.
///
/// # Safety
/// `bytes` is null or points to `size` bytes.
pub(crate) unsafe fn deserialize<U: Unit>(
    slave: &mut Slave<U>,
    function: &'static str,
    (bytes, size): (*const u8, size_t),
    state: *mut Stored,
) -> Status {
    // SAFETY: as the caller grants.
    let Some(bytes) = (unsafe { array(bytes, size) }) else {
        return slave.refuse(function, NULL_ARRAY);
    };
    if state.is_null() {
        return slave.refuse(function, NULL_RESULT);
    }
    let (status, snapshot) = slave.deserialize(bytes);
    if let Some(snapshot) = snapshot {
        // SAFETY: the pointer for the result is written, not read.
        unsafe { state.write(Box::into_raw(Box::new(snapshot)).cast()) };
    }
    status
}

/// What a stored state points to.
///
/// # Safety
/// `state` is null or a stored state that is not freed for `'a`.
unsafe fn snapshot<'a, U: Unit>(state: Stored) -> Option<&'a Snapshot<U>> {
    // SAFETY: as the caller grants.
    unsafe { state.cast::<Snapshot<U>>().as_ref() }
}
