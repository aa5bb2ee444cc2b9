//! Reading and writing of variables.

use std::mem::MaybeUninit;

use num_traits::{NumCast, ToPrimitive};

use super::calls::FmuInstance;
use super::snapshot::Snapshot;
use super::{CallError, Outcome, refused};
use crate::description::{TIME, Version};
use crate::state::{Call, State};
use crate::table::{Causality, Kind, REALS, Table, Value, Variable};
use crate::unit::Unit;

/// Types of the interface.
#[derive(Clone, Copy, PartialEq, Eq)]
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
    fn includes<S, R>(self, kind: &Kind<S, R>) -> bool {
        match kind {
            Kind::Real { .. } => self == Self::Real,
            Kind::Integer { .. } => matches!(self, Self::Integer | Self::IntegerOrEnumeration),
            Kind::Enumeration { .. } => matches!(self, Self::Enumeration | Self::IntegerOrEnumeration),
            Kind::Boolean { .. } => self == Self::Boolean,
        }
    }
}

impl<U: Unit> FmuInstance<U> {
    /// Reads or writes variables of a type that no variable has.
    ///
    /// # Errors
    /// There is a value reference.
    pub fn no_such_type(&mut self, call: Call, references: &[u32], type_name: &str) -> Outcome {
        self.allow(call)?;
        match references.first() {
            None => Ok(()),
            Some(reference) => refused(format!("no {type_name} has the value reference {reference}")),
        }
    }

    /// In intermediate update mode, refuses variables that were not announced for it.
    pub(super) fn allow_intermediate(&self, references: &[u32]) -> Outcome {
        let announced =
            |reference: &u32| *reference == TIME || self.importer.intermediate.contains(reference);
        match references.iter().find(|reference| !announced(reference)) {
            Some(other) if self.now.state == State::IntermediateUpdate => refused(format!(
                "in intermediate update mode, and the value reference {other} is not among the required \
                 intermediate variables that fmi3InstantiateCoSimulation was given, or does not support this mode"
            )),
            _ => Ok(()),
        }
    }

    /// Reads variables of a type, in FMI 3.0 the time among them.
    ///
    /// # Errors
    /// A variable does not exist or has another type, or the number of values is wrong; or the unit
    /// does not start, and the instance has failed.
    pub fn get<N: NumCast>(
        &mut self,
        of: Type,
        references: &[u32],
        values: &mut [MaybeUninit<N>],
    ) -> Outcome {
        self.allow_intermediate(references)?;
        self.check_values(references, values.len())?;
        self.allow(Call::Get)?;
        let version = self.importer.version;
        let time = (of == Type::Real && version == Version::Three).then(|| Value::Real(self.time()));
        let (mut calculated, mut elements) = (false, false);
        for &reference in references.iter().filter(|one| **one != TIME || time.is_none()) {
            let variable = find(&self.table, reference, of)?;
            calculated |= !variable.causality.is_setting();
            elements |= self.table.array_of(variable.reference).is_some();
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
        for (reference, value) in value_references(version, &self.table, references).zip(values) {
            let found = match time {
                Some(_) if reference == TIME => time,
                _ => find(&self.table, reference, of)?.value(settings, readings),
            };
            if let Some(found) = found.and_then(Value::number) {
                value.write(found);
            }
        }
        Ok(())
    }

    /// Writes variables of a type: either all values are set or none.
    ///
    /// # Errors
    /// A variable does not exist, has another type or can't be set now, or the number of values is
    /// wrong; or a value is out of range, and it is discarded.
    pub fn set<N: ToPrimitive>(&mut self, of: Type, references: &[u32], values: &[N]) -> Outcome {
        self.allow(Call::Set)?;
        self.allow_intermediate(references)?;
        self.check_values(references, values.len())?;
        let mut has_tunable = false;
        for &reference in references {
            has_tunable |= self.check_writable(find(&self.table, reference, of)?)?;
        }
        let mut settings = self.now.settings.clone();
        for (reference, value) in value_references(self.importer.version, &self.table, references).zip(values)
        {
            let value = match of {
                Type::Real => Value::Real(value.to_f64().unwrap_or(f64::NAN)),
                _ => Value::Integer(value.to_i64().unwrap_or(i64::MAX)),
            };
            let set = find(&self.table, reference, of)?.set(&mut settings, value);
            set.map_err(CallError::Discarded)?;
        }
        if !self.now.state.is_running() {
            self.now.unit = None;
        } else if has_tunable {
            // Checked against the others at once, because no initialisation follows.
            U::check(&settings).map_err(CallError::Discarded)?;
        }
        self.now.settings = settings;
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

    /// Checks that there is a value for each scalar, the time, and in FMI 3.0 each element of an
    /// array.
    fn check_values(&self, references: &[u32], values: usize) -> Outcome {
        let mut arrays = references
            .iter()
            .filter_map(|one| Some((*one, self.table.array_of(*one)?)));
        if let Some((element, array)) = arrays.find(|(one, array)| *one != array.first)
            && self.importer.version == Version::Three
        {
            return refused(format!(
                "the value reference {element} is that of an element of {}: use the array, value \
                 reference {}",
                array.name, array.first
            ));
        }
        check_count(
            references.len(),
            values,
            value_references(self.importer.version, &self.table, references).count(),
        )
    }
}

/// The value reference of each value: in FMI 3.0 those of an array's elements for that of the
/// array.
fn value_references<S, R>(
    version: Version,
    table: &Table<S, R>,
    references: &[u32],
) -> impl Iterator<Item = u32> {
    references
        .iter()
        .flat_map(move |&reference| match table.array_of(reference) {
            Some(array) if version == Version::Three => array.elements(),
            _ => reference..=reference,
        })
}

/// The variable with a value reference, if it has this type.
///
/// # Errors
/// No variable has it, or another type.
pub(super) fn find<S, R>(
    table: &Table<S, R>,
    reference: u32,
    of: Type,
) -> Result<&Variable<S, R>, CallError> {
    match table.by_reference(reference) {
        None if reference == TIME => refused(
            "time (value reference 0) is the independent variable: it can't be set, and only \
             fmi3GetFloat64 reads it",
        ),
        None => match table.retired.iter().find(|retired| retired.reference == reference) {
            Some(retired) => refused(retired.to_string()),
            None => refused(format!("no variable has the value reference {reference}")),
        },
        Some(variable) if of == Type::Real && reference >= REALS => Ok(variable),
        Some(variable) if !of.includes(&variable.kind) => refused(format!(
            "{} (value reference {reference}) has another type",
            variable.name
        )),
        Some(variable) => Ok(variable),
    }
}

/// Checks that the number of values is that of all variables together.
///
/// # Errors
/// It is another one.
pub(super) fn check_count(variables: usize, values: usize, together: usize) -> Outcome {
    if values == together {
        return Ok(());
    }
    refused(format!(
        "{values} values for {variables} variables, which have {together} values together"
    ))
}
