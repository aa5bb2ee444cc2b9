//! Stored states: the whole dynamic state of an instance, and its conversion to bytes and back.

use super::clock::Clock;
use crate::state::State;
use crate::table::{Causality, Kind, Table, Value, Variable};
use crate::unit::{Experiment, Unit};
use pushbelt_archive::Archive;

/// The whole dynamic state of an instance: [`FmuInstance::save`](super::FmuInstance::save) copies
/// it, [`FmuInstance::restore`](super::FmuInstance::restore) goes back to it.
#[derive(Clone)]
pub struct Snapshot<U: Unit> {
    pub(super) state: State,
    pub(super) settings: U::Settings,
    /// Time derivatives of the real inputs for the next step, in the inputs' fields; none if all
    /// are zero.
    pub(super) rates: Option<U::Settings>,
    pub(super) experiment: Experiment,
    /// Communication point at which the next step begins.
    pub(super) clock: Clock,
    /// Present from the first calculated reading in initialisation mode on. A setting changed in
    /// that mode removes it.
    pub(super) unit: Option<U>,
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
    ///
    /// # Errors
    /// There is no unit to read the state into, with the reason of [`Unit::blank`].
    pub(super) fn serialize(
        &mut self,
        table: &Table<U::Settings, U::Readings>,
        archive: &mut Archive<'_>,
    ) -> Result<(), String> {
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
