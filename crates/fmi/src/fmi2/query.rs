//! Calls beyond the standard: queries, whose result is text that the caller frees, and a reset.

use std::ffi::CString;

use libc::c_char;
use std::ptr;

use super::Component;
use crate::c::creation::c_string;
use crate::c::entry::{array, contain, enter, result};
use crate::instance::FmuInstance;
use crate::log::Status;
use crate::unit::{Message, Unit};

/// Makes a query about the unit, and about variables of it, and returns the result as a string of
/// its own. `*text` is null where there is none.
///
/// # Safety
/// The caller grants what [the head of this module](super) lists. The previous value of `*text` is
/// not read.
pub unsafe fn query<U: Unit>(
    c: Component,
    function: &'static str,
    (references, count): (*const u32, usize),
    text: *mut *mut c_char,
    query: impl FnOnce(&mut U, &U::Settings, &[u32], &mut Vec<Message>) -> Result<String, String>,
) -> Status {
    if !text.is_null() {
        // SAFETY: it is not null, and the caller grants that a pointer may be written there.
        unsafe { text.write(ptr::null_mut()) };
    }
    let call = |instance: &mut FmuInstance<U>| {
        // SAFETY: it is null or points to the pointer written above.
        let text = unsafe { result(text) }?;
        // SAFETY: the caller grants that it is null or points to so many numbers.
        let references = unsafe { array(references, count) }?;
        let (status, found) =
            instance.query(|unit, settings, remarks| query(unit, settings, references, remarks))?;
        text.write(c_string(&found).into_raw());
        Ok(status)
    };
    // SAFETY: the caller grants that it is null or an instance that no other call uses.
    unsafe { enter(c, function, call) }
}

/// Resets an instance. The search of the next start may begin at the state that the run before
/// started from.
///
/// # Safety
/// The caller grants what [the head of this module](super) lists.
pub unsafe fn reset_near<U: Unit>(c: Component, function: &'static str) -> Status {
    let call = |instance: &mut FmuInstance<U>| instance.reset_near().map(|()| Status::Ok);
    // SAFETY: the caller grants that it is null or an instance that no other call uses.
    unsafe { enter(c, function, call) }
}

/// Frees a text of [`query`]; null is legal.
///
/// # Safety
/// `text` is null or comes from [`query`] and has not been freed.
pub unsafe fn free_text(text: *mut c_char) {
    contain((), || {
        if !text.is_null() {
            // SAFETY: it is not null, so it is from `CString::into_raw` in `query`, and the caller
            // grants that it has not been freed.
            drop(unsafe { CString::from_raw(text) });
        }
    });
}
