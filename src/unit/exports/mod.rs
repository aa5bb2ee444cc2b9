//! The C functions that the shared library exports, and their list for a linker.

#[forbid(unsafe_code)]
mod linear;
#[allow(unsafe_code, non_snake_case)]
pub mod linear_c;

use crate::fmi::dispatch::Dispatch;
use crate::fmi::{Unit as _, fmi2, fmi3};
use crate::unit::VariatorUnit;

/// Chooses the library at the first instance: in portable builds this one, or its variant for processors with AVX2.
pub static DISPATCH: Dispatch = Dispatch::new(VariatorUnit::IDENTITY.name, option_env!("PUSHBELT_VARIANT"));

/// The C functions of FMI 2.0.
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi {
    crate::fmi::export_fmi2!(crate::unit::VariatorUnit, Some(&super::DISPATCH));
}

/// The C functions of FMI 3.0.
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi3 {
    crate::fmi::export_fmi3!(crate::unit::VariatorUnit, Some(&super::DISPATCH));
}

/// The function by which another library of the FMU opens this one.
#[allow(unsafe_code, non_snake_case)]
pub mod variant {
    crate::fmi::export_variant!();
}

/// The content of `fmu-build/exports.def`.
#[must_use]
pub fn definition() -> String {
    let mut names = [fmi2::NAMES, fmi3::NAMES, linear_c::NAMES, &["pushbeltVariant"]].concat();
    names.sort_unstable();
    let names: String = names.iter().map(|name| format!("    {name}\n")).collect();
    format!(
        "; The names that a shared library of the FMU exports, as a Windows module definition. Written by `cargo fmu describe`. \
         `cargo fmu\n; build` gives it to the linker where that needs it, and refuses a library that exports more or less.\n\
         EXPORTS\n{names}"
    )
}
