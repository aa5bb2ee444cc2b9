//! What a cell is given: constants, place and motion; how it stands to its pulley; friction of the ring.

pub(crate) mod flanks;
pub mod place;
pub(crate) mod ring_friction;
