//! The curves of the variator, and one whose arcs the mesh does not follow.

mod angles;
pub(crate) mod unaligned;

pub use angles::{AngledCurve, TangentAngle};
pub use pushbelt::reference_curve::*;
pub use unaligned::{Unaligned, UnalignedFrame};
