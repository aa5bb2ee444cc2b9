//! One cell of the belt: where ring, push elements and sheaves meet.

pub(crate) mod balance;
pub(crate) mod deflecting;
pub(crate) mod directions;
pub(crate) mod flanks;
pub(crate) mod guided;
pub mod place;
pub(crate) mod ring;
pub(crate) mod ring_friction;
pub(crate) mod rotating;
pub mod sample;
pub(crate) mod variation;
