//! Reference curves of a ring: that of the variator, and one whose arcs the mesh does not follow.

mod curve;
pub(crate) mod unaligned;

pub use curve::{ReferenceCurve, TangentAngle};
pub use pushbelt::reference_curve::*;
pub use unaligned::Unaligned;
