//! The variant of the library for processors with AVX2, in portable builds.

use super::{c_abi, c_abi3, linear_c};
use crate::fmi::dispatch::Dispatch;
use crate::fmi::{Unit as _, export_variant};
use crate::unit::VariatorUnit;

/// Chooses the library at the first instance.
pub static DISPATCH: Dispatch = Dispatch::new(
    VariatorUnit::IDENTITY.name,
    option_env!("PUSHBELT_BUILD"),
    &[&c_abi::FORWARDS, &c_abi3::FORWARDS, &linear_c::FORWARDS],
);

/// Names of the C functions.
pub const NAMES: &[&str] = &["pushbeltVariant"];

export_variant!(DISPATCH);
