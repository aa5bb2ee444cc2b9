//! The C functions that the shared library exports.
#![allow(unsafe_code, non_snake_case)]

pushbelt_fmi::export_fmi2!(pushbelt_paper::unit::PaperUnit);
