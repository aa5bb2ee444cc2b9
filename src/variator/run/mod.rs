//! A run of a variator: start, communication steps, outputs, stored states.

mod communication_step;
mod hints;
mod outcome;
mod pace;
mod real_time;
mod simulation;
mod start;
mod steady_start;
mod stepper;
pub(crate) mod tuning;
pub(crate) mod variator;

pub use crate::fmi::unit::Message;
pub use crate::variator::pulleys::loads::InputProfile;
pub use outcome::{Event, InitialisationError, StepError, TimeError};
pub use stepper::CommunicationStep;
pub use variator::Variator;
