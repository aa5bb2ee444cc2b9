//! Travelling rings: their nodes move with the material under the cells.

pub(crate) mod assembly;
mod evaluation;
pub(crate) mod order;
mod passing;
pub(crate) mod start;
