//! A pushbelt variator from maps: `PushbeltMap.fmu`, level 0. Its tables come from the detailed
//! model, with which it shares variables, inputs and the laws of pulleys.
//!
//! | module | content |
//! |---|---|
//! | `cubic` | monotone cubic interpolation, to refine a table |
//! | `file` | the file of the tables: read from JSON, checked, refined |
//! | `tables` | the tables, evaluated |
//! | `settings` | what it has of the detailed unit's variables |
//! | `law`, `stage` | torques, losses and shift rate of a state; one implicit stage |
//! | `start`, [`mod@unit`] | the state at the start; the FMU: steps, outputs, stored states |
//! | `tuning` | numbers of steps, iterations and places |
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
