//! A pushbelt variator from maps: `PushbeltMap.fmu`, level 0. Its tables come from the detailed
//! model, with which it shares variables, inputs and the laws of pulleys.
#![warn(missing_docs)]
#![deny(unsafe_code)]

mod cubic;
mod file;
mod law;
mod settings;
mod stage;
mod start;
mod tables;
#[cfg(test)]
mod tests;
mod tuning;
pub mod unit;

pushbelt_fmi::export!(crate::unit::MapUnit);
