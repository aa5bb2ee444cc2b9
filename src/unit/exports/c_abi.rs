//! The C functions that the shared library exports, for the variator.

crate::fmi::export_fmi2!(crate::unit::VariatorUnit, Some(&super::variant::DISPATCH));
