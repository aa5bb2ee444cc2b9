//! The whole dynamic state of an instance, and its conversion to bytes and back.

use super::bytes;
use super::slave::Clock;
use super::state::State;
use super::table::{Access, Causality, Kind, Table, Value};
use super::unit::{Experiment, Unit};
use pushbelt_archive::{Archive, Mismatch};

/// The whole dynamic state of an instance: `Slave::save` copies it, `Slave::restore` goes back to it.
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

    /// The state as bytes, for an FMU with this GUID.
    ///
    /// # Errors
    /// The reason, as a sentence.
    pub(super) fn to_bytes(&self, table: &Table<U::Settings, U::Readings>, guid: &str) -> Result<Vec<u8>, String> {
        let mut archive = Archive::writer();
        self.clone().serialize(table, &mut archive)?;
        bytes::seal(guid, &archive.into_bytes())
    }

    /// The state that bytes of an FMU with this GUID hold. `defaults` are settings with the data of the model.
    ///
    /// # Errors
    /// The reason, as a sentence.
    pub(super) fn from_bytes(
        table: &Table<U::Settings, U::Readings>,
        guid: &str,
        defaults: &U::Settings,
        sealed: &[u8],
    ) -> Result<Self, String> {
        let mut archive = Archive::reader(bytes::open(guid, sealed)?);
        let mut snapshot = Self::starting_from(defaults.clone());
        snapshot.serialize(table, &mut archive)?;
        let fits = archive.finish();
        fits.map_err(|Mismatch| "the stored state does not fit this version of the model".to_string())?;
        snapshot.experiment = snapshot.experiment.checked().map_err(|error| error.to_string())?;
        if let Some(unit) = &snapshot.unit
            && !snapshot.clock.agrees_with(unit.time(), U::IDENTITY.longest_step)
        {
            return Err(format!(
                "the stored state has a time of the model, {} s since the start, that is not its communication point's",
                unit.time()
            ));
        }
        Ok(snapshot)
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
        serialize_settings(table, &mut self.settings, archive);
        let mut has_rates = self.rates.is_some();
        archive.flag(&mut has_rates);
        if has_rates {
            serialize_rates(table, self.rates.get_or_insert_with(|| zero_rates(table)), archive);
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

/// How to read and write the field of a real input.
type Field<S> = (fn(&S) -> f64, fn(&mut S, f64));

/// The fields of the real inputs.
fn real_inputs<S, R>(table: &Table<S, R>) -> impl Iterator<Item = Field<S>> {
    let inputs = table.variables().iter().filter(|v| v.causality == Causality::Input);
    inputs.filter_map(|variable| match &variable.kind {
        Kind::Real {
            access: Access::Setting { get, set },
            ..
        } => Some((*get, *set)),
        _ => None,
    })
}

/// Settings whose real inputs are zero: the time derivatives of inputs that are held.
pub(super) fn zero_rates<S: Default, R>(table: &Table<S, R>) -> S {
    let mut rates = S::default();
    real_inputs(table).for_each(|(_, set)| set(&mut rates, 0.0));
    rates
}

/// Writes the time derivatives of the real inputs to an archive, or reads them from one.
fn serialize_rates<S, R>(table: &Table<S, R>, rates: &mut S, archive: &mut Archive<'_>) {
    for (get, set) in real_inputs(table) {
        let mut rate = get(rates);
        archive.real(&mut rate);
        set(rates, rate);
    }
}

/// Writes all settings to an archive, or reads them from one if they are admissible.
fn serialize_settings<S, R>(table: &Table<S, R>, settings: &mut S, archive: &mut Archive<'_>) {
    for variable in table.variables().iter().filter(|v| v.causality.is_setting()) {
        let Some(mut value) = variable.value(settings, None) else {
            continue;
        };
        match &mut value {
            Value::Real(value) => archive.real(value),
            Value::Integer(value) => {
                let mut number = i32::try_from(*value).unwrap_or_default();
                archive.integer(&mut number);
                *value = number.into();
            }
            Value::Boolean(value) => archive.flag(value),
        }
        if variable.set(settings, value).is_err() {
            archive.reject();
        }
    }
}
