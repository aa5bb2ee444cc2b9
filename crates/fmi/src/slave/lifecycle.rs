//! Calls that change the state of an instance: log, set-up, initialisation, event mode, end.

use super::clock::Clock;
use super::error::{CallError, Outcome, refused};
use super::instance::Slave;
use super::snapshot::Snapshot;
use crate::log::Category;
use crate::state::{Call, State};
use crate::unit::{Experiment, Unit};

impl<U: Unit> Slave<U> {
    /// Chooses the logged categories by their names; without any, all.
    pub fn set_debug_logging(
        &mut self,
        on: bool,
        names: impl IntoIterator<Item = Result<String, CallError>>,
    ) -> Outcome {
        self.allow(Call::Always)?;
        let mut chosen = 0;
        for name in names {
            let name = name?;
            let is_chosen = |category: &Category| name == "logAll" || category.name() == name;
            let bits = Category::ALL.into_iter().filter(is_chosen).map(Category::bit);
            let found = bits.fold(0, |found, bit| found | bit);
            if found == 0 {
                let all = Category::ALL.map(Category::name).join(", ");
                return refused(format!("no log category {name:?}; there are {all}, logAll"));
            }
            chosen |= found;
        }
        self.log.choose(on, chosen);
        Ok(())
    }

    /// Sets tolerance, start and stop time, in FMI 2.0.
    pub fn setup_experiment(&mut self, experiment: Experiment) -> Outcome {
        self.allow(Call::SetupExperiment)?;
        self.now.experiment = experiment.checked()?;
        Ok(())
    }

    /// Changes the state by a call that does nothing else.
    pub(crate) fn enter(&mut self, state: State, by: Call) -> Outcome {
        self.allow(by)?;
        self.now.state = state;
        Ok(())
    }

    /// Sets tolerance, start and stop time, and enters initialisation mode, in FMI 3.0.
    pub fn initialize(&mut self, experiment: Experiment) -> Outcome {
        self.setup_experiment(experiment)?;
        self.enter(State::Initialisation, Call::EnterInitializationMode)
    }

    /// Leaves initialisation mode, for event mode if the master handles events.
    pub fn exit_initialization_mode(&mut self) -> Outcome {
        self.allow(Call::ExitInitializationMode)?;
        self.start_unit()?;
        self.now.state = if self.master.events {
            State::Event
        } else {
            State::StepComplete
        };
        Ok(())
    }

    /// Enters event mode.
    pub fn enter_event_mode(&mut self) -> Outcome {
        self.allow(Call::EnterEventMode)?;
        if !self.master.events {
            return refused("the instance was created without event mode (eventModeUsed)");
        }
        self.now.state = State::Event;
        Ok(())
    }

    /// Returns the instance to its state after instantiation. Allowed in every state.
    pub fn reset(&mut self) -> Outcome {
        self.allow(Call::Always)?;
        self.now = Snapshot::starting_from(self.start.clone());
        self.log.reset();
        Ok(())
    }
}

impl Experiment {
    /// The experiment, if its values are valid. An infinite stop time, which importers of Simulink pass, is none.
    pub(crate) fn checked(mut self) -> Result<Self, CallError> {
        self.stop = self.stop.filter(|stop| *stop != f64::INFINITY);
        let Self { tolerance, start, stop } = self;
        Clock::start(start)?;
        if let Some(stop) = stop
            && (stop.is_nan() || stop < start)
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
        Ok(self)
    }
}
