//! The equations of a belt: balance and derivatives of packs of cells, and their sums.

mod derivatives;
mod evaluation;
mod pack;
pub(crate) mod packed;
mod rows;
pub(crate) mod transports;
