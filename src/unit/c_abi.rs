//! The C functions that the shared library exports, for the variator.

pushbelt_fmi::export_fmi2!(super::variator_unit::VariatorUnit);
