//! The C functions that the shared library exports, and their list for a linker.

#[allow(unsafe_code, non_snake_case)]
pub mod c_abi;
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi3;
#[forbid(unsafe_code)]
mod linear;
#[allow(unsafe_code, non_snake_case)]
pub mod linear_c;
#[allow(unsafe_code, non_snake_case)]
pub mod variant;

use crate::fmi::{fmi2, fmi3};

/// The content of `fmu-build/exports.def`.
#[must_use]
pub fn definition() -> String {
    let mut names = [fmi2::NAMES, fmi3::NAMES, linear_c::NAMES, variant::NAMES].concat();
    names.sort_unstable();
    let names: String = names.iter().map(|name| format!("    {name}\n")).collect();
    format!(
        "; The names that a shared library of the FMU exports, as a Windows module definition. Written by `cargo fmu describe`. \
         `cargo fmu\n; build` gives it to the linker where that needs it, and refuses a library that exports more or less.\n\
         EXPORTS\n{names}"
    )
}
