//! The ring inside a cell: the trait that a cell uses, and the Eulerian rings.

pub(crate) mod deflecting;
pub(crate) mod guided;
pub(crate) mod ring;
pub(crate) mod rotating;
