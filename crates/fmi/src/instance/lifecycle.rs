//! Calls that change the state of an instance: log, set-up, initialisation, event mode, end; stored
//! states.

use super::calls::FmuInstance;
use super::clock::Clock;
use super::snapshot::Snapshot;
use super::{CallError, Outcome, bytes, refused};
use crate::log::Category;
use crate::state::{Call, State};
use crate::table::{Value, not_finite};
use crate::unit::{Experiment, Unit};
use pushbelt_archive::{Archive, Mismatch};

impl<U: Unit> FmuInstance<U> {
    /// Chooses the logged categories by their names; without any, all.
    ///
    /// # Errors
    /// There is no category of a name. Nothing has changed.
    pub fn set_debug_logging(
        &mut self,
        on: bool,
        names: impl Iterator<Item = Result<Option<String>, CallError>>,
    ) -> Outcome {
        self.allow(Call::Always)?;
        let mut chosen = Vec::new();
        for name in names {
            let (name, known) = (name?.unwrap_or_default(), chosen.len());
            let is_chosen = |category: &Category| name == "logAll" || category.name() == name;
            chosen.extend(Category::ALL.into_iter().filter(is_chosen));
            if chosen.len() == known {
                let all = Category::ALL.map(Category::name).join(", ");
                return refused(format!("no log category {name:?}; there are {all}, logAll"));
            }
        }
        self.log.choose(on, &chosen);
        Ok(())
    }

    /// Sets tolerance, start time and stop time of the run.
    ///
    /// # Errors
    /// A value makes no sense. Nothing has changed.
    pub fn setup_experiment(&mut self, experiment: Experiment) -> Outcome {
        self.allow(Call::SetupExperiment)?;
        self.now.experiment = experiment.checked()?;
        Ok(())
    }

    /// Changes the state by a call that does nothing else.
    ///
    /// # Errors
    /// The state does not allow it.
    pub(crate) fn enter(&mut self, state: State, by: Call) -> Outcome {
        self.allow(by)?;
        self.now.state = state;
        Ok(())
    }

    /// Leaves initialisation mode, for event mode if the importer handles events.
    ///
    /// # Errors
    /// The unit does not start, and the instance has failed.
    pub fn exit_initialization_mode(&mut self) -> Outcome {
        self.allow(Call::ExitInitializationMode)?;
        self.start_unit()?;
        self.now.state = match self.importer.events {
            true => State::Event,
            false => State::StepComplete,
        };
        Ok(())
    }

    /// Enters event mode.
    ///
    /// # Errors
    /// Its importer handles no events.
    pub fn enter_event_mode(&mut self) -> Outcome {
        self.allow(Call::EnterEventMode)?;
        if !self.importer.events {
            return refused("the instance was created without event mode (eventModeUsed)");
        }
        self.now.state = State::Event;
        Ok(())
    }

    /// Returns the instance to its state after instantiation. Allowed in every state.
    ///
    /// # Errors
    /// The instance is in intermediate update mode.
    pub fn reset(&mut self) -> Outcome {
        self.reset_near()?;
        self.near = None;
        Ok(())
    }

    /// As [`FmuInstance::reset`]. The search of the next start may begin at the state that the
    /// present run started from.
    ///
    /// # Errors
    /// The instance is in intermediate update mode.
    pub fn reset_near(&mut self) -> Outcome {
        self.allow(Call::Always)?;
        self.near = self.now.unit.take();
        self.now = Snapshot::starting_from(self.start.clone());
        self.log.reset();
        Ok(())
    }

    /// A copy of the whole dynamic state.
    ///
    /// # Errors
    /// The instance is in intermediate update mode.
    pub fn save(&mut self) -> Result<Snapshot<U>, CallError> {
        self.allow(Call::Always)?;
        Ok(self.now.clone())
    }

    /// Goes back to a state, which may come from another instance. The stop time is the one of this
    /// instance.
    ///
    /// # Errors
    /// The instance is in intermediate update mode.
    pub fn restore(&mut self, snapshot: &Snapshot<U>) -> Outcome {
        self.allow(Call::Always)?;
        let stop = self.now.experiment.stop;
        self.now = snapshot.clone();
        self.now.experiment.stop = stop;
        // The state may come from an instance whose importer handles events.
        if self.now.state == State::Event && !self.importer.events {
            self.now.state = State::StepComplete;
        }
        Ok(())
    }

    /// A state as bytes.
    ///
    /// # Errors
    /// The instance is in intermediate update mode, or there is no memory for the bytes.
    pub fn serialize(&mut self, snapshot: &Snapshot<U>) -> Result<Vec<u8>, CallError> {
        self.allow(Call::Always)?;
        let mut archive = Archive::writer();
        let written = snapshot.clone().serialize(&self.table, &mut archive);
        let sealed = written.and_then(|()| bytes::seal(self.guid(), &archive.into_bytes()));
        sealed.map_err(CallError::Refused)
    }

    /// The state in these bytes.
    ///
    /// # Errors
    /// The instance is in intermediate update mode; the bytes are incomplete, damaged, or of
    /// another FMU; a value in them is out of range, or a reading not finite. Nothing has changed.
    pub fn deserialize(&mut self, sealed: &[u8]) -> Result<Snapshot<U>, CallError> {
        self.allow(Call::Always)?;
        let content = bytes::open(self.guid(), sealed).map_err(CallError::Refused)?;
        let mut archive = Archive::reader(content);
        let mut snapshot = Snapshot::<U>::starting_from(self.start.clone());
        let read = snapshot.serialize(&self.table, &mut archive);
        read.map_err(CallError::Refused)?;
        if archive.finish() == Err(Mismatch) {
            return refused("the stored state does not fit this version of the model");
        }
        snapshot.experiment = snapshot.experiment.checked()?;
        if let Some(unit) = &snapshot.unit
            && !snapshot.clock.agrees_with(unit.time(), U::IDENTITY.longest_step)
        {
            return refused(format!(
                "the stored state has a time of the model, {} s since the start, that is not its \
                 communication point's",
                unit.time()
            ));
        }
        if let Some(unit) = &mut snapshot.unit {
            let readings = unit.readings(true);
            for variable in self.table.variables() {
                match variable.value(&snapshot.settings, Some(readings)) {
                    Some(Value::Real(value)) if !value.is_finite() => {
                        let why = not_finite(&variable.name, value);
                        return refused(format!("no run has the stored state: {why}"));
                    }
                    _ => (),
                }
            }
        }
        Ok(snapshot)
    }
}

impl Experiment {
    /// The experiment, if its values are valid. An infinite stop time, which importers of Simulink
    /// pass, is none.
    ///
    /// # Errors
    /// A time or the tolerance is not finite or out of range, or the stop time is before the start
    /// time.
    pub(crate) fn checked(mut self) -> Result<Self, CallError> {
        self.stop = self.stop.filter(|stop| *stop != f64::INFINITY);
        let Self {
            tolerance,
            start,
            stop,
        } = self;
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
