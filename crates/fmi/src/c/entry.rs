//! The entry of every C function on an instance, and the conversion of its pointers to slices,
//! references and strings.

use libc::{c_char, c_void};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::NonNull;

use super::floating_point;
use crate::instance::{CallError, FmuInstance, Outcome, refused};
use crate::log::Status;
use crate::unit::Unit;

pub(crate) const NULL_RESULT: &str = "the pointer for the result is null";

/// Runs `body` in the default floating-point environment, and returns `instead` after a panic.
/// Every C function that computes does so here.
pub(crate) fn contain<T>(instead: T, body: impl FnOnce() -> T) -> T {
    floating_point::in_default(|| catch_unwind(AssertUnwindSafe(body)).unwrap_or(instead))
}

/// Makes the call of a C function on an instance; the entry of every C function. Without an
/// instance the status is an error.
///
/// # Safety
/// `instance` is null or a `Box<FmuInstance<U>>` released by an `instantiate` function, and no
/// other call is using it.
pub(crate) unsafe fn enter<U: Unit, T: Into<Status>>(
    instance: *mut c_void,
    function: &str,
    body: impl FnOnce(&mut FmuInstance<U>) -> Result<T, CallError>,
) -> Status {
    let mut body = Some(body);
    let mut call = |instance: &mut FmuInstance<U>| match body.take() {
        Some(body) => body(instance).map(Into::into),
        None => Ok(Status::Error),
    };
    // SAFETY: the caller grants the same.
    unsafe { make(instance, function, &mut call) }
}

/// [`enter`] for any call: compiled once, not for each of a hundred functions.
///
/// # Safety
/// As for [`enter`].
#[inline(never)]
unsafe fn make<U: Unit>(
    instance: *mut c_void,
    function: &str,
    body: &mut dyn FnMut(&mut FmuInstance<U>) -> Result<Status, CallError>,
) -> Status {
    contain(Status::Error, || {
        // SAFETY: the caller grants that it is null or an instance that no other call uses, so this
        // reference is the only one. It ends with this call.
        let instance = unsafe { instance.cast::<FmuInstance<U>>().as_mut() };
        instance.map_or(Status::Error, |instance| instance.call(function, body))
    })
}

/// Why functions of model exchange and scheduled execution are refused.
pub(crate) const CO_SIMULATION_ONLY: &str = "this FMU is for co-simulation only";

/// The refusal of a function that the capability flags exclude.
pub(crate) fn unsupported(why: &str) -> Outcome {
    refused(format!("not supported: {why}"))
}

/// The refusal of derivatives, by the name of their capability flag.
pub(crate) fn no_direct_derivatives(flag: &str) -> Outcome {
    unsupported(&format!(
        "no output depends directly on an input, so every such derivative would be zero ({flag} is false)"
    ))
}

pub(crate) fn co_simulation_only<T>(_: &mut T) -> Outcome {
    unsupported(CO_SIMULATION_ONLY)
}

/// Chooses the logged categories.
///
/// # Safety
/// `categories` is null or points to `count` strings, each of which is null or ends with a zero.
pub(crate) unsafe fn set_debug_logging<U: Unit>(
    instance: &mut FmuInstance<U>,
    on: bool,
    categories: *const *const c_char,
    count: usize,
) -> Outcome {
    // SAFETY: the caller grants that it is null or points to so many strings.
    let categories = unsafe { array(categories, count) }?;
    // SAFETY: it is one of the strings, for which the caller grants this.
    instance.set_debug_logging(on, categories.iter().map(|category| unsafe { text(*category) }))
}

/// The address of as many elements; an error if they can't be there: null, misaligned, longer than
/// an allocation can be.
fn usable<T>(pointer: *mut T, count: usize) -> Result<*mut T, CallError> {
    let size = count.checked_mul(size_of::<T>());
    let fits = size.is_some_and(|bytes| isize::try_from(bytes).is_ok());
    match count {
        0 => Ok(NonNull::dangling().as_ptr()),
        _ if fits && !pointer.is_null() && pointer.is_aligned() => Ok(pointer),
        _ => refused("an array argument is null, misaligned or too long"),
    }
}

/// An array argument; an error if it is null though it should have elements.
///
/// # Safety
/// `pointer` is null, or points to `count` initialised elements in one allocation that nobody
/// writes to for `'a`.
///
/// # Errors
/// It is null, misaligned or too long.
pub(crate) unsafe fn array<'a, T>(pointer: *const T, count: usize) -> Result<&'a [T], CallError> {
    let pointer = usable(pointer.cast_mut(), count)?;
    // SAFETY: `usable` has checked that it is aligned, not null, and not longer than an allocation
    // can be; without elements it dangles. The caller grants that the elements are there and stay
    // as they are.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array for results; an error if it is null though it should have elements.
///
/// # Safety
/// `pointer` is null, or points to `count` elements in one allocation, writable and not otherwise
/// used for `'a`.
pub(crate) unsafe fn array_mut<'a, T>(
    pointer: *mut T,
    count: usize,
) -> Result<&'a mut [MaybeUninit<T>], CallError> {
    let pointer = usable(pointer, count)?.cast();
    // SAFETY: as in `array`. The caller grants that nobody else uses the elements. They need not be
    // initialised.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// The place of a result; an error if it is null.
///
/// # Safety
/// `pointer` is null, or is aligned and points to a writable value that is not otherwise used for
/// `'a`.
pub(crate) unsafe fn result<'a, T>(pointer: *mut T) -> Result<&'a mut MaybeUninit<T>, CallError> {
    // SAFETY: the caller grants that it is null or such a value. It need not be initialised.
    unsafe { pointer.cast::<MaybeUninit<T>>().as_mut() }.map_or_else(|| refused(NULL_RESULT), Ok)
}

/// The longest text that a host passes, bytes. A path has some thousand, a URI of it three times as
/// many.
const LONGEST_TEXT: usize = 1 << 20;

/// A string argument, if it is not too long, with what is not UTF-8 replaced; `None` if it is null.
///
/// # Safety
/// `pointer` is null or points to a string that ends with a zero.
pub(crate) unsafe fn text(pointer: *const c_char) -> Result<Option<String>, CallError> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: it is not null, and the caller grants a zero at the end, beyond which `strnlen` reads
    // nothing.
    let length = unsafe { libc::strnlen(pointer, LONGEST_TEXT + 1) };
    if length > LONGEST_TEXT {
        return refused(format!("a text has more than {LONGEST_TEXT} bytes"));
    }
    // SAFETY: `strnlen` has read so many bytes, which are initialised and belong to the string.
    // They are copied at once.
    let bytes = unsafe { std::slice::from_raw_parts(pointer.cast::<u8>(), length) };
    Ok(Some(String::from_utf8_lossy(bytes).into_owned()))
}
