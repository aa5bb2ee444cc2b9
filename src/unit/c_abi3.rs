//! The C functions of FMI 3.0 that the shared library exports, for the variator.

crate::fmi::fmi3::exports::export!(super::variator_unit::VariatorUnit);
