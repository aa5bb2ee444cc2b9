//! C functions in the tests of both versions of FMI: statuses, value references, and the functions of a loaded library.

use std::ffi::c_int;

use pushbelt::fmi::Unit;
use pushbelt::fmi::table::{Causality, Kind};
use pushbelt::unit::VariatorUnit;

pub const OK: c_int = 0;
pub const WARNING: c_int = 1;
pub const DISCARD: c_int = 2;
pub const ERROR: c_int = 3;

/// The exported functions of a table of C functions, each with a list of arguments, a result and a body.
macro_rules! functions {
    (
        $all:ident:
        $(
            $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?
                $(, $use:ident $($instance:ident)?)? $(= $body:expr)? $(=> $c:ident, $call:expr)?;
        )*
    ) => {
        /// The exported functions.
        #[allow(non_snake_case, reason = "names of the standard and of the header")]
        #[derive(Clone, Copy)]
        pub struct $all {
            $(pub $name: unsafe extern "C" fn($($type),*) $(-> $result)?,)*
        }

        impl $all {
            pub(crate) fn of(library: &libloading::Library) -> Self {
                // SAFETY: these are the types with which the library exports them; a status is an `int`.
                unsafe {
                    Self {
                        $($name: *library.get(stringify!($name).as_bytes()).expect(stringify!($name)),)*
                    }
                }
            }
        }
    };
}

pub(crate) use functions;

/// Value reference of a variable.
pub fn reference(name: &str) -> u32 {
    let table = VariatorUnit::table();
    let variable = table.by_name(name).unwrap_or_else(|| panic!("{name} is missing"));
    variable.reference
}

/// Value references of the real variables of a causality that `which` chooses.
pub fn real_references(which: impl Fn(Causality) -> bool) -> Vec<u32> {
    let table = VariatorUnit::table();
    let chosen = table.variables().iter().filter(|v| which(v.causality));
    chosen
        .filter(|v| matches!(v.kind, Kind::Real { .. }))
        .map(|v| v.reference)
        .collect()
}

/// Value references of the real outputs.
pub fn real_outputs() -> Vec<u32> {
    real_references(|causality| causality == Causality::Output)
}
