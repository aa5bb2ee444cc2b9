//! Calls that lead an instance through its run: log, set-up, initialisation, end.

use super::instance::{Slave, Version};
use super::outcome::{Trouble, refused};
use crate::log::{Category, Status};
use crate::snapshot::Snapshot;
use crate::state::{Call, State};
use crate::unit::{Experiment, Unit};

impl<U: Unit> Slave<U> {
    /// `fmi2SetDebugLogging`: with no category all of them.
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Status {
        self.call("fmi2SetDebugLogging", |slave| {
            let mut chosen = Vec::new();
            for name in categories {
                if *name == "logAll" {
                    chosen.extend(Category::ALL);
                } else if let Some(known) = Category::ALL.into_iter().find(|c| c.name() == *name) {
                    chosen.push(known);
                } else {
                    let all = Category::ALL.map(Category::name).join(", ");
                    return refused(format!("no log category {name:?}; there are {all}, logAll"));
                }
            }
            slave.log.choose(on, &chosen);
            Ok(())
        })
    }

    /// `fmi2SetupExperiment`.
    pub fn setup_experiment(&mut self, experiment: Experiment) -> Status {
        self.call("fmi2SetupExperiment", |slave| {
            slave.allow(Call::SetupExperiment)?;
            slave.now.experiment = checked(experiment)?;
            Ok(())
        })
    }

    /// `fmi2EnterInitializationMode`.
    pub fn enter_initialization_mode(&mut self) -> Status {
        self.call("fmi2EnterInitializationMode", |slave| {
            slave.allow(Call::EnterInitializationMode)?;
            slave.now.state = State::Initialisation;
            Ok(())
        })
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit_initialization_mode(&mut self) -> Status {
        self.call("fmi2ExitInitializationMode", |slave| {
            slave.allow(Call::ExitInitializationMode)?;
            slave.start_unit()?;
            slave.now.state = match slave.version {
                Version::Three { events: true } => State::Event,
                _ => State::StepComplete,
            };
            Ok(())
        })
    }

    /// `fmi2Terminate`.
    pub fn terminate(&mut self) -> Status {
        self.call("fmi2Terminate", |slave| {
            slave.allow(Call::Terminate)?;
            slave.now.state = State::Terminated;
            Ok(())
        })
    }

    /// `fmi2Reset`: as freshly instantiated, in every state.
    pub fn reset(&mut self) -> Status {
        self.call("fmi2Reset", |slave| {
            slave.allow(Call::Always)?;
            slave.now = Snapshot::starting_from(slave.start.clone());
            slave.log.choose(slave.debug, &[]);
            Ok(())
        })
    }
}

/// An experiment, if it makes sense.
pub(super) fn checked(experiment: Experiment) -> Result<Experiment, Trouble> {
    let Experiment { tolerance, start, stop } = experiment;
    if !start.is_finite() {
        return refused(format!("the start time {start} is not a finite number"));
    }
    if let Some(stop) = stop
        && (!stop.is_finite() || stop < start)
    {
        return refused(format!(
            "the stop time {stop} s is not at or after the start time {start} s"
        ));
    }
    if let Some(tolerance) = tolerance
        && !(tolerance.is_finite() && tolerance > 0.0)
    {
        return refused(format!("the tolerance {tolerance} is not above 0"));
    }
    Ok(experiment)
}
