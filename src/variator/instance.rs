//! The variator as a user holds it: build from parameters, initialise, advance, read.

use super::parameters::Parameters;
use super::signals::{Inputs, Outputs};
use super::validation::ParameterError;

/// A remark for the user's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether the user should act on it.
    pub warning: bool,
    /// One sentence.
    pub text: String,
}

/// Why a variator could not be initialised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InitialisationError {
    /// An input is out of its range.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// No state was found to start from.
    #[error("the initial state could not be found: {0}")]
    NoState(String),
}

/// Why a step could not be done. The state stays at the last successful time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// An input is out of its range; nothing was changed.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// The step size fell below the smallest useful one.
    #[error("the step from {from} s stalled at {reached} s: {reason}")]
    Stalled {
        /// Start of the step, s.
        from: f64,
        /// Last successful time, s.
        reached: f64,
        /// What the solver saw.
        reason: String,
    },
}

/// A variator: parameters, mesh and the whole dynamic state in one place.
#[derive(Clone, Debug)]
pub struct Variator {
    parameters: Parameters,
    time: f64,
    outputs: Outputs,
    messages: Vec<Message>,
}

impl Variator {
    /// Builds mesh and workspace.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self {
            parameters,
            time: 0.0,
            outputs: Outputs::default(),
            messages: Vec::new(),
        })
    }

    /// Finds the state to start from at `time`.
    ///
    /// # Errors
    /// Inputs out of range, or no state found.
    pub fn initialise(&mut self, time: f64, inputs: &Inputs) -> Result<(), InitialisationError> {
        inputs.validate()?;
        self.time = time;
        Ok(())
    }

    /// Advances to time `to` with constant inputs.
    ///
    /// # Errors
    /// Inputs out of range, or a step that can't be done.
    pub fn advance(&mut self, to: f64, inputs: &Inputs) -> Result<(), StepError> {
        inputs.validate()?;
        self.time = to;
        Ok(())
    }

    /// Present time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Parameters in force.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Changes the two tunable friction coefficients.
    ///
    /// # Errors
    /// A coefficient out of its range; nothing was changed.
    pub fn set_friction(&mut self, pulley: f64, ring: f64) -> Result<(), ParameterError> {
        let mut changed = self.parameters.clone();
        changed.friction.pulley = pulley;
        changed.friction.ring = ring;
        changed.validate()?;
        self.parameters = changed;
        Ok(())
    }

    /// Outputs at the present time.
    pub fn outputs(&mut self) -> &Outputs {
        &self.outputs
    }

    /// Takes the messages that have come up since the last call.
    pub fn take_messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }
}
