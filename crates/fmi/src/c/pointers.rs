//! What comes from C becomes references, slices and strings, and a panic becomes an answer.

use std::ffi::CStr;
use std::panic::{AssertUnwindSafe, catch_unwind};

use libc::{c_char, size_t};

/// Runs `body` and answers a panic with `instead`.
pub(crate) fn contain<T>(instead: T, body: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(body)).unwrap_or(instead)
}

fn is_usable<T>(pointer: *const T, count: size_t) -> bool {
    !pointer.is_null()
        && pointer.is_aligned()
        && count
            .checked_mul(size_of::<T>())
            .is_some_and(|bytes| isize::try_from(bytes).is_ok())
}

/// An array argument; `None` if it is null though it should have elements.
///
/// # Safety
/// `pointer` is null or points to `count` elements that stay untouched for `'a`.
pub(crate) unsafe fn array<'a, T>(pointer: *const T, count: size_t) -> Option<&'a [T]> {
    if count == 0 {
        return Some(&[]);
    }
    // SAFETY: not null, aligned, not longer than an allocation can be; the caller vouches for the elements.
    is_usable(pointer, count).then(|| unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array for results; `None` if it is null though it should have elements.
///
/// # Safety
/// `pointer` is null or points to `count` elements, writable and not otherwise used for `'a`. They are plain numbers
/// that hold some value or other.
pub(crate) unsafe fn array_mut<'a, T>(pointer: *mut T, count: size_t) -> Option<&'a mut [T]> {
    if count == 0 {
        return Some(&mut []);
    }
    // SAFETY: not null, aligned, not longer than an allocation can be; the caller vouches for the elements.
    is_usable(pointer, count).then(|| unsafe { std::slice::from_raw_parts_mut(pointer, count) })
}

/// A string argument, with what is not UTF-8 replaced.
///
/// # Safety
/// `pointer` is null or points to a string that ends with a zero.
pub(crate) unsafe fn text(pointer: *const c_char) -> Option<String> {
    // SAFETY: not null; the caller vouches for the zero at the end.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned())
}

/// Names of log categories, or why they can't be used.
///
/// # Safety
/// `pointer` is null or points to `count` strings, each null or ended by a zero.
pub(crate) unsafe fn categories(pointer: *const *const c_char, count: size_t) -> Result<Vec<String>, &'static str> {
    // SAFETY: as the caller grants.
    let names = unsafe { array(pointer, count) }.ok_or(NULL_ARRAY)?;
    // SAFETY: as above.
    let names = names.iter().map(|name| unsafe { text(*name) });
    names.collect::<Option<_>>().ok_or("a category is null")
}

/// Error text where an array argument cannot be used.
pub(crate) const NULL_ARRAY: &str = "an array argument is null, misaligned or too long";
/// Error text where a result has no place.
pub(crate) const NULL_RESULT: &str = "the pointer for the result is null";
