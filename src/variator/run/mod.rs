//! The variator as a user holds it.

mod initial;
pub(crate) mod soft_start;
pub(crate) mod variator;

pub use variator::{InitialisationError, Message, Moment, StepError, Variator};
