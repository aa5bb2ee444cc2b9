//! The ring alone: specimens, ring models behind one trait, and measurements that both the tests and the report on the
//! paper (`examples/paper_rings`) use. Beside them, rings for a variator.

mod belts;
mod cases;
mod derivatives;
mod motion;
mod record;
mod reference_motion;
mod specimens;
mod swings;

pub use belts::*;
pub use cases::*;
pub use derivatives::*;
pub use motion::*;
pub use record::*;
pub use reference_motion::*;
pub use specimens::*;
pub use swings::*;
