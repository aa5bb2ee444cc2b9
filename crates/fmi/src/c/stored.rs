//! Stored states as an importer holds them, in both versions: a pointer to a boxed snapshot, and its bytes.
//!
//! The caller of each function grants what the heads of `fmi2` and `fmi3` list. A stored state is null, or a `Box<Snapshot<U>>`
//! that [`get`] or [`deserialize`] has released and that has not been freed.

use libc::c_void;
use std::ptr;

use super::entry::{NULL_RESULT, array, array_mut, result};
use crate::instance::{CallError, FmuInstance, Outcome, Snapshot, refused};
use crate::state::Call;
use crate::unit::Unit;

/// A stored state.
type Stored = *mut c_void;

/// Stores the state, in a new object if `*state` is null, otherwise in the object that it points to.
pub(crate) unsafe fn get<U: Unit>(instance: &mut FmuInstance<U>, state: *mut Stored) -> Outcome {
    let state = result(state)?;
    let saved = instance.save()?;
    match state.cast::<Snapshot<U>>().as_mut() {
        Some(existing) => *existing = saved,
        None => *state = Box::into_raw(Box::new(saved)).cast(),
    }
    Ok(())
}

/// Goes back to a stored state, which stays as it is.
pub(crate) unsafe fn set<U: Unit>(instance: &mut FmuInstance<U>, state: Stored) -> Outcome {
    instance.restore(snapshot(state)?)
}

/// Frees a stored state and sets it to null; null is legal.
pub(crate) unsafe fn free<U: Unit>(instance: &mut FmuInstance<U>, state: *mut Stored) -> Outcome {
    instance.allow(Call::Always)?;
    if let Some(state) = state.as_mut()
        && !state.is_null()
    {
        let freed = std::mem::replace(state, ptr::null_mut());
        drop(Box::from_raw(freed.cast::<Snapshot<U>>()));
    }
    Ok(())
}

/// Number of bytes of a stored state.
pub(crate) unsafe fn size<U: Unit>(instance: &mut FmuInstance<U>, state: Stored, size: *mut usize) -> Outcome {
    let (snapshot, size) = (snapshot(state)?, result(size)?);
    *size = instance.serialize(snapshot)?.len();
    Ok(())
}

/// Writes a stored state as bytes, as many as [`size`] counts.
pub(crate) unsafe fn serialize<U: Unit>(
    instance: &mut FmuInstance<U>,
    state: Stored,
    bytes: *mut u8,
    count: usize,
) -> Outcome {
    let (snapshot, target) = (snapshot(state)?, array_mut(bytes, count)?);
    let bytes = instance.serialize(snapshot)?;
    let (given, needed) = (target.len(), bytes.len());
    match target.get_mut(..needed) {
        Some(target) => target.copy_from_slice(&bytes),
        None => return refused(format!("the state takes {needed} bytes, but only {given} are given")),
    }
    Ok(())
}

/// Makes a stored state from bytes. The previous value of `*state` is not read: it is not freed.
pub(crate) unsafe fn deserialize<U: Unit>(
    instance: &mut FmuInstance<U>,
    bytes: *const u8,
    count: usize,
    state: *mut Stored,
) -> Outcome {
    let bytes = array(bytes, count)?;
    if state.is_null() {
        return refused(NULL_RESULT);
    }
    let snapshot = instance.deserialize(bytes)?;
    state.write(Box::into_raw(Box::new(snapshot)).cast());
    Ok(())
}

/// The snapshot of a stored state; an error if that is null.
unsafe fn snapshot<'a, U: Unit>(state: Stored) -> Result<&'a Snapshot<U>, CallError> {
    state
        .cast::<Snapshot<U>>()
        .as_ref()
        .map_or_else(|| refused("the state is null"), Ok)
}
