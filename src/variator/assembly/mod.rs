//! The equations of a belt: balance and derivatives of packs of cells, and their sums.

pub(crate) mod derivatives;
pub(crate) mod jacobian;
pub(crate) mod kinds;
mod pack;
pub(crate) mod packed;
pub(crate) mod transports;
