//! Steady states, solved for directly.

pub mod equilibrium;
pub(crate) mod refine;
pub mod solve;
pub mod start;
