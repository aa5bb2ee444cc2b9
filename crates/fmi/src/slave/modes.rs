//! What FMI 3.0 adds to the way through a run: the experiment comes with initialisation mode, and events have a mode.

use super::instance::{Slave, Version};
use super::lifecycle::checked;
use super::outcome::{Outcome, refused};
use crate::log::Status;
use crate::state::{Call, State};
use crate::unit::{Experiment, Unit};

impl<U: Unit> Slave<U> {
    /// `fmi3EnterInitializationMode`.
    pub fn initialize(&mut self, experiment: Experiment) -> Status {
        self.call("fmi3EnterInitializationMode", |slave| {
            slave.allow(Call::EnterInitializationMode)?;
            slave.now.experiment = checked(experiment)?;
            slave.now.state = State::Initialisation;
            Ok(())
        })
    }

    /// `fmi3EnterEventMode`.
    pub fn enter_event_mode(&mut self) -> Status {
        self.call("fmi3EnterEventMode", |slave| {
            slave.allow(Call::EnterEventMode)?;
            slave.handles_events()?;
            slave.now.state = State::Event;
            Ok(())
        })
    }

    /// `fmi3UpdateDiscreteStates`: there are none, so nothing needs an update and no event is known ahead.
    pub fn update_discrete_states(&mut self) -> Status {
        self.call("fmi3UpdateDiscreteStates", |slave| slave.allow(Call::HandleEvent))
    }

    /// `fmi3EnterStepMode`.
    pub fn enter_step_mode(&mut self) -> Status {
        self.call("fmi3EnterStepMode", |slave| {
            slave.allow(Call::HandleEvent)?;
            slave.now.state = State::StepComplete;
            Ok(())
        })
    }

    fn handles_events(&self) -> Outcome {
        match self.version {
            Version::Three { events: true } => Ok(()),
            _ => refused("the instance was made without event mode (eventModeUsed)"),
        }
    }

    /// The present time, s: as the master counts, before the start that of the experiment.
    #[must_use]
    pub fn time(&self) -> f64 {
        match &self.now.unit {
            Some(_) => self.now.point,
            None => self.now.experiment.start,
        }
    }
}
