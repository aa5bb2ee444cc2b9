//! The variator: parameters, state, residual, outputs, energy balance.

pub mod cell;
pub mod instance;
pub mod layout;
pub mod mesh;
pub mod parameters;
pub mod signals;
pub mod start;
pub mod system;
pub mod validation;
