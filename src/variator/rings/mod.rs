//! The ring inside a cell: rings that follow the reference curve, and rings that deflect from it.

pub(crate) mod deflecting;
pub(crate) mod guided;
pub(crate) mod ring;
