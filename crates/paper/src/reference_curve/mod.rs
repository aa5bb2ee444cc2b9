//! Curves beside those of the variator: a circle, and a curve whose arcs the mesh does not follow.

mod circle;
mod unaligned;

pub use circle::Circle;
pub use pushbelt::reference_curve::*;
pub use unaligned::{Unaligned, UnalignedFrame};
