//! Steady states, solved for directly.

pub(crate) mod equilibrium;
pub(crate) mod refine;
pub mod solve;
pub mod start;
mod tuning;
