//! Stored states as an importer holds them, in both versions: a pointer to a boxed snapshot, and
//! its bytes.
//!
//! A stored state is null, or a `Box<Snapshot<U>>` that [`get`] or [`deserialize`] has released and
//! that has not been freed; the importer grants this ("Getting and Setting the Complete FMU State"
//! in both standards). A state that is read stays as it is: no other call writes to it at the same
//! time.

use libc::c_void;
use std::ptr;

use super::entry::{NULL_RESULT, array, array_mut, result};
use crate::instance::{CallError, FmuInstance, Outcome, Snapshot, refused};
use crate::state::Call;
use crate::unit::Unit;

type Stored = *mut c_void;

/// Stores the state, in a new object if `*state` is null, otherwise in the object that it points
/// to.
///
/// # Safety
/// `state` is null or points to a stored state that no other call uses.
pub(crate) unsafe fn get<U: Unit>(instance: &mut FmuInstance<U>, state: *mut Stored) -> Outcome {
    // SAFETY: the caller grants that it is null or points to a value for this call alone, and that
    // it is initialised: the standard has the importer set it to null.
    let state = unsafe { result(state)?.assume_init_mut() };
    let saved = instance.save()?;
    // SAFETY: it is null or a boxed snapshot, which no other call uses.
    match unsafe { state.cast::<Snapshot<U>>().as_mut() } {
        Some(existing) => *existing = saved,
        None => *state = Box::into_raw(Box::new(saved)).cast(),
    }
    Ok(())
}

/// Goes back to a stored state, which stays as it is.
///
/// # Safety
/// `state` is a stored state.
pub(crate) unsafe fn set<U: Unit>(instance: &mut FmuInstance<U>, state: Stored) -> Outcome {
    // SAFETY: the caller grants that it is a stored state.
    instance.restore(unsafe { snapshot(state) }?)
}

/// Frees a stored state and sets it to null; null is legal.
///
/// # Safety
/// `state` is null or points to a stored state that no other call uses and that exists in no copy.
pub(crate) unsafe fn free<U: Unit>(instance: &mut FmuInstance<U>, state: *mut Stored) -> Outcome {
    instance.allow(Call::Always)?;
    // SAFETY: the caller grants that it is null or points to a value for this call alone.
    if let Some(state) = unsafe { state.as_mut() }
        && !state.is_null()
    {
        let freed = std::mem::replace(state, ptr::null_mut());
        // SAFETY: it is not null, so it is from `Box::into_raw` in `get` or `deserialize`. The
        // caller grants that it has not been freed and that no copy of it is used.
        drop(unsafe { Box::from_raw(freed.cast::<Snapshot<U>>()) });
    }
    Ok(())
}

/// Number of bytes of a stored state.
///
/// # Safety
/// `state` is a stored state. `size` is null or points to a writable number.
pub(crate) unsafe fn size<U: Unit>(
    instance: &mut FmuInstance<U>,
    state: Stored,
    size: *mut usize,
) -> Outcome {
    // SAFETY: the caller grants this of both, and they are no parts of each other.
    let (snapshot, size) = unsafe { (snapshot(state)?, result(size)?) };
    size.write(instance.serialize(snapshot)?.len());
    Ok(())
}

/// Writes a stored state as bytes, as many as [`size`] counts.
///
/// # Safety
/// `state` is a stored state. `bytes` is null or points to `count` writable bytes.
pub(crate) unsafe fn serialize<U: Unit>(
    instance: &mut FmuInstance<U>,
    state: Stored,
    bytes: *mut u8,
    count: usize,
) -> Outcome {
    // SAFETY: the caller grants this of both, and they are no parts of each other.
    let (snapshot, target) = unsafe { (snapshot(state)?, array_mut(bytes, count)?) };
    let bytes = instance.serialize(snapshot)?;
    let (given, needed) = (target.len(), bytes.len());
    match target.get_mut(..needed) {
        Some(target) => drop(target.write_copy_of_slice(&bytes)),
        None => {
            return refused(format!("the state takes {needed} bytes, but only {given} are given"));
        }
    }
    Ok(())
}

/// Makes a stored state from bytes. The previous value of `*state` is not read: it is not freed.
///
/// # Safety
/// `bytes` is null or points to `count` bytes. `state` is null or points to a place for a pointer.
pub(crate) unsafe fn deserialize<U: Unit>(
    instance: &mut FmuInstance<U>,
    bytes: *const u8,
    count: usize,
    state: *mut Stored,
) -> Outcome {
    // SAFETY: the caller grants that it is null or points to so many bytes.
    let bytes = unsafe { array(bytes, count) }?;
    if state.is_null() {
        return refused(NULL_RESULT);
    }
    let snapshot = instance.deserialize(bytes)?;
    // SAFETY: it is not null, and the caller grants that a pointer may be written there. What is
    // there is not read.
    unsafe { state.write(Box::into_raw(Box::new(snapshot)).cast()) };
    Ok(())
}

/// The snapshot of a stored state; an error if that is null.
///
/// # Safety
/// `state` is a stored state that exists for `'a`, and that nobody writes to.
unsafe fn snapshot<'a, U: Unit>(state: Stored) -> Result<&'a Snapshot<U>, CallError> {
    // SAFETY: the caller grants that it is null or a boxed snapshot, which stays as it is.
    let snapshot = unsafe { state.cast::<Snapshot<U>>().as_ref() };
    snapshot.map_or_else(|| refused("the state is null"), Ok)
}
