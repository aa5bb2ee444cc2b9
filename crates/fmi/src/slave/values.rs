//! Reading and writing of variables.

use std::borrow::Cow;

use super::error::{CallError, Outcome, refused};
use super::instance::{Slave, Version};
use super::snapshot::Snapshot;
use crate::state::{Call, State};
use crate::table::{Causality, Kind, Table, Value, Variable};
use crate::unit::Unit;

/// Value reference of the time in FMI 3.0, which no variable of a table has.
pub(crate) const TIME: u32 = 0;

/// Types of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// `fmi2Real`, `fmi3Float64`.
    Real,
    /// `fmi2Integer`: whole numbers and enumerations.
    IntegerOrEnumeration,
    /// `fmi3Int32`: whole numbers.
    Integer,
    /// `fmi3Int64`: enumerations.
    Enumeration,
    /// `fmi2Boolean`, `fmi3Boolean`.
    Boolean,
}

impl Type {
    /// Whether variables of a kind have this type.
    fn includes<S, R>(self, kind: &Kind<S, R>) -> bool {
        match kind {
            Kind::Real { .. } => self == Self::Real,
            Kind::Integer { .. } => matches!(self, Self::Integer | Self::IntegerOrEnumeration),
            Kind::Enumeration { .. } => matches!(self, Self::Enumeration | Self::IntegerOrEnumeration),
            Kind::Boolean { .. } => self == Self::Boolean,
        }
    }
}

/// A number that C functions exchange; a truth value is 0 or 1, and all but 0 is true.
pub trait Number: Copy {
    /// The number for a value.
    fn from_value(value: Value) -> Self;
    /// The value of a variable of a type.
    fn to_value(self, of: Type) -> Value;
}

impl Number for f64 {
    fn from_value(value: Value) -> Self {
        match value {
            Value::Real(value) => value,
            Value::Integer(_) | Value::Boolean(_) => Self::NAN,
        }
    }

    fn to_value(self, _: Type) -> Value {
        Value::Real(self)
    }
}

macro_rules! whole_numbers {
    ($($type:ty),*) => {$(
        impl Number for $type {
            fn from_value(value: Value) -> Self {
                match value {
                    Value::Integer(value) => Self::try_from(value).unwrap_or_default(),
                    Value::Boolean(value) => value.into(),
                    Value::Real(_) => 0,
                }
            }

            fn to_value(self, of: Type) -> Value {
                match of {
                    Type::Boolean => Value::Boolean(self != 0),
                    _ => Value::Integer(self.into()),
                }
            }
        }
    )*};
}

whole_numbers!(u8, i32, i64);

impl<U: Unit> Slave<U> {
    /// Reads reals, arrays of reals and the time, in FMI 3.0.
    pub fn get_float64(&mut self, references: &[u32], values: &mut [f64]) -> Outcome {
        self.allow_intermediate(references)?;
        let expanded = expand(&self.table, references, values.len())?;
        self.read(Type::Real, &expanded, values)
    }

    /// Writes reals and arrays of reals, in FMI 3.0.
    pub fn set_float64(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        let expanded = expand(&self.table, references, values.len())?;
        if expanded.contains(&TIME) {
            return refused("time can't be set");
        }
        self.set(Type::Real, &expanded, values)
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
                 variables that fmi3InstantiateCoSimulation was given, or does not support this mode"
            )),
            _ => Ok(()),
        }
    }

    /// Reads variables of a type, one value each.
    pub fn get<N: Number>(&mut self, of: Type, references: &[u32], values: &mut [N]) -> Outcome {
        self.allow_intermediate(references)?;
        check_count(references.len(), values.len(), references.len())?;
        self.read(of, references, values)
    }

    /// The same for references that are allowed in the present mode, the time in FMI 3.0 among them.
    fn read<N: Number>(&mut self, of: Type, references: &[u32], values: &mut [N]) -> Outcome {
        self.allow(Call::Get)?;
        let time = (of == Type::Real && self.master.version == Version::Three).then(|| Value::Real(self.time()));
        let (mut calculated, mut elements) = (false, false);
        for &reference in references {
            if reference == TIME && time.is_some() {
                continue;
            }
            let variable = find(&self.table, reference, of)?;
            calculated |= !variable.causality.is_setting();
            elements |= self.table.array_of(reference).is_some();
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
            let found = match time {
                Some(_) if reference == TIME => time,
                _ => find(&self.table, reference, of)?.value(settings, readings),
            };
            if let Some(found) = found {
                *value = N::from_value(found);
            }
        }
        Ok(())
    }

    /// Writes variables of a type, one value each: either all values are set or none.
    pub fn set<N: Number>(&mut self, of: Type, references: &[u32], values: &[N]) -> Outcome {
        self.allow(Call::Set)?;
        self.allow_intermediate(references)?;
        check_count(references.len(), values.len(), references.len())?;
        let running = self.now.state.is_running();
        let mut has_tunable = false;
        for &reference in references {
            has_tunable |= self.check_writable(find(&self.table, reference, of)?)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            let admitted = find(&self.table, reference, of)?.admit(value.to_value(of));
            admitted.map_err(CallError::Discarded)?;
        }
        // A tunable parameter is checked against the others at once, because no initialisation follows.
        let before = (running && has_tunable).then(|| self.now.settings.clone());
        for (&reference, &value) in references.iter().zip(values) {
            let set = find(&self.table, reference, of)?.set(&mut self.now.settings, value.to_value(of));
            set.map_err(CallError::Discarded)?;
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
            Causality::Output | Causality::Local => refused(format!("{name} is calculated and can't be set")),
            Causality::Parameter if self.now.state.is_running() => {
                refused(format!("{name} is fixed once the run has started"))
            }
            _ if self.now.state == State::IntermediateUpdate && self.step_is_over() => {
                refused("the communication step has reached its end: set inputs after it")
            }
            causality => Ok(causality == Causality::Tunable),
        }
    }
}

/// The variable with a value reference, if it has this type.
pub(super) fn find<S, R>(table: &Table<S, R>, reference: u32, of: Type) -> Result<&Variable<S, R>, CallError> {
    match table.by_reference(reference) {
        None => match table.retired.iter().find(|retired| retired.reference == reference) {
            Some(retired) => refused(retired.to_string()),
            None => refused(format!("no variable has the value reference {reference}")),
        },
        Some(variable) if !of.includes(&variable.kind) => refused(format!(
            "{} (value reference {reference}) has another type",
            variable.name
        )),
        Some(variable) => Ok(variable),
    }
}

/// Checks that the number of values is that of all variables together.
pub(super) fn check_count(variables: usize, values: usize, together: usize) -> Outcome {
    if values == together {
        return Ok(());
    }
    refused(format!(
        "{values} values for {variables} variables, which have {together} values together"
    ))
}

/// The value reference of each of `count` values: scalars, the elements of arrays, and the time.
fn expand<'a, S, R>(table: &Table<S, R>, references: &'a [u32], count: usize) -> Result<Cow<'a, [u32]>, CallError> {
    let mut together = 0;
    for &reference in references {
        match table.array_of(reference) {
            None => together += 1,
            Some(array) if array.first == reference => together += array.elements().len(),
            Some(array) => {
                return refused(format!(
                    "the value reference {reference} is that of an element of {}: use the array, value reference {}",
                    array.name, array.first
                ));
            }
        }
    }
    // Before memory is taken.
    check_count(references.len(), count, together)?;
    if together == references.len() {
        return Ok(Cow::Borrowed(references));
    }
    // As many as a host asks for.
    let mut expanded = Vec::new();
    if let Err(error) = expanded.try_reserve_exact(together) {
        return refused(format!("memory for {together} values: {error}"));
    }
    for &reference in references {
        match table.array_of(reference) {
            None => expanded.push(reference),
            Some(array) => expanded.extend(array.elements()),
        }
    }
    Ok(Cow::Owned(expanded))
}
