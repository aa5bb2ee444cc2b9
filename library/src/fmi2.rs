//! The C functions of FMI 2.0.

pushbelt::fmi::export_fmi2!(pushbelt::unit::VariatorUnit, Some(&crate::variant::DISPATCH));
