//! Evaluation of a state: losses and energies, the energy balance of a run, outputs.

pub mod ledger;
pub mod observe;
pub mod survey;
