//! The C functions beside those of the standard: the linear model of an instance. `resources/pushbelt.h` declares them for C.

use libc::c_char;

use super::linear;
use super::variator_unit::VariatorUnit;
use crate::fmi::fmi2::{Component, answers};
use crate::fmi::log::Status;

/// The linear model about the state in which an instance is, as JSON; `docs/linear.md` describes it.
///
/// Allowed in initialisation mode and from then on; the instance stays as it is. Modes below `frequency`, Hz, become states.
/// `*json` is set to a string that ends with a zero. Free it by [`pushbeltFreeText`].
///
/// `fmi2OK`: the point is the one that parameters and inputs give. `fmi2Warning`: there is a model, but the belt slips through
/// or other loads hold the point than those that are given. `fmi2Error`: there is none, and `*json` is null. The log has
/// the reason; the instance can go on in all three cases.
///
/// # Safety
/// `c` is null or an instance from `fmi2Instantiate` that has not been freed and that no other call is using. `json` is null or
/// points to a pointer that may be written.
#[cfg_attr(not(test), unsafe(no_mangle))]
pub unsafe extern "C" fn pushbeltLinearize(c: Component, frequency: f64, json: *mut *mut c_char) -> Status {
    // SAFETY: the caller grants what the function that is called asks for.
    unsafe {
        answers::ask::<VariatorUnit>(c, "pushbeltLinearize", json, |unit, settings, remarks| {
            linear::model(unit, settings, frequency, remarks)
        })
    }
}

/// Frees a string of [`pushbeltLinearize`]; null is legal.
///
/// # Safety
/// `text` is null or comes from [`pushbeltLinearize`] and has not been freed.
#[cfg_attr(not(test), unsafe(no_mangle))]
pub unsafe extern "C" fn pushbeltFreeText(text: *mut c_char) {
    // SAFETY: the caller grants what the function that is called asks for.
    unsafe { answers::free_text(text) }
}
