//! What a cell asks of its ring, and the rings that keep to the reference curve or deflect from it.

pub(crate) mod deflecting;
pub(crate) mod guided;
pub(crate) mod ring;
pub(crate) mod standard;
