//! The shared library in `PushbeltVariator.fmu`: its C functions, and their list for a linker.
#![allow(unsafe_code, non_snake_case, reason = "C functions")]

pub mod extensions;

use pushbelt::fmi::{fmi2 as v2, fmi3 as v3};

pushbelt::fmi::export!(pushbelt::unit::VariatorUnit);

/// The content of `fmu-build/exports.def`.
#[must_use]
pub fn definition() -> String {
    let mut names = [v2::NAMES, v3::NAMES, extensions::NAMES, &["pushbeltVariant"]].concat();
    names.sort_unstable();
    let names: String = names.iter().map(|name| format!("    {name}\n")).collect();
    format!(
        "; The names that a shared library of the FMU exports, as a Windows module definition. Written by \
         `cargo fmu describe`. `cargo fmu\n; build` gives it to the linker where that needs it, and refuses a \
         library that exports more or less.\n\
         EXPORTS\n{names}"
    )
}
