//! The variator: parameters, state, residual, outputs, energy balance.

pub mod instance;
pub mod parameters;
pub mod signals;
pub mod validation;
