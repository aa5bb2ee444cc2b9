//! The state machine of the standard, as a master sees it.

/// States of the standard's state machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    Instantiated,
    Initialisation,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
}

pub use State::{Error, Initialisation, Instantiated, StepComplete, StepFailed, Terminated};

pub const SET: &[State] = &[Instantiated, Initialisation, StepComplete, StepFailed];
pub const GET: &[State] = &[Initialisation, StepComplete, StepFailed, Terminated, Error];
pub const RUNNING: &[State] = &[StepComplete, StepFailed];
pub const STATUS: &[State] = &[StepComplete, StepFailed, Terminated];
pub const BEFORE: &[State] = &[Instantiated, Initialisation];
pub const ANY: &[State] = &[
    Instantiated,
    Initialisation,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
];

/// What a master knows of the instance.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    pub state: State,
    pub time: f64,
    pub stop: Option<f64>,
}

pub const FRESH: Model = Model {
    state: Instantiated,
    time: 0.0,
    stop: None,
};

/// What a call should come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    Done,
    /// An error that changes nothing.
    Refused,
    /// A value that is not taken, and changes nothing.
    Discarded,
    /// An error after which only reset and stored states go on.
    Failed,
}

impl Expected {
    pub fn done_if(good: bool) -> Self {
        if good { Self::Done } else { Self::Refused }
    }
}
