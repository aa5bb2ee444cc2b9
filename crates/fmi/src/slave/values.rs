//! Reading and writing of variables.

use std::borrow::Cow;

use super::error::{CallError, Outcome, refused};
use super::instance::Slave;
use crate::snapshot::Snapshot;
use crate::state::{Call, State};
use crate::table::{Causality, Inadmissible, Kind, Table, Value, Variable};
use crate::unit::Unit;

/// Value reference of the time in FMI 3.0, which no variable of a table has.
pub(crate) const TIME: u32 = 0;

/// Whether a kind of variable belongs to a type of the interface.
type Belongs<U> = fn(&Kind<<U as Unit>::Settings, <U as Unit>::Readings>) -> bool;

pub(super) fn is_real<S, R>(kind: &Kind<S, R>) -> bool {
    matches!(kind, Kind::Real { .. })
}

fn is_integer<S, R>(kind: &Kind<S, R>) -> bool {
    matches!(kind, Kind::Integer { .. })
}

fn is_enumeration<S, R>(kind: &Kind<S, R>) -> bool {
    matches!(kind, Kind::Enumeration { .. })
}

fn is_boolean<S, R>(kind: &Kind<S, R>) -> bool {
    matches!(kind, Kind::Boolean { .. })
}

fn number(value: Value) -> f64 {
    match value {
        Value::Real(value) => value,
        _ => f64::NAN,
    }
}

fn integer(value: Value) -> i64 {
    match value {
        Value::Integer(value) => value,
        _ => 0,
    }
}

fn short_integer(value: Value) -> i32 {
    i32::try_from(integer(value)).unwrap_or_default()
}

fn boolean<V: From<bool>>(value: Value) -> V {
    V::from(value == Value::Boolean(true))
}

fn from_boolean<V: From<bool> + PartialEq>(value: V) -> Value {
    Value::Boolean(value != V::from(false))
}

/// Writing takes either all values or none.
impl<U: Unit> Slave<U> {
    /// Reads reals, in FMI 2.0.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Outcome {
        self.get(references, values, is_real, number)
    }

    /// Writes reals, in FMI 2.0.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.set(references, values, is_real, Value::Real)
    }

    /// Reads whole numbers and enumerations, in FMI 2.0.
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Outcome {
        let belongs: Belongs<U> = |kind| is_integer(kind) || is_enumeration(kind);
        self.get(references, values, belongs, short_integer)
    }

    /// Writes whole numbers and enumerations, in FMI 2.0.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        let belongs: Belongs<U> = |kind| is_integer(kind) || is_enumeration(kind);
        self.set(references, values, belongs, |value| Value::Integer(value.into()))
    }

    /// Reads truth values as 0 or 1.
    pub fn get_boolean<V: From<bool>>(&mut self, references: &[u32], values: &mut [V]) -> Outcome {
        self.get(references, values, is_boolean, boolean)
    }

    /// Writes truth values: all but 0 is true.
    pub fn set_boolean<V: Copy + From<bool> + PartialEq>(&mut self, references: &[u32], values: &[V]) -> Outcome {
        self.set(references, values, is_boolean, from_boolean)
    }

    /// Reads whole numbers, in FMI 3.0.
    pub fn get_int32(&mut self, references: &[u32], values: &mut [i32]) -> Outcome {
        self.get(references, values, is_integer, short_integer)
    }

    /// Writes whole numbers, in FMI 3.0.
    pub fn set_int32(&mut self, references: &[u32], values: &[i32]) -> Outcome {
        self.set(references, values, is_integer, |value| Value::Integer(value.into()))
    }

    /// Reads enumerations, in FMI 3.0.
    pub fn get_int64(&mut self, references: &[u32], values: &mut [i64]) -> Outcome {
        self.get(references, values, is_enumeration, integer)
    }

    /// Writes enumerations, in FMI 3.0.
    pub fn set_int64(&mut self, references: &[u32], values: &[i64]) -> Outcome {
        self.set(references, values, is_enumeration, Value::Integer)
    }

    /// Reads reals, arrays of reals and the time, in FMI 3.0.
    pub fn get_float64(&mut self, references: &[u32], values: &mut [f64]) -> Outcome {
        self.allow_intermediate(references)?;
        let expanded = expand(&self.table, references, values.len())?;
        if !expanded.contains(&TIME) {
            return self.read(&expanded, values, is_real, number);
        }
        let known: Vec<u32> = expanded
            .iter()
            .copied()
            .filter(|reference| *reference != TIME)
            .collect();
        let mut found = vec![0.0; known.len()];
        self.read(&known, &mut found, is_real, number)?;
        let mut found = found.into_iter();
        for (value, reference) in values.iter_mut().zip(&*expanded) {
            *value = match reference {
                &TIME => self.time(),
                _ => found.next().unwrap_or(f64::NAN),
            };
        }
        Ok(())
    }

    /// Writes reals and arrays of reals, in FMI 3.0.
    pub fn set_float64(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        let expanded = expand(&self.table, references, values.len())?;
        if expanded.contains(&TIME) {
            return refused("time can't be set");
        }
        self.set(&expanded, values, is_real, Value::Real)
    }

    /// Reads or writes variables of a type that no variable has.
    pub fn no_such_type(&mut self, call: Call, references: &[u32], type_name: &str) -> Outcome {
        self.allow(call)?;
        match references.first() {
            None => Ok(()),
            Some(reference) => refused(format!("no {type_name} has the value reference {reference}")),
        }
    }

    /// In intermediate update mode, refuses variables that were not announced for it.
    pub(super) fn allow_intermediate(&self, references: &[u32]) -> Outcome {
        let announced = |reference: &u32| *reference == TIME || self.master.intermediate.contains(reference);
        match references.iter().find(|reference| !announced(reference)) {
            Some(other) if self.now.state == State::IntermediateUpdate => refused(format!(
                "in intermediate update mode, and the value reference {other} is not among the required intermediate \
                 variables that fmi3InstantiateCoSimulation was given"
            )),
            _ => Ok(()),
        }
    }

    fn get<V>(
        &mut self,
        references: &[u32],
        values: &mut [V],
        belongs: Belongs<U>,
        convert: fn(Value) -> V,
    ) -> Outcome {
        self.allow_intermediate(references)?;
        check_count(references.len(), values.len(), references.len())?;
        self.read(references, values, belongs, convert)
    }

    /// Reads scalars and elements of arrays.
    fn read<V>(
        &mut self,
        references: &[u32],
        values: &mut [V],
        belongs: Belongs<U>,
        convert: fn(Value) -> V,
    ) -> Outcome {
        self.allow(Call::Get)?;
        let (mut calculated, mut elements) = (false, false);
        for &reference in references {
            let variable = find(&self.table, reference, belongs)?;
            calculated |= !variable.causality.is_setting();
            elements |= variable.is_element();
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
            if let Some(found) = find(&self.table, reference, belongs)?.value(settings, readings) {
                *value = convert(found);
            }
        }
        Ok(())
    }

    fn set<V: Copy>(
        &mut self,
        references: &[u32],
        values: &[V],
        belongs: Belongs<U>,
        convert: fn(V) -> Value,
    ) -> Outcome {
        self.allow(Call::Set)?;
        self.allow_intermediate(references)?;
        check_count(references.len(), values.len(), references.len())?;
        let running = self.now.state.is_running();
        let mut has_tunable = false;
        for &reference in references {
            has_tunable |= self.check_writable(find(&self.table, reference, belongs)?)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            find(&self.table, reference, belongs)?.admit(convert(value))?;
        }
        // A tunable parameter must fit the others at once: no initialisation follows that would check it.
        let before = (running && has_tunable).then(|| self.now.settings.clone());
        for (&reference, &value) in references.iter().zip(values) {
            find(&self.table, reference, belongs)?.set(&mut self.now.settings, convert(value))?;
        }
        if let Some(before) = before
            && let Err(text) = U::check(&self.now.settings)
        {
            self.now.settings = before;
            return Err(CallError::Discarded(text));
        }
        if !running {
            self.now.unit = None;
        }
        Ok(())
    }

    /// Checks that a variable may be set now; whether it is a tunable parameter.
    fn check_writable(&self, variable: &Variable<U::Settings, U::Readings>) -> Result<bool, CallError> {
        let name = &variable.name;
        match variable.causality {
            Causality::Output | Causality::Local => {
                refused(Inadmissible::Calculated { name: name.clone() }.to_string())
            }
            Causality::Parameter if self.now.state.is_running() => {
                refused(format!("{name} is fixed once the run has started"))
            }
            _ if self.now.state == State::IntermediateUpdate && self.step_is_over() => {
                refused("the communication step has come to its end: set inputs after it")
            }
            causality => Ok(causality == Causality::Tunable),
        }
    }
}

/// The variable with a value reference, if it belongs to a type.
pub(super) fn find<S, R>(
    table: &Table<S, R>,
    reference: u32,
    belongs: fn(&Kind<S, R>) -> bool,
) -> Result<&Variable<S, R>, CallError> {
    match table.by_reference(reference) {
        None => match table.retired().iter().find(|retired| retired.reference == reference) {
            Some(retired) => refused(retired.to_string()),
            None => refused(format!("no variable has the value reference {reference}")),
        },
        Some(variable) if !belongs(&variable.kind) => refused(format!(
            "{} (value reference {reference}) has another type",
            variable.name
        )),
        Some(variable) => Ok(variable),
    }
}

/// Checks that there are as many values as the variables have together.
pub(super) fn check_count(variables: usize, values: usize, together: usize) -> Outcome {
    if values == together {
        return Ok(());
    }
    refused(format!(
        "{values} values for {variables} variables, which have {together} together"
    ))
}

/// The value reference of each of `count` values: scalars, the elements of arrays, and the time.
fn expand<'a, S, R>(table: &Table<S, R>, references: &'a [u32], count: usize) -> Result<Cow<'a, [u32]>, CallError> {
    let mut expanded = Cow::Borrowed(references);
    if references.iter().any(|reference| table.array_of(*reference).is_some()) {
        let mut elements = Vec::new();
        for &reference in references {
            match table.array_of(reference) {
                None => elements.push(reference),
                Some(array) if array.first == reference => elements.extend(array.elements()),
                Some(array) => {
                    return refused(format!(
                        "the value reference {reference} is that of an element of {}: use the array, value reference {}",
                        array.name, array.first
                    ));
                }
            }
        }
        expanded = Cow::Owned(elements);
    }
    check_count(references.len(), count, expanded.len())?;
    Ok(expanded)
}
