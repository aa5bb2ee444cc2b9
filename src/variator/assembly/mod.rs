//! The equations of a belt: balance and derivatives of packs of cells, and their sums.

mod columns;
pub(crate) mod jacobian;
mod jacobian_cache;
pub(crate) mod kinds;
mod law_part;
mod pack;
pub(crate) mod packed;
pub(crate) mod transports;
pub(crate) mod unknowns;
