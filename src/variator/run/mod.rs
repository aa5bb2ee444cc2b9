//! A run of a variator: start, communication steps, outputs, stored states.

mod communication_step;
mod outcome;
mod plausibility;
mod real_time;
mod real_time_monitor;
mod simulation;
mod start;
mod steady_start;
mod stepper;
pub(crate) mod tuning;
pub(crate) mod variator;

pub use crate::fmi::unit::Message;
pub use crate::variator::pulleys::loads::InputProfile;
pub use outcome::{Event, InitialisationError, Moment, StepError, TimeError};
pub use steady_start::SteadyTangent;
pub use stepper::CommunicationStep;
pub use variator::Variator;
