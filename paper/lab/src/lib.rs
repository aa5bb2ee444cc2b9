//! The ring alone as a [`system`], on the curves of [`drive`] and [`Circle`]: specimens, cases and
//! measurements of the tests and of the report on the paper (`examples/paper_rings`). Also the
//! rings of a variator by name.

mod belts;
mod cases;
mod circle;
mod derivatives;
pub mod drive;
mod motion;
mod record;
mod reference_motion;
mod specimens;
mod swings;
pub mod system;

pub use belts::*;
pub use cases::*;
pub use circle::*;
pub use derivatives::*;
pub use motion::*;
pub use record::*;
pub use reference_motion::*;
pub use specimens::*;
pub use swings::*;
pub use system::RingSystem;
