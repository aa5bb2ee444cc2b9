//! Curves beside those of the variator: a circle, a belt drive with any number of pulleys, and a curve whose arcs the
//! mesh does not follow.

mod circle;
mod drive;
mod unaligned;

pub use circle::Circle;
pub use drive::{Drive, DriveError, DriveFrame, Pulley, Tensioner};
pub use pushbelt::reference_curve::*;
pub use unaligned::{Unaligned, UnalignedFrame};
