//! Laws of a cell: its arguments and results, contact of its flanks with the pulley, friction of the ring.

pub(crate) mod flanks;
pub(crate) mod place;
pub(crate) mod ring_friction;
pub(crate) mod spin;
