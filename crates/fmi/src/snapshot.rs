//! The whole dynamic state of an instance, and its way into bytes and back.

use super::bytes;
use super::state::State;
use super::table::{Access, Causality, Kind, Table, Variable};
use super::unit::{Experiment, Unit};
use pushbelt_tape::{Mismatch, Tape};

/// The whole dynamic state of an instance: what `Slave::save` keeps and `Slave::restore` brings back.
#[derive(Clone)]
pub struct Snapshot<U: Unit> {
    pub(super) state: State,
    pub(super) settings: U::Settings,
    /// Time derivatives of the real inputs for the next step, in the inputs' fields; none if all are zero.
    pub(super) rates: Option<U::Settings>,
    pub(super) experiment: Experiment,
    /// Communication point at which the next step begins, as the master counts, s.
    pub(super) point: f64,
    /// Present from the first calculated reading in initialisation mode on. Settings changed in that mode drop it.
    pub(super) unit: Option<U>,
}

impl<U: Unit> Snapshot<U> {
    pub(super) fn new() -> Self {
        Self::starting_from(U::Settings::default())
    }

    pub(super) fn starting_from(settings: U::Settings) -> Self {
        Self {
            state: State::Instantiated,
            settings,
            rates: None,
            experiment: Experiment::default(),
            point: 0.0,
            unit: None,
        }
    }

    /// The state as bytes, for an FMU with this GUID.
    ///
    /// # Errors
    /// A sentence that says why there are none.
    pub(super) fn to_bytes(&self, table: &Table<U::Settings, U::Readings>, guid: &str) -> Result<Vec<u8>, String> {
        let mut tape = Tape::writer();
        self.clone().serialize(table, &mut tape)?;
        Ok(bytes::seal(guid, &tape.into_bytes()))
    }

    /// The state that bytes of an FMU with this GUID hold.
    ///
    /// # Errors
    /// A sentence that says what is wrong with them.
    pub(super) fn from_bytes(
        table: &Table<U::Settings, U::Readings>,
        guid: &str,
        sealed: &[u8],
    ) -> Result<Self, String> {
        let mut tape = Tape::reader(bytes::open(guid, sealed)?);
        let mut snapshot = Self::new();
        snapshot.serialize(table, &mut tape)?;
        let fits = tape.finish();
        fits.map_err(|Mismatch| "the stored state does not fit this version of the model".to_string())?;
        Ok(snapshot)
    }

    /// Writes everything to a tape, or reads it from one into a new snapshot.
    fn serialize(&mut self, table: &Table<U::Settings, U::Readings>, tape: &mut Tape<'_>) -> Result<(), String> {
        let mut state = self.state as i32;
        tape.integer(&mut state);
        match State::ALL.into_iter().find(|known| *known as i32 == state) {
            Some(state) => self.state = state,
            None => tape.reject(),
        }
        let Experiment { tolerance, start, stop } = &mut self.experiment;
        tape.option(tolerance);
        tape.real(start);
        tape.option(stop);
        tape.real(&mut self.point);
        serialize_settings(
            table,
            &mut self.settings,
            tape,
            |variable| variable.causality.is_setting(),
            |variable, value| variable.admit_real(value).is_ok(),
        );
        let mut has_rates = self.rates.is_some();
        tape.flag(&mut has_rates);
        if has_rates {
            let rates = self.rates.get_or_insert_with(|| zero_rates(table));
            serialize_settings(table, rates, tape, is_real_input, |_, value| value.is_finite());
        }
        let mut started = self.unit.is_some();
        tape.flag(&mut started);
        if started {
            let mut unit = match self.unit.take() {
                Some(unit) => unit,
                None => U::blank(&self.settings, &self.experiment)?,
            };
            unit.serialize(tape);
            self.unit = Some(unit);
        }
        Ok(())
    }
}

fn is_real_input<S, R>(variable: &Variable<S, R>) -> bool {
    variable.causality == Causality::Input && matches!(variable.kind, Kind::Real { .. })
}

/// Settings whose real inputs are zero: the time derivatives of inputs that are held.
pub(super) fn zero_rates<S: Default, R>(table: &Table<S, R>) -> S {
    let mut rates = S::default();
    for variable in table.variables().iter().filter(|variable| is_real_input(variable)) {
        if let Kind::Real {
            access: Access::Setting { set, .. },
            ..
        } = &variable.kind
        {
            set(&mut rates, 0.0);
        }
    }
    rates
}

/// Writes the settings of some variables to a tape, or reads them from one: real numbers that are admissible, and others that
/// could be set.
fn serialize_settings<S, R>(
    table: &Table<S, R>,
    settings: &mut S,
    tape: &mut Tape<'_>,
    which: impl Fn(&Variable<S, R>) -> bool,
    admissible: impl Fn(&Variable<S, R>, f64) -> bool,
) {
    for variable in table.variables().iter().filter(|variable| which(variable)) {
        match &variable.kind {
            Kind::Real {
                access: Access::Setting { get, set },
                ..
            } => {
                let mut value = get(settings);
                tape.real(&mut value);
                if !admissible(variable, value) {
                    tape.reject();
                }
                set(settings, value);
            }
            Kind::Integer {
                access: Access::Setting { get, set },
                ..
            }
            | Kind::Enumeration {
                access: Access::Setting { get, set },
                ..
            } => {
                let mut value = get(settings);
                tape.integer(&mut value);
                if variable.admit_integer(value).is_ok() {
                    set(settings, value);
                } else {
                    tape.reject();
                }
            }
            Kind::Boolean {
                access: Access::Setting { get, set },
            } => {
                let mut value = get(settings);
                tape.flag(&mut value);
                set(settings, value);
            }
            _ => {}
        }
    }
}
