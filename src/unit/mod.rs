//! The variator as a unit of the FMI layer: the table that binds the interface's names to its parameters, inputs and
//! outputs, the implementation of the unit, and the exported C functions.

#[cfg(feature = "exports")]
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi;
#[cfg(feature = "exports")]
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi3;
#[cfg(feature = "exports")]
#[forbid(unsafe_code)]
mod exports;
#[cfg(feature = "exports")]
#[forbid(unsafe_code)]
mod linear;
#[cfg(feature = "exports")]
#[allow(unsafe_code, non_snake_case)]
pub mod linear_c;
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
mod types;
#[forbid(unsafe_code)]
mod variator_unit;

#[cfg(feature = "exports")]
pub use exports::exports;
pub use rings::{CONTACT_STRAIN, Rings};
pub use rows::Rows;
pub use settings::{Settings, StandardRings};
pub use terminals::{TERMINALS, terminals};
pub use variator_unit::{UnitWith, VariatorUnit, model_description, model_description3};
