//! The variator: parameters, state, residual, outputs, energy balance.

pub mod parameters;
pub mod signals;
