//! The C functions that the shared library exports, for the variator.

crate::fmi::export!(super::variator_unit::VariatorUnit);
