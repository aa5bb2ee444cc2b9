//! Text that an instance answers beyond the standard: the caller gets it, and gives it back.

use std::ffi::CString;

use libc::c_char;

use super::boundary::{NULL_RESULT, contain, with};
use super::types::Component;
use crate::log::Status;
use crate::unit::{Remark, Unit};

/// Asks the unit a question and hands out the answer as a string of its own. `*text` is null where there is none.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists. What `*text` was before does not matter.
pub unsafe fn ask<U: Unit>(
    c: Component,
    function: &'static str,
    text: *mut *mut c_char,
    question: impl FnOnce(&mut U, &U::Settings, &mut Vec<Remark>) -> Result<String, String>,
) -> Status {
    // SAFETY: as the caller grants; the pointer for the result is written, not read.
    unsafe {
        if !text.is_null() {
            text.write(std::ptr::null_mut());
        }
        with::<U>(c, |slave| {
            if text.is_null() {
                return slave.refuse(function, NULL_RESULT);
            }
            let (status, answer) = slave.ask(function, question);
            if let Some(answer) = answer {
                match CString::new(answer) {
                    Ok(answer) => text.write(answer.into_raw()),
                    Err(_) => return slave.refuse(function, "the answer has a zero inside"),
                }
            }
            status
        })
    }
}

/// Frees a text of [`ask`]; null is legal.
///
/// # Safety
/// `text` is null or comes from [`ask`] and has not been freed.
pub unsafe fn free_text(text: *mut c_char) {
    contain((), || {
        if !text.is_null() {
            // SAFETY: a `CString` released by `ask`, which the caller gives back.
            drop(unsafe { CString::from_raw(text) });
        }
    });
}
