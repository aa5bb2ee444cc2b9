//! Evaluation of a state: losses and energies, the energy balance of a run, outputs.

pub mod belt;
pub(crate) mod energy_balance;
mod idle_arc;
pub mod observe;
