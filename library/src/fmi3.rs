//! The C functions of FMI 3.0.

pushbelt::fmi::export_fmi3!(pushbelt::unit::VariatorUnit, Some(&crate::variant::DISPATCH));
