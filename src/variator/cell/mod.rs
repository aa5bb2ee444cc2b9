//! One cell of the belt: the coupling of ring, push elements and sheaves.

pub(crate) mod balance;
pub(crate) mod laws;
pub mod sample;
pub(crate) mod state;
pub(crate) mod station_variation;
pub(crate) mod variation;
