//! The variant of the library for processors with AVX2, in portable builds.

use pushbelt::fmi::dispatch::Dispatch;
use pushbelt::fmi::{Unit as _, export_variant};
use pushbelt::unit::VariatorUnit;

/// Chooses the library at the first instance.
pub static DISPATCH: Dispatch = Dispatch::new(VariatorUnit::IDENTITY.name, option_env!("PUSHBELT_VARIANT"));

/// Names of the C functions.
pub const NAMES: &[&str] = &["pushbeltVariant"];

export_variant!();
