//! A run of a variator: start, steps, outputs, stored states.

mod at_rest;
mod course;
mod initial;
mod pace;
mod real_time;
pub(crate) mod soft_start;
pub(crate) mod variator;
mod way;

pub use variator::{InitialisationError, Message, Moment, StepError, Variator};
pub use way::{Event, Way};
