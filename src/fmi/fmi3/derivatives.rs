//! Derivatives with respect to time and to inputs, and what depends on what.

use libc::{c_int, size_t};

use super::boundary::{NULL_ARRAY, array, array_mut, with, with_any};
use super::types::{Instance, Reference};
use crate::fmi::log::Status;
use crate::fmi::stepping::OwnSteps;

/// `fmi3GetOutputDerivatives`: time derivatives of outputs; also in intermediate update mode, of the variables announced for it.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub(crate) unsafe fn get_output_derivatives<U: OwnSteps>(
    c: Instance,
    vr: *const Reference,
    nvr: size_t,
    orders: *const i32,
    values: *mut f64,
    n_values: size_t,
) -> Status {
    let function = "fmi3GetOutputDerivatives";
    // SAFETY: as the caller grants.
    unsafe {
        with_any::<U, _>(c, function, Status::Error, |instance| {
            let arrays = (array(vr, nvr), array(orders, nvr), array_mut(values, n_values));
            let (Some(references), Some(orders), Some(values)) = arrays else {
                return instance.slave.refuse(function, NULL_ARRAY);
            };
            if references.len() != values.len() {
                let why = format!("{n_values} values for {nvr} outputs of one value each");
                return instance.slave.refuse(function, &why);
            }
            match instance.not_announced(references) {
                Some(why) => instance.slave.refuse(function, &why),
                None => instance.slave.get_output_derivatives(references, orders, values),
            }
        })
    }
}

const DIRECTIONAL: &str = "no output depends directly on an input, so every such derivative would be zero \
                           (providesDirectionalDerivatives is false)";
const ADJOINT: &str = "no output depends directly on an input, so every such derivative would be zero \
                       (providesAdjointDerivatives is false)";
const DEPENDENCIES: &str = "the model description says what depends on what (providesPerElementDependencies is false)";

/// `fmi3GetDirectionalDerivative`: not offered.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
#[expect(clippy::too_many_arguments, reason = "the standard's")]
pub(crate) unsafe fn get_directional_derivative<U: OwnSteps>(
    c: Instance,
    _unknowns: *const Reference,
    _n_unknowns: size_t,
    _knowns: *const Reference,
    _n_knowns: size_t,
    _seed: *const f64,
    _n_seed: size_t,
    _sensitivity: *mut f64,
    _n_sensitivity: size_t,
) -> Status {
    let function = "fmi3GetDirectionalDerivative";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            instance.slave.not_offered(function, DIRECTIONAL)
        })
    }
}

/// `fmi3GetAdjointDerivative`: not offered.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
#[expect(clippy::too_many_arguments, reason = "the standard's")]
pub(crate) unsafe fn get_adjoint_derivative<U: OwnSteps>(
    c: Instance,
    _unknowns: *const Reference,
    _n_unknowns: size_t,
    _knowns: *const Reference,
    _n_knowns: size_t,
    _seed: *const f64,
    _n_seed: size_t,
    _sensitivity: *mut f64,
    _n_sensitivity: size_t,
) -> Status {
    let function = "fmi3GetAdjointDerivative";
    // SAFETY: as the caller grants.
    unsafe { with::<U>(c, function, |instance| instance.slave.not_offered(function, ADJOINT)) }
}

/// `fmi3GetNumberOfVariableDependencies`: not offered.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub(crate) unsafe fn get_number_of_variable_dependencies<U: OwnSteps>(
    c: Instance,
    _vr: Reference,
    _n_dependencies: *mut size_t,
) -> Status {
    let function = "fmi3GetNumberOfVariableDependencies";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            instance.slave.not_offered(function, DEPENDENCIES)
        })
    }
}

/// `fmi3GetVariableDependencies`: not offered.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub(crate) unsafe fn get_variable_dependencies<U: OwnSteps>(
    c: Instance,
    _dependent: Reference,
    _element_indices_of_dependent: *mut size_t,
    _independents: *mut Reference,
    _element_indices_of_independents: *mut size_t,
    _dependency_kinds: *mut c_int,
    _n_dependencies: size_t,
) -> Status {
    let function = "fmi3GetVariableDependencies";
    // SAFETY: as the caller grants.
    unsafe {
        with::<U>(c, function, |instance| {
            instance.slave.not_offered(function, DEPENDENCIES)
        })
    }
}
