//! The variator as a unit of the FMI layer: the table that binds the interface's names to its parameters, inputs and
//! outputs, the implementation of the unit, and the exported C functions.

#[allow(unsafe_code, non_snake_case)]
pub mod c_abi;
#[allow(unsafe_code, non_snake_case)]
pub mod c_abi3;
#[forbid(unsafe_code)]
mod exports;
#[forbid(unsafe_code)]
mod linear;
#[allow(unsafe_code, non_snake_case)]
pub mod linear_c;
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

pub use exports::exports;
pub use settings::Settings;
pub use terminals::{TERMINALS, terminals};
pub use variator_unit::{VariatorUnit, model_description, model_description3};
