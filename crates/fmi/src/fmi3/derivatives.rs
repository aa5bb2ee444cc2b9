//! Derivatives with respect to time.

use libc::size_t;

use super::boundary::{NULL_ARRAY, array, array_mut, with_any};
use super::types::{Instance, Reference};
use crate::log::Status;
use crate::stepping::OwnSteps;

/// `fmi3GetOutputDerivatives`: time derivatives of outputs; also in intermediate update mode, of the variables announced for it.
///
/// # Safety
/// The caller grants what [the head of this room](super) lists.
pub unsafe fn get_output_derivatives<U: OwnSteps>(
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
