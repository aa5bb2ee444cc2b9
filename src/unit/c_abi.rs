//! The C functions that the shared library exports, for the variator.

crate::fmi2::export!(super::VariatorUnit);
