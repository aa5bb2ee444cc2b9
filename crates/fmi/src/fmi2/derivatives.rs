//! Derivatives of inputs and outputs with respect to time.

use libc::{c_int, c_uint, size_t};

use super::boundary::{NULL_ARRAY, array, array_mut, with};
use super::types::Component;
use crate::log::Status;
use crate::unit::Unit;

/// `fmi2GetDirectionalDerivative`: not offered.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_directional_derivative<U: Unit>(
    c: Component,
    _unknown: *const c_uint,
    _n_unknown: size_t,
    _known: *const c_uint,
    _n_known: size_t,
    _dv_known: *const f64,
    _dv_unknown: *mut f64,
) -> Status {
    let why = "no output depends directly on an input, so every such derivative would be zero \
               (providesDirectionalDerivative is false)";
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, |slave| slave.not_offered("fmi2GetDirectionalDerivative", why)) }
}

/// `fmi2SetRealInputDerivatives`: lets inputs change in proportion to time during the next step.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn set_real_input_derivatives<U: Unit>(
    c: Component,
    vr: *const c_uint,
    nvr: size_t,
    order: *const c_int,
    value: *const f64,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| {
            match (array(vr, nvr), array(order, nvr), array(value, nvr)) {
                (Some(references), Some(orders), Some(values)) => {
                    slave.set_input_derivatives(references, orders, values)
                }
                _ => slave.refuse("fmi2SetRealInputDerivatives", NULL_ARRAY),
            }
        })
    }
}

/// `fmi2GetRealOutputDerivatives`: time derivatives of outputs.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_real_output_derivatives<U: Unit>(
    c: Component,
    vr: *const c_uint,
    nvr: size_t,
    order: *const c_int,
    value: *mut f64,
) -> Status {
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, |slave| {
            match (array(vr, nvr), array(order, nvr), array_mut(value, nvr)) {
                (Some(references), Some(orders), Some(values)) => {
                    slave.get_output_derivatives(references, orders, values)
                }
                _ => slave.refuse("fmi2GetRealOutputDerivatives", NULL_ARRAY),
            }
        })
    }
}
