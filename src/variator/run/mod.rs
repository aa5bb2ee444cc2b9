//! A run of a variator: start, communication steps, outputs, stored states.
//!
//! | file | what it holds |
//! |---|---|
//! | `variator` | [`Variator`]: all that a user calls |
//! | `communication_step` | [`CommunicationStep`]: begin, advance, set inputs, finish |
//! | `stepper` | the trait behind a communication step, and the accurate integrator |
//! | `real_time` | the same integrator with bounded work |
//! | `outcome` | remarks, errors, outputs around a moment |
//! | `simulation` | what a stepper advances: equations, state, inputs in force |
//! | `pending_inputs` | inputs that wait in real time |
//! | `start`, `steady_start`, `at_rest`, `soft_start` | the state that a run starts from |
//! | `tuning` | the numbers that all this is tuned with |
//! | `pace` | the warning of a run that takes too much work |
//! | `hints` | the warnings of loads and speeds that can hardly be meant |

mod at_rest;
mod communication_step;
mod hints;
mod outcome;
mod pace;
mod pending_inputs;
mod real_time;
mod simulation;
mod soft_start;
mod start;
mod steady_start;
mod stepper;
pub(crate) mod tuning;
pub(crate) mod variator;

pub use crate::variator::pulleys::loads::InputProfile;
pub use communication_step::CommunicationStep;
pub use outcome::{Event, InitialisationError, Message, Moment, StepError};
pub use variator::Variator;
