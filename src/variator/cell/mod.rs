//! One cell of the belt: the coupling of ring, push elements and sheaves.

pub(crate) mod balance;
pub(crate) mod directions;
pub(crate) mod laws;
pub(crate) mod observer;
pub mod sample;
pub(crate) mod state;
