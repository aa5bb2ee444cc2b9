//! The ring inside a cell: what a cell asks of it, and the Eulerian rings.

pub(crate) mod deflecting;
pub(crate) mod guided;
pub(crate) mod ring;
pub(crate) mod rotating;
