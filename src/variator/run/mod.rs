//! A run of a variator: start, steps, outputs, stored states.

mod at_rest;
mod backlog;
mod course;
mod division;
mod initial;
mod pace;
mod real_time;
mod rounding;
pub(crate) mod soft_start;
pub(crate) mod variator;
mod way;

pub use variator::{InitialisationError, Message, Moment, StepError, Variator};
pub use way::{Event, Way};
