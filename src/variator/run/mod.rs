//! A run of a variator: start, communication steps, outputs, stored states.
//!
//! | file | what it holds |
//! |---|---|
//! | `variator` | [`Variator`]: all that a user calls |
//! | `communication_step` | [`CommunicationStep`]: begin, advance, set inputs, finish |
//! | `stepper` | the trait behind a communication step, and the accurate integrator |
//! | `checkpoint` | the state before a communication step, for one that can't be done |
//! | `real_time` | the same integrator with bounded work |
//! | `outcome` | remarks, errors, outputs around a moment |
//! | `plant` | what a stepper advances: equations, state, inputs in force |
//! | `inputs` | inputs as functions of time, and those that wait in real time |
//! | `start`, `steady_start`, `at_rest`, `soft_start` | the state that a run starts from |
//! | `pace` | the warning of a run that takes too much work |
//! | `hints` | the warnings of loads and speeds that can hardly be meant |

mod at_rest;
mod checkpoint;
mod communication_step;
mod hints;
mod inputs;
mod outcome;
mod pace;
mod plant;
mod real_time;
pub(crate) mod soft_start;
pub(crate) mod start;
mod steady_start;
mod stepper;
pub(crate) mod variator;

pub use communication_step::{CommunicationStep, Event};
pub use inputs::InputProfile;
pub use outcome::{InitialisationError, Message, Moment, StepError};
pub use variator::Variator;
