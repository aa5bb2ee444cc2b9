//! A run of a variator: start, communication steps, outputs, stored states.
//!
//! | file | what it holds |
//! |---|---|
//! | `variator` | [`Variator`]: all that a user calls |
//! | `communication_step` | [`CommunicationStep`]: begin, advance, set inputs, finish |
//! | `stepper`, `real_time` | the integrator behind a communication step, and the bound on its work in real time |
//! | `outcome` | remarks, errors, outputs around a moment |
//! | `simulation` | what a stepper advances: equations, state, inputs in force |
//! | `start`, `steady_start` | the state that a run starts from |
//! | `tuning` | the numbers that all this is tuned with |
//! | `pace` | the warning of a run that takes too much work |
//! | `hints` | the warnings of loads and speeds that can hardly be meant |

mod communication_step;
mod hints;
mod outcome;
pub(crate) mod pace;
mod real_time;
mod simulation;
mod start;
mod steady_start;
mod stepper;
pub(crate) mod tuning;
pub(crate) mod variator;

pub use crate::variator::pulleys::loads::InputProfile;
pub use communication_step::CommunicationStep;
pub use outcome::{Event, InitialisationError, Message, StepError};
pub use variator::Variator;
