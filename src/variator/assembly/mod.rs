//! From unknowns to equations: cells in packs, their balance and its derivatives added up.

mod evaluate;
mod global_slopes;
pub(crate) mod jacobian;
mod jacobian_cache;
pub(crate) mod kinds;
mod law_part;
mod pack;
pub(crate) mod packed;
mod regime;
pub(crate) mod transports;
pub(crate) mod unknowns;
