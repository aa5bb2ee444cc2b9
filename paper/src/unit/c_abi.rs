//! The C functions that the shared library exports.

pushbelt_fmi::export_fmi2!(super::rings::PaperUnit);
