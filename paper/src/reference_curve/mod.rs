//! The curves of the variator, and one whose arcs the mesh does not follow.

mod unaligned;

pub use pushbelt::reference_curve::*;
pub use unaligned::{Unaligned, UnalignedFrame};
