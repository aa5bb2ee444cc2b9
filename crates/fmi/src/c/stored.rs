//! Stored states as an importer holds them, in both versions: a pointer to a boxed snapshot, and its bytes.
//!
//! The caller of each function grants what the heads of `fmi2` and `fmi3` list. A stored state is null, or a `Box<Snapshot<U>>`
//! that [`get`] or [`deserialize`] has released and that has not been freed.

use libc::c_void;
use std::ptr;

use super::entry::{NULL_RESULT, array, array_mut, enter, result};
use crate::log::Status;
use crate::slave::{CallError, Slave, refused};
use crate::snapshot::Snapshot;
use crate::state::Call;
use crate::unit::Unit;

/// A stored state.
type Stored = *mut c_void;

/// Stores the state, in a new object if `*state` is null, otherwise in the object that it points to.
pub(crate) unsafe fn get<U: Unit>(instance: *mut c_void, function: &str, state: *mut Stored) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        enter(instance, function, |slave: &mut Slave<U>| {
            let state = result(state)?;
            let saved = slave.save()?;
            match state.cast::<Snapshot<U>>().as_mut() {
                Some(existing) => *existing = saved,
                None => *state = Box::into_raw(Box::new(saved)).cast(),
            }
            Ok(())
        })
    }
}

/// Goes back to a stored state, which stays as it is.
pub(crate) unsafe fn set<U: Unit>(instance: *mut c_void, function: &str, state: Stored) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        enter(instance, function, |slave: &mut Slave<U>| {
            slave.restore(snapshot(state)?)
        })
    }
}

/// Frees a stored state and sets it to null; null is legal.
pub(crate) unsafe fn free<U: Unit>(instance: *mut c_void, function: &str, state: *mut Stored) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        enter(instance, function, |slave: &mut Slave<U>| {
            slave.allow(Call::Always)?;
            if let Some(state) = state.as_mut()
                && !state.is_null()
            {
                let freed = std::mem::replace(state, ptr::null_mut());
                drop(Box::from_raw(freed.cast::<Snapshot<U>>()));
            }
            Ok(())
        })
    }
}

/// Number of bytes of a stored state.
pub(crate) unsafe fn size<U: Unit>(instance: *mut c_void, function: &str, state: Stored, size: *mut usize) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        enter(instance, function, |slave: &mut Slave<U>| {
            let (snapshot, size) = (snapshot(state)?, result(size)?);
            *size = slave.serialize(snapshot)?.len();
            Ok(())
        })
    }
}

/// Writes a stored state as bytes, as many as [`size`] counts.
pub(crate) unsafe fn serialize<U: Unit>(
    instance: *mut c_void,
    function: &str,
    state: Stored,
    (bytes, size): (*mut u8, usize),
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        enter(instance, function, |slave: &mut Slave<U>| {
            let (snapshot, target) = (snapshot(state)?, array_mut((bytes, size))?);
            let bytes = slave.serialize(snapshot)?;
            match target.get_mut(..bytes.len()) {
                Some(target) => target.copy_from_slice(&bytes),
                None => {
                    return refused(format!(
                        "the state takes {} bytes, but only {size} are given",
                        bytes.len()
                    ));
                }
            }
            Ok(())
        })
    }
}

/// Makes a stored state from bytes. The previous value of `*state` is not read: it is not freed.
pub(crate) unsafe fn deserialize<U: Unit>(
    instance: *mut c_void,
    function: &str,
    bytes: (*const u8, usize),
    state: *mut Stored,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        enter(instance, function, |slave: &mut Slave<U>| {
            let bytes = array(bytes)?;
            if state.is_null() {
                return refused(NULL_RESULT);
            }
            let snapshot = slave.deserialize(bytes)?;
            state.write(Box::into_raw(Box::new(snapshot)).cast());
            Ok(())
        })
    }
}

/// The snapshot of a stored state; an error if that is null.
unsafe fn snapshot<'a, U: Unit>(state: Stored) -> Result<&'a Snapshot<U>, CallError> {
    // SAFETY: as the caller grants.
    match unsafe { state.cast::<Snapshot<U>>().as_ref() } {
        Some(snapshot) => Ok(snapshot),
        None => refused("the state is null"),
    }
}
