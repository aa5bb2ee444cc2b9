//! The C functions beyond the standard: the linear model of an instance, the gradient of a steady
//! start, and steady starts in sequence. `resources/pushbelt.h` declares them for C.

use libc::c_char;

use pushbelt::fmi::fmi2::{Component, query};
use pushbelt::fmi::log::Status;
use pushbelt::unit::{VariatorUnit, gradient, linear_model};
use std::ptr::null;

pushbelt::fmi::export_functions! {
    /// The linear model about the state in which an instance is, as JSON; `docs/linear.md`
    /// describes it.
    ///
    /// Allowed in initialisation mode and from then on; the instance does not change. Modes below
    /// `frequency`, Hz, become states. `*json` is set to a string that ends with a zero. Free it by
    /// [`pushbeltFreeText`].
    ///
    /// `fmi2OK`: the point is that of parameters and inputs. `fmi2Warning`: there is a model, but
    /// the belt slips through, or other loads than the specified ones hold the point. `fmi2Error`:
    /// there is no model, and `*json` is null. The reason is logged; the instance can continue in
    /// all three cases.
    ///
    /// # Safety
    /// `c` is null or an instance from `fmi2Instantiate` that has not been freed and that no other
    /// call is using. `json` is null or points to a pointer that may be written.
    pushbeltLinearize(c: Component, frequency: f64, json: *mut *mut c_char) -> Status, on c =
        query::query::<VariatorUnit>(c, "pushbeltLinearize", (null(), 0), json, |unit, settings, _, remarks| {
            linear_model(unit, settings, frequency, remarks)
        });

    /// The derivatives of all real outputs of a steady start with respect to `nvr` real parameters
    /// and inputs, as JSON; `docs/studies.md` describes it.
    ///
    /// Allowed in initialisation mode and until the first step; the instance does not change.
    /// `*json` is set to a string that ends with a zero. Free it by [`pushbeltFreeText`].
    ///
    /// `fmi2Error`: there is no gradient, and `*json` is null. The reason is logged; the instance
    /// can continue.
    ///
    /// # Safety
    /// As [`pushbeltLinearize`]; `vr` is null or points to `nvr` numbers.
    pushbeltGradient(c: Component, vr: *const u32, nvr: usize, json: *mut *mut c_char) -> Status, on c =
        query::query::<VariatorUnit>(c, "pushbeltGradient", (vr, nvr), json, |unit, settings, vr, _| {
            gradient(unit, settings, vr)
        });

    /// Resets an instance as `fmi2Reset`. The next steady start begins at the steady state that the
    /// run before started from, which takes a tenth of the work where they differ by some per cent.
    /// The same state is found, within 1e-5; not near enough, it is sought as without.
    ///
    /// # Safety
    /// As [`pushbeltLinearize`].
    pushbeltResetNear(c: Component) -> Status, on c =
        query::reset_near::<VariatorUnit>(c, "pushbeltResetNear");

    /// Frees a string of [`pushbeltLinearize`] or [`pushbeltGradient`]; null is legal.
    ///
    /// # Safety
    /// `text` is null or comes from one of them and has not been freed.
    pushbeltFreeText(text: *mut c_char) = query::free_text(text);
}
