//! The variable table: all facts about a variable, and the field that holds its value.

use std::collections::BTreeMap;
use std::fmt::Display;

#[cfg(feature = "c")]
use num_traits::cast;

/// A physical unit: its name and its exponents over the SI base units and the radian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitDefinition {
    /// Name as variables use it, e.g. `N.m`.
    pub name: &'static str,
    /// Base units with their exponents in the attribute names of the standard, e.g.
    /// `[("kg", 1), ("m", 2), ("s", -2)]`.
    pub exponents: &'static [(&'static str, i32)],
    /// Units in which a user interface may show values: name and factor, shown = factor · value.
    pub display: &'static [(&'static str, f64)],
}

impl UnitDefinition {
    /// A unit without display units.
    #[must_use]
    pub const fn new(name: &'static str, exponents: &'static [(&'static str, i32)]) -> Self {
        Self {
            name,
            exponents,
            display: &[],
        }
    }

    /// The same unit with units in which values may be shown: name and factor.
    #[must_use]
    pub const fn shown_in(mut self, display: &'static [(&'static str, f64)]) -> Self {
        self.display = display;
        self
    }
}

/// One value of an enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Name that a user interface shows.
    pub name: &'static str,
    /// Number that is exchanged.
    pub value: i32,
    /// Its meaning.
    pub description: &'static str,
}

impl Item {
    /// A value with its name and meaning.
    #[must_use]
    pub const fn new(name: &'static str, value: i32, description: &'static str) -> Self {
        Self {
            name,
            value,
            description,
        }
    }
}

/// An enumeration type.
#[derive(Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type.
    pub name: &'static str,
    /// Description of the choice.
    pub description: &'static str,
    /// Values in ascending order.
    pub items: &'static [Item],
}

/// Who sets a variable, and when. Its variability follows: parameters are fixed or tunable, inputs,
/// outputs and locals are continuous if real and discrete otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set before the start.
    Parameter,
    /// A parameter that may also be changed between steps.
    Tunable,
    /// Set between steps; held over a step, or in proportion to time with an input derivative.
    Input,
    /// Calculated, for connections to other models.
    Output,
    /// Calculated, for plots and checks.
    Local,
}

impl Causality {
    /// Whether the importer writes the variable (and the unit only reads it).
    #[must_use]
    pub fn is_setting(self) -> bool {
        matches!(self, Self::Parameter | Self::Tunable | Self::Input)
    }
}

/// The field of a value: in the settings `S`, which the importer writes, or in the readings `R`,
/// which the unit writes.
pub enum Access<S, R, T> {
    /// A field of the settings.
    Setting {
        /// Reads the field.
        get: fn(&S) -> T,
        /// Writes the field.
        set: fn(&mut S, T),
    },
    /// A field of the readings.
    Reading(fn(&R) -> T),
    /// An element of an [`Array`] of the readings.
    Element(fn(&R, usize) -> T, usize),
}

/// Access to a field of the settings, by its name.
#[macro_export]
macro_rules! setting {
    ($($field:ident).+) => {
        $crate::table::Access::Setting {
            get: |settings| settings.$($field).+,
            set: |settings, value| settings.$($field).+ = value,
        }
    };
}

impl<S, R, T> Access<S, R, T> {
    /// The value; `None` for a reading without readings.
    fn read(&self, settings: &S, readings: Option<&R>) -> Option<T> {
        match self {
            Self::Setting { get, .. } => Some(get(settings)),
            Self::Reading(get) => readings.map(get),
            Self::Element(get, at) => readings.map(|readings| get(readings, *at)),
        }
    }

    fn write(&self, settings: &mut S, value: T) {
        if let Self::Setting { set, .. } = self {
            set(settings, value);
        }
    }
}

/// Limits and size of a real variable.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Range {
    /// Smallest value allowed.
    pub min: Option<f64>,
    /// Largest value allowed.
    pub max: Option<f64>,
    /// Typical size, for scaling.
    pub nominal: Option<f64>,
}

/// Values from a number on.
impl From<f64> for Range {
    fn from(min: f64) -> Self {
        Self {
            min: Some(min),
            ..Self::default()
        }
    }
}

impl Range {
    /// Values within limits.
    #[must_use]
    pub const fn between(min: f64, max: f64) -> Self {
        Self {
            min: Some(min),
            max: Some(max),
            nominal: None,
        }
    }

    /// Values without limits, of a typical size.
    #[must_use]
    pub const fn typical(nominal: f64) -> Self {
        Self {
            min: None,
            max: None,
            nominal: Some(nominal),
        }
    }

    /// The same limits with a typical size.
    #[must_use]
    pub const fn with_nominal(mut self, nominal: f64) -> Self {
        self.nominal = Some(nominal);
        self
    }

    /// The allowed values, for an error text.
    fn text(&self, unit: &str) -> String {
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        match (self.min, self.max) {
            (Some(min), Some(max)) => format!("{min} to {max}{unit}"),
            (Some(min), None) => format!("at least {min}{unit}"),
            (None, Some(max)) => format!("at most {max}{unit}"),
            (None, None) => String::new(),
        }
    }
}

/// Type of a variable, with limits and field.
pub enum Kind<S, R> {
    /// A real number.
    Real {
        /// Name of a unit of [`Table::units`].
        unit: &'static str,
        /// Name of a display unit of that unit.
        display_unit: Option<&'static str>,
        /// Limits and size of the value.
        range: Range,
        /// The field of the value.
        access: Access<S, R, f64>,
    },
    /// A whole number.
    Integer {
        /// Smallest and largest value allowed.
        range: Option<(i32, i32)>,
        /// The field of the value.
        access: Access<S, R, i32>,
    },
    /// True or false.
    Boolean {
        /// The field of the value.
        access: Access<S, R, bool>,
    },
    /// Enumeration, exchanged as an integer.
    Enumeration {
        /// The values that the variable can have.
        of: &'static Enumeration,
        /// The field of the value's number.
        access: Access<S, R, i32>,
    },
}

/// A value of any type. Whole numbers have more bits here than in a variable: those beyond its
/// range are refused with the range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Of a real variable.
    Real(f64),
    /// Of a whole number or an enumeration.
    Integer(i64),
    /// Of a truth value.
    Boolean(bool),
}

impl Value {
    /// As a number of C; a truth value is 0 or 1.
    #[cfg(feature = "c")]
    pub(crate) fn number<N: num_traits::NumCast>(self) -> Option<N> {
        match self {
            Self::Real(value) => cast(value),
            Self::Integer(value) => cast(value),
            Self::Boolean(value) => cast(u8::from(value)),
        }
    }
}

impl Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Real(value) => value.fmt(f),
            Self::Integer(value) => value.fmt(f),
            Self::Boolean(value) => value.fmt(f),
        }
    }
}

/// A variable.
pub struct Variable<S, R> {
    /// Name, structured by dots and brackets.
    pub name: String,
    /// Value reference: the handle of the variable, which never changes.
    pub reference: u32,
    /// What the variable is, in one phrase.
    pub description: String,
    /// Who sets the variable, and when.
    pub causality: Causality,
    /// Type, limits and field.
    pub kind: Kind<S, R>,
}

/// Refusal of a value that is NaN or infinite.
pub(crate) fn not_finite(name: &str, value: f64) -> String {
    format!("{name} = {value} is not a finite number")
}

/// An input that exceeds a limit by less than this, in its unit, is set to the limit. Another model
/// that ends at zero may leave a rounding error below it.
const ROUNDING: f64 = 1.0e-6;

impl<S, R> Variable<S, R> {
    /// A real variable without limits, in a unit of [`Table::units`].
    #[must_use]
    pub fn real(
        reference: u32,
        name: &str,
        description: &str,
        causality: Causality,
        unit: &'static str,
        access: Access<S, R, f64>,
    ) -> Self {
        Self {
            name: name.into(),
            reference,
            description: description.into(),
            causality,
            kind: Kind::Real {
                unit,
                display_unit: None,
                range: Range::default(),
                access,
            },
        }
    }

    /// The same with other limits, if it is real.
    #[must_use]
    pub fn with_range(mut self, limits: Range) -> Self {
        if let Kind::Real { range, .. } = &mut self.kind {
            *range = limits;
        }
        self
    }

    /// The value; `None` for a calculated variable without readings.
    pub fn value(&self, settings: &S, readings: Option<&R>) -> Option<Value> {
        match &self.kind {
            Kind::Real { access, .. } => access.read(settings, readings).map(Value::Real),
            Kind::Integer { access, .. } | Kind::Enumeration { access, .. } => {
                let number = access.read(settings, readings)?;
                Some(Value::Integer(number.into()))
            }
            Kind::Boolean { access } => access.read(settings, readings).map(Value::Boolean),
        }
    }

    /// Whether it can be set or read in intermediate update mode: real inputs and outputs can.
    pub(crate) fn is_intermediate(&self) -> bool {
        matches!(self.kind, Kind::Real { .. })
            && matches!(self.causality, Causality::Input | Causality::Output)
    }

    /// Sets a setting to a value of its type, if that is within its limits. A number is a truth
    /// value, too: all but 0 is true.
    ///
    /// # Errors
    /// The variable is no setting, or the value is not finite, not an item of the enumeration, or
    /// out of range, by more than rounding where the variable is an input: a sentence with name,
    /// value and allowed range. Nothing has changed.
    pub fn set(&self, settings: &mut S, value: Value) -> Result<(), String> {
        if !self.causality.is_setting() {
            return Err(format!("{} is calculated and can't be set", self.name));
        }
        self.write(settings, self.admit(value)?);
        Ok(())
    }

    /// Sets a setting to a value of its type, whatever its limits.
    pub(crate) fn write(&self, settings: &mut S, value: Value) {
        match (&self.kind, value) {
            (Kind::Real { access, .. }, Value::Real(value)) => access.write(settings, value),
            (Kind::Integer { access, .. } | Kind::Enumeration { access, .. }, Value::Integer(value)) => {
                access.write(settings, i32::try_from(value).unwrap_or_default());
            }
            (Kind::Boolean { access }, Value::Boolean(value)) => access.write(settings, value),
            _ => {}
        }
    }

    /// Checks a value against the limits; the value to be set.
    fn admit(&self, value: Value) -> Result<Value, String> {
        let range = match (&self.kind, value) {
            (Kind::Real { unit, range, .. }, Value::Real(number)) => {
                if !number.is_finite() {
                    return Err(not_finite(&self.name, number));
                }
                let exceeded = match (range.min, range.max) {
                    (Some(min), _) if number < min => min,
                    (_, Some(max)) if number > max => max,
                    _ => return Ok(value),
                };
                if self.causality == Causality::Input && (number - exceeded).abs() < ROUNDING {
                    return Ok(Value::Real(exceeded));
                }
                range.text(unit)
            }
            (Kind::Integer { range, .. }, Value::Integer(number)) => {
                let (min, max) = range.unwrap_or((i32::MIN, i32::MAX));
                if (i64::from(min)..=i64::from(max)).contains(&number) {
                    return Ok(value);
                }
                format!("{min} to {max}")
            }
            (Kind::Enumeration { of, .. }, Value::Integer(number)) => {
                if of.items.iter().any(|item| i64::from(item.value) == number) {
                    return Ok(value);
                }
                let items = of.items.iter().map(|item| format!("{} {}", item.value, item.name));
                items.collect::<Vec<_>>().join(", ")
            }
            (Kind::Boolean { .. }, Value::Integer(number)) => return Ok(Value::Boolean(number != 0)),
            _ => return Ok(value),
        };
        Err(format!("{} = {value} is out of range: {range}", self.name))
    }
}

/// Variables that are the elements of an array. FMI 2.0 has elements only, FMI 3.0 has the array:
/// apart from name and description, its attributes are those of its first element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// Name without index.
    pub name: String,
    /// What the array is, in one phrase.
    pub description: String,
    /// Value reference of the first element; those of the others follow.
    pub first: u32,
    /// Number of elements.
    pub size: u32,
}

impl Array {
    /// The value references of its elements.
    #[must_use]
    pub fn elements(&self) -> std::ops::RangeInclusive<u32> {
        self.first..=self.first + (self.size - 1)
    }
}

/// Added to the value reference of an element of an array: the element as a scalar of FMI 3.0, where
/// its own means the array. Copies of a description for importers that read no arrays have these.
pub const SCALARS: u32 = 1_000_000;

/// Added to the value reference of a calculated truth value: 1 or 0 as a real number. Copies of a
/// description for importers that read all outputs as real numbers have these.
pub const REALS: u32 = 2_000_000;

/// All variables of a unit, with the units and enumerations they use. Value references are below
/// [`SCALARS`].
pub struct Table<S, R> {
    /// The units that variables use.
    pub units: Vec<UnitDefinition>,
    /// Every enumeration that a variable uses.
    pub enumerations: &'static [&'static Enumeration],
    /// Arrays that some of the variables are elements of.
    pub arrays: Vec<Array>,
    /// Variables of earlier versions, for the messages of those who still use them.
    pub retired: &'static [Retired],
    /// Dependencies of some outputs in initialisation mode. Each other output depends on all
    /// settings.
    pub initial: &'static [InitialDependencies],
    variables: Vec<Variable<S, R>>,
    /// Index in `variables` of each value reference. A hash map would get its seed from the
    /// operating system, by a library that some Windows compatibility layers lack.
    by_reference: BTreeMap<u32, usize>,
}

/// A calculated variable, and the settings on which it depends in initialisation mode, by their
/// names.
pub type InitialDependencies = (&'static str, &'static [&'static str]);

/// A variable that an earlier version had. Its value reference is not given again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name} (value reference {reference}) was removed: {instead}")]
pub struct Retired {
    /// Its name.
    pub name: &'static str,
    /// Its value reference.
    pub reference: u32,
    /// The replacement for the user, as a sentence without a full stop.
    pub instead: &'static str,
}

impl<S, R> Table<S, R> {
    /// A table of these variables, in the order in which they appear in the description. It
    /// declares those of the `units` that they use.
    #[must_use]
    pub fn new(
        units: &'static [UnitDefinition],
        enumerations: &'static [&'static Enumeration],
        variables: Vec<Variable<S, R>>,
    ) -> Self {
        let numbered = variables.iter().enumerate();
        let by_reference = numbered.map(|(index, variable)| (variable.reference, index)).collect();
        let is_used = |name| {
            variables
                .iter()
                .any(|variable| matches!(variable.kind, Kind::Real { unit, .. } if unit == name))
        };
        Self {
            units: units.iter().filter(|unit| is_used(unit.name)).copied().collect(),
            enumerations,
            variables,
            arrays: Vec::new(),
            by_reference,
            retired: &[],
            initial: &[],
        }
    }

    /// The indices of the settings on which a variable depends in initialisation mode, in order;
    /// `None` if it depends on all.
    #[must_use]
    pub fn initial_dependencies(&self, variable: &Variable<S, R>) -> Option<Vec<usize>> {
        let (_, settings) = self.initial.iter().find(|(name, _)| *name == variable.name)?;
        let numbered = self.variables.iter().enumerate();
        let known = numbered.filter(|(_, one)| settings.contains(&one.name.as_str()));
        Some(known.map(|(index, _)| index).collect())
    }

    /// The array that a variable with this value reference is an element of.
    #[must_use]
    pub fn array_of(&self, reference: u32) -> Option<&Array> {
        self.arrays.iter().find(|array| array.elements().contains(&reference))
    }

    /// The variables in order.
    #[must_use]
    pub fn variables(&self) -> &[Variable<S, R>] {
        &self.variables
    }

    /// The variable with a value reference, also as a scalar or as a real number.
    #[must_use]
    pub fn by_reference(&self, reference: u32) -> Option<&Variable<S, R>> {
        let find = |own| self.by_reference.get(&own).map(|index| &self.variables[*index]);
        match reference {
            ..SCALARS => find(reference),
            SCALARS..REALS => find(reference - SCALARS).filter(|one| self.array_of(one.reference).is_some()),
            REALS.. => find(reference - REALS)
                .filter(|one| matches!(one.kind, Kind::Boolean { .. }) && !one.causality.is_setting()),
        }
    }

    /// The variable with a name.
    #[must_use]
    pub fn by_name(&self, name: &str) -> Option<&Variable<S, R>> {
        self.variables.iter().find(|variable| variable.name == name)
    }
}
