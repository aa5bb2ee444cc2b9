//! A pushbelt variator from maps: `PushbeltMap.fmu`, level 0. Its tables come from the detailed model, with which it shares
//! variables, inputs and the laws of pulleys.
//!
//! | module | content |
//! |---|---|
//! | [`cubic`] | monotone cubic interpolation, to refine a table |
//! | [`mod@file`] | the file of the tables: read from JSON, checked, refined |
//! | [`tables`] | the tables, evaluated |
//! | [`settings`] | what it has of the detailed unit's variables |
//! | [`law`] | torques, losses and shift rate of a state |
//! | [`stage`] | one implicit stage |
//! | `tuning` | numbers of steps, iterations and places |
//! | [`mod@unit`] | the FMU: start, steps, outputs, stored states |
#![warn(missing_docs)]

#[forbid(unsafe_code)]
pub mod cubic;
#[forbid(unsafe_code)]
pub mod file;
#[forbid(unsafe_code)]
pub mod law;
#[forbid(unsafe_code)]
pub mod settings;
#[forbid(unsafe_code)]
pub mod stage;
#[forbid(unsafe_code)]
pub mod tables;
#[forbid(unsafe_code)]
mod tuning;
#[forbid(unsafe_code)]
pub mod unit;

pushbelt_fmi::export!(crate::unit::MapUnit);
