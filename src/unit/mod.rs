//! The variator as a unit of the FMI layer, with its table of variables. The package `library`
//! exports its C functions.

mod gradient;
mod linear;
mod rings;
mod table;
mod terminals;
mod variator_unit;

pub use gradient::gradient;
pub use linear::linear_model;
pub use rings::{REMOVED, Rings, Settings, StandardRings, parameter};
pub use table::{AT_REST, shared_variables};
pub use terminals::{TERMINALS, terminals};
pub use variator_unit::{UnitWith, VariatorUnit, model_description};
