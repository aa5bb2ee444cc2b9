//! The variant of the library for processors with AVX2, in portable builds.

use crate::fmi::dispatch::Dispatch;
use crate::fmi::{Unit as _, export_variant, fmi2, fmi3};
use crate::unit::VariatorUnit;

/// Chooses the library at the first instance.
pub static DISPATCH: Dispatch = Dispatch::new(
    VariatorUnit::IDENTITY.name,
    option_env!("PUSHBELT_BUILD"),
    &[fmi2::NAMES, fmi3::NAMES, BEYOND_THE_STANDARD],
);

/// Names of the functions of `linear_c`, which asks the dispatcher; a test compares them.
pub const BEYOND_THE_STANDARD: &[&str] = &["pushbeltLinearize", "pushbeltFreeText"];

/// Names of the C functions.
pub const NAMES: &[&str] = &["pushbeltVariant"];

export_variant!(DISPATCH);
