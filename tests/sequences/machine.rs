//! The standard's state machine in the master: its common part for both versions, and the states of FMI 2.0.

use std::ffi::c_int;
use std::fmt::Debug;

use pushbelt_lab::shared_library::{DISCARD, ERROR, OK};

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

/// A state of the machine of one version.
pub trait Stage: Copy + PartialEq + Debug {
    const INSTANTIATED: Self;
    const ERROR: Self;
}

impl Stage for State {
    const INSTANTIATED: Self = Instantiated;
    const ERROR: Self = Error;
}

/// The master's model of the instance.
#[derive(Clone, Copy, Debug)]
pub struct Model<S> {
    pub state: S,
    pub time: f64,
    pub stop: Option<f64>,
}

impl<S: Stage> Model<S> {
    pub const FRESH: Self = Self {
        state: S::INSTANTIATED,
        time: 0.0,
        stop: None,
    };

    /// This state in the instance of another one: the stop time is that of the instance.
    pub fn in_instance_of(self, other: &Self) -> Self {
        Self {
            stop: other.stop,
            ..self
        }
    }

    /// Compares the status of a call with the expected one.
    pub fn expect(&mut self, call: &impl Debug, status: c_int, allowed: &[S], legal: Expected) {
        // In the error state there are values only if the run had started.
        let values = allowed.contains(&S::ERROR) && !allowed.contains(&S::INSTANTIATED);
        if self.state == S::ERROR && values && status == ERROR {
            return;
        }
        let expected = if allowed.contains(&self.state) {
            legal
        } else {
            Expected::Refused
        };
        let wanted = match expected {
            Expected::Done => OK,
            Expected::Discarded => DISCARD,
            Expected::Refused | Expected::Failed => ERROR,
        };
        assert_eq!(status, wanted, "{call:?} with {self:?}: {expected:?}");
        if expected == Expected::Failed {
            self.state = S::ERROR;
        }
    }

    /// Checks a call that leads to another state, and updates the model.
    pub fn moves(&mut self, call: &impl Debug, status: c_int, from: &[S], to: S) {
        self.expect(call, status, from, Expected::Done);
        if status == OK {
            self.state = to;
        }
    }
}

/// Whether an experiment can be set up.
pub fn is_experiment(tolerance: Option<f64>, start: f64, stop: Option<f64>) -> bool {
    start.abs() <= 1e11 && tolerance.is_none_or(|t| t.is_finite() && t > 0.0) && stop.is_none_or(|stop| stop >= start)
}

/// Expected result of a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    Done,
    /// An error that changes nothing.
    Refused,
    /// A value is discarded, and nothing changes.
    Discarded,
    /// An error after which only reset or a stored state leads on.
    Failed,
}

impl Expected {
    pub fn done_if(good: bool) -> Self {
        if good { Self::Done } else { Self::Refused }
    }
}
