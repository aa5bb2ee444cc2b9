//! The variator as a unit of the FMI layer: the table that binds the interface's names to its parameters, inputs and
//! outputs, the implementation of the unit, and the exported C functions.

#[cfg(feature = "exports")]
pub mod exports;
#[forbid(unsafe_code)]
mod rings;
#[forbid(unsafe_code)]
mod rows;
#[forbid(unsafe_code)]
mod settings;
#[forbid(unsafe_code)]
mod table;
#[forbid(unsafe_code)]
mod terminals;
#[forbid(unsafe_code)]
mod variator_unit;

pub use rings::{CONTACT_STRAIN, FILM_FORCE, Rings};
pub use rows::Rows;
pub use settings::{Settings, StandardRings};
pub use terminals::{TERMINALS, terminals};
pub use variator_unit::{UnitWith, VariatorUnit, model_description, model_description3};
