//! Stored states: the whole dynamic state of an instance, and its conversion to bytes and back.

use super::bytes;
use super::clock::Clock;
use super::error::{CallError, Outcome, refused};
use super::instance::Slave;
use crate::state::{Call, State};
use crate::table::{Causality, Kind, Table, Value, Variable};
use crate::unit::{Experiment, Unit};
use pushbelt_archive::{Archive, Mismatch};

/// The whole dynamic state of an instance: [`Slave::save`] copies it, [`Slave::restore`] goes back to it.
#[derive(Clone)]
pub struct Snapshot<U: Unit> {
    pub(super) state: State,
    pub(super) settings: U::Settings,
    /// Time derivatives of the real inputs for the next step, in the inputs' fields; none if all are zero.
    pub(super) rates: Option<U::Settings>,
    pub(super) experiment: Experiment,
    /// Communication point at which the next step begins.
    pub(super) clock: Clock,
    /// Present from the first calculated reading in initialisation mode on. A setting changed in that mode removes it.
    pub(super) unit: Option<U>,
}

impl<U: Unit> Slave<U> {
    /// A copy of the state.
    pub fn save(&mut self) -> Result<Snapshot<U>, CallError> {
        self.allow(Call::Always)?;
        Ok(self.now.clone())
    }

    /// Goes back to a state, which may come from another instance. The stop time is the one of this instance.
    pub fn restore(&mut self, snapshot: &Snapshot<U>) -> Outcome {
        self.allow(Call::Always)?;
        let stop = self.now.experiment.stop;
        self.now = snapshot.clone();
        self.now.experiment.stop = stop;
        // The state may come from an instance whose master handles events.
        if self.now.state == State::Event && !self.master.events {
            self.now.state = State::StepComplete;
        }
        Ok(())
    }

    /// A state as bytes.
    pub fn serialize(&mut self, snapshot: &Snapshot<U>) -> Result<Vec<u8>, CallError> {
        self.allow(Call::Always)?;
        let mut archive = Archive::writer();
        let written = snapshot.clone().serialize(&self.table, &mut archive);
        let sealed = written.and_then(|()| bytes::seal(self.guid(), &archive.into_bytes()));
        sealed.map_err(CallError::Refused)
    }

    /// The state in these bytes.
    pub fn deserialize(&mut self, sealed: &[u8]) -> Result<Snapshot<U>, CallError> {
        self.allow(Call::Always)?;
        let content = bytes::open(self.guid(), sealed).map_err(CallError::Refused)?;
        let mut archive = Archive::reader(content);
        let mut snapshot = Snapshot::<U>::starting_from(self.start.clone());
        snapshot
            .serialize(&self.table, &mut archive)
            .map_err(CallError::Refused)?;
        if archive.finish() == Err(Mismatch) {
            return refused("the stored state does not fit this version of the model");
        }
        snapshot.experiment = snapshot.experiment.checked()?;
        if let Some(unit) = &snapshot.unit
            && !snapshot.clock.agrees_with(unit.time(), U::IDENTITY.longest_step)
        {
            return refused(format!(
                "the stored state has a time of the model, {} s since the start, that is not its communication point's",
                unit.time()
            ));
        }
        Ok(snapshot)
    }
}

impl<U: Unit> Snapshot<U> {
    pub(super) fn starting_from(settings: U::Settings) -> Self {
        Self {
            state: State::Instantiated,
            settings,
            rates: None,
            experiment: Experiment::default(),
            clock: Clock::default(),
            unit: None,
        }
    }

    /// Writes everything to an archive, or reads it from one into a new snapshot.
    fn serialize(&mut self, table: &Table<U::Settings, U::Readings>, archive: &mut Archive<'_>) -> Result<(), String> {
        let mut state = self.state as i32;
        archive.integer(&mut state);
        match State::STORED.into_iter().find(|known| *known as i32 == state) {
            Some(state) => self.state = state,
            None => archive.reject(),
        }
        // The stop time is that of the instance that receives the state.
        let Experiment { tolerance, start, .. } = &mut self.experiment;
        archive.option(tolerance);
        archive.real(start);
        self.clock.serialize(archive);
        for variable in table.variables().iter().filter(|v| v.causality.is_setting()) {
            let value = serialized(variable, &self.settings, archive);
            if value.is_some_and(|value| variable.set(&mut self.settings, value).is_err()) {
                archive.reject();
            }
        }
        let mut has_rates = self.rates.is_some();
        archive.flag(&mut has_rates);
        if has_rates {
            let rates = self.rates.get_or_insert_with(|| zero_rates(table));
            for input in real_inputs(table) {
                if let Some(rate) = serialized(input, rates, archive) {
                    input.write(rates, rate);
                }
            }
        }
        let mut started = self.unit.is_some();
        archive.flag(&mut started);
        if started {
            let mut unit = match self.unit.take() {
                Some(unit) => unit,
                None => U::blank(&self.settings, &self.experiment)?,
            };
            unit.serialize(archive);
            self.unit = Some(unit);
        }
        Ok(())
    }
}

/// The real inputs, which have rates.
fn real_inputs<S, R>(table: &Table<S, R>) -> impl Iterator<Item = &Variable<S, R>> {
    let inputs = table.variables().iter().filter(|v| v.causality == Causality::Input);
    inputs.filter(|variable| matches!(variable.kind, Kind::Real { .. }))
}

/// Settings whose real inputs are zero: the time derivatives of inputs that are held.
pub(super) fn zero_rates<S: Default, R>(table: &Table<S, R>) -> S {
    let mut rates = S::default();
    real_inputs(table).for_each(|input| input.write(&mut rates, Value::Real(0.0)));
    rates
}

/// Writes the value of a setting to an archive, or reads it from one.
fn serialized<S, R>(variable: &Variable<S, R>, settings: &S, archive: &mut Archive<'_>) -> Option<Value> {
    let mut value = variable.value(settings, None)?;
    match &mut value {
        Value::Real(value) => archive.real(value),
        Value::Integer(value) => {
            let mut number = i32::try_from(*value).unwrap_or_default();
            archive.integer(&mut number);
            *value = number.into();
        }
        Value::Boolean(value) => archive.flag(value),
    }
    Some(value)
}
