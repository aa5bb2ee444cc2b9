//! Laws of a cell: its arguments and results, contact of its flanks with the pulley, friction of
//! the ring.

pub(crate) mod arguments;
pub(crate) mod element_rotation;
pub(crate) mod flanks;
pub(crate) mod ring_friction;
