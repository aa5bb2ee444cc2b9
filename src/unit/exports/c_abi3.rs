//! The C functions of FMI 3.0 that the shared library exports, for the variator.

crate::fmi::export_fmi3!(crate::unit::VariatorUnit, Some(&super::variant::DISPATCH));
