//! What a state shows: losses and energies, the books of energy, outputs.

pub mod ledger;
pub mod observe;
pub mod survey;
