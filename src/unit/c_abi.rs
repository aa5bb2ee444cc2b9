//! The C functions that the shared library exports, for the variator.

crate::fmi::export_fmi2!(super::variator_unit::VariatorUnit);
