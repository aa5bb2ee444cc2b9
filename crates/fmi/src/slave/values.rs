//! Reading and writing of variables.

use super::instance::Slave;
use super::outcome::{Outcome, Trouble, refused};
use crate::log::Status;
use crate::snapshot::Snapshot;
use crate::state::{Call, State};
use crate::table::{Access, Causality, Inadmissible, Kind, Table, Variable};
use crate::unit::Unit;

/// Finds where a variable of one type lives.
type AccessOf<U, T> = fn(
    &Kind<<U as Unit>::Settings, <U as Unit>::Readings>,
) -> Option<&Access<<U as Unit>::Settings, <U as Unit>::Readings, T>>;

/// Checks a value against the limits of its variable; the value to be set.
type AdmissionOf<U, V> = fn(&Variable<<U as Unit>::Settings, <U as Unit>::Readings>, V) -> Result<V, Inadmissible>;

impl<U: Unit> Slave<U> {
    /// `fmi2GetReal`.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Status {
        self.call("fmi2GetReal", |slave| slave.get(references, values, real_access, |v| v))
    }

    /// `fmi2GetInteger`, for integers and enumerations.
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        self.call("fmi2GetInteger", |slave| {
            slave.get(references, values, integer_access, |v| v)
        })
    }

    /// `fmi2GetBoolean`, 0 or 1.
    pub fn get_boolean<V: From<bool>>(&mut self, references: &[u32], values: &mut [V]) -> Status {
        self.call("fmi2GetBoolean", |slave| {
            slave.get(references, values, boolean_access, V::from)
        })
    }

    /// Functions for a type that no variable has.
    pub fn no_such_type(&mut self, function: &'static str, call: Call, references: &[u32], type_name: &str) -> Status {
        self.call(function, |slave| {
            slave.allow(call)?;
            match references.first() {
                None => Ok(()),
                Some(reference) => refused(format!("no {type_name} has the value reference {reference}")),
            }
        })
    }

    /// `fmi2SetReal`. Either all values are taken or none.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        self.call("fmi2SetReal", |slave| {
            slave.set(
                references,
                values,
                real_access,
                |variable, value| variable.admit_real(value),
                |v| v,
            )
        })
    }

    /// `fmi2SetInteger`, for integers and enumerations. Either all values are taken or none.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        self.call("fmi2SetInteger", |slave| {
            slave.set(
                references,
                values,
                integer_access,
                |variable, value| variable.admit_integer(value),
                |v| v,
            )
        })
    }

    /// `fmi2SetBoolean`; what is not 0 is true. Either all values are taken or none.
    pub fn set_boolean<V: Copy + From<bool> + PartialEq>(&mut self, references: &[u32], values: &[V]) -> Status {
        self.call("fmi2SetBoolean", |slave| {
            let is_true = |v| v != V::from(false);
            slave.set(references, values, boolean_access, |_, v| Ok(v), is_true)
        })
    }

    pub(super) fn get<T, V>(
        &mut self,
        references: &[u32],
        values: &mut [V],
        access: AccessOf<U, T>,
        convert: fn(T) -> V,
    ) -> Outcome {
        self.allow(Call::Get)?;
        let (mut calculated, mut elements) = (false, false);
        for &reference in references {
            let (_, access) = find(&self.table, reference, access)?;
            calculated |= !matches!(access, Access::Setting { .. });
            elements |= matches!(access, Access::Element(..));
        }
        if calculated {
            if self.now.state == State::Initialisation {
                self.start_unit()?;
            } else if self.now.unit.is_none() {
                return refused(match self.now.state {
                    State::Instantiated => "there are no calculated values before initialization mode",
                    _ => "there are no calculated values after a failed start",
                });
            }
        }
        let Snapshot { settings, unit, .. } = &mut self.now;
        let readings = unit.as_mut().map(|unit| unit.readings(elements));
        for (&reference, value) in references.iter().zip(values) {
            let (_, access) = find(&self.table, reference, access)?;
            *value = convert(match (access, readings) {
                (Access::Setting { get, .. }, _) => get(settings),
                (Access::Reading(get), Some(readings)) => get(readings),
                (Access::Element(get, at), Some(readings)) => get(readings, *at),
                (_, None) => continue,
            });
        }
        Ok(())
    }

    pub(super) fn set<T, V: Copy>(
        &mut self,
        references: &[u32],
        values: &[V],
        access: AccessOf<U, T>,
        admit: AdmissionOf<U, V>,
        convert: fn(V) -> T,
    ) -> Outcome {
        self.allow(Call::Set)?;
        let running = self.now.state.is_running();
        let has_tunable = self.check_writable(references, access, running)?;
        for (&reference, &value) in references.iter().zip(values) {
            admit(find(&self.table, reference, access)?.0, value)?;
        }
        // A tunable parameter must fit the others at once: there is no initialisation ahead that would check it.
        let before = (running && has_tunable).then(|| self.now.settings.clone());
        for (&reference, &value) in references.iter().zip(values) {
            if let (variable, Access::Setting { set, .. }) = find(&self.table, reference, access)? {
                set(&mut self.now.settings, convert(admit(variable, value)?));
            }
        }
        if let Some(before) = before
            && let Err(text) = U::check(&self.now.settings)
        {
            self.now.settings = before;
            return Err(Trouble::Discarded(text));
        }
        if !running {
            self.now.unit = None;
        }
        Ok(())
    }

    /// Checks that all these variables may be set now; whether one of them is a tunable parameter.
    fn check_writable<T>(&self, references: &[u32], access: AccessOf<U, T>, running: bool) -> Result<bool, Trouble> {
        let mut has_tunable = false;
        for &reference in references {
            let (variable, _) = find(&self.table, reference, access)?;
            let name = &variable.name;
            match variable.causality {
                Causality::Output | Causality::Local => {
                    return refused(format!("{name} is calculated and can't be set"));
                }
                Causality::Parameter if running => {
                    return refused(format!("{name} is fixed once the run has started"));
                }
                Causality::Tunable => has_tunable = true,
                Causality::Parameter | Causality::Input => {}
            }
        }
        Ok(has_tunable)
    }
}

/// Where a real variable lives.
pub(super) fn real_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, f64>> {
    match kind {
        Kind::Real { access, .. } => Some(access),
        _ => None,
    }
}

/// Where an integer or enumeration variable lives.
fn integer_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, i32>> {
    match kind {
        Kind::Integer { access, .. } | Kind::Enumeration { access, .. } => Some(access),
        _ => None,
    }
}

/// Where a Boolean variable lives.
pub(super) fn boolean_access<S, R>(kind: &Kind<S, R>) -> Option<&Access<S, R, bool>> {
    match kind {
        Kind::Boolean { access } => Some(access),
        _ => None,
    }
}

/// The variable with a value reference, if it has the type that `access` looks for.
#[expect(clippy::type_complexity, reason = "a variable with its access, used only here")]
pub(super) fn find<S, R, T>(
    table: &Table<S, R>,
    reference: u32,
    access: fn(&Kind<S, R>) -> Option<&Access<S, R, T>>,
) -> Result<(&Variable<S, R>, &Access<S, R, T>), Trouble> {
    let Some(variable) = table.by_reference(reference) else {
        return refused(format!("no variable has the value reference {reference}"));
    };
    match access(&variable.kind) {
        Some(access) => Ok((variable, access)),
        None => refused(format!(
            "{} (value reference {reference}) has another type",
            variable.name
        )),
    }
}
