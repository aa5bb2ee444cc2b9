//! The rows of the variable table while it is built.

use super::settings::{Settings, StandardRings};
use crate::fmi::table::{Access, Array, Causality, Enumeration, Kind, Range, Variable};
use crate::variator::settings::{InputRows, PROFILE_POINTS, ParameterRows, Readings, Row, RowField, RowValue};

use Causality::{Local, Output, Parameter};

/// The pulley of the rows that follow: the name that replaces `{}`, and the number that is added to the references.
pub(super) type Owner = (&'static str, u32);
pub(super) const WHOLE: Owner = ("", 0);
pub(super) const PRIMARY: Owner = ("primary", 100);
pub(super) const SECONDARY: Owner = ("secondary", 200);

/// The rows of the table so far, and the pulley of the next ones.
pub struct Rows<R = StandardRings, Q = Readings> {
    /// The variables.
    pub variables: Vec<Variable<Settings<R>, Q>>,
    pub(super) arrays: Vec<Array>,
    owner: Owner,
}

impl<R: 'static, Q> Rows<R, Q> {
    /// All inputs.
    pub(super) fn inputs(&mut self) {
        self.settings(PRIMARY, InputRows::PRIMARY);
        self.settings(SECONDARY, InputRows::SECONDARY);
        self.of(WHOLE);
    }

    /// All parameters but for `ring.model`.
    pub(super) fn parameters(&mut self) {
        self.settings(WHOLE, ParameterRows::WHOLE);
        self.settings(PRIMARY, ParameterRows::PRIMARY);
        self.settings(SECONDARY, ParameterRows::SECONDARY);
        self.of(WHOLE);
    }

    fn settings(&mut self, owner: Owner, rows: &[Row<Settings<R>>]) {
        fn access<S, Q, T>(field: &RowField<S, T>) -> Access<S, Q, T> {
            Access::Setting {
                get: field.get,
                set: field.set,
            }
        }
        self.of(owner);
        for row in rows {
            let kind = match &row.value {
                RowValue::Real(unit, _, [min, max], field) => Kind::Real {
                    unit,
                    display_unit: display_unit(row.name, unit),
                    range: Range {
                        min: min.is_finite().then_some(*min),
                        max: max.is_finite().then_some(*max),
                        nominal: None,
                    },
                    access: access(field),
                },
                RowValue::Count(_, [min, max], field) => Kind::Integer {
                    range: Some((*min, *max)),
                    access: access(field),
                },
                RowValue::Switch(_, field) => Kind::Boolean { access: access(field) },
                RowValue::Choice(of, _, field) => Kind::Enumeration {
                    of,
                    access: access(field),
                },
            };
            self.add(row.name, row.reference, row.causality, row.text, kind);
        }
    }
}

impl<R, Q> Rows<R, Q> {
    /// No rows.
    pub(super) fn new() -> Self {
        Self {
            variables: Vec::new(),
            arrays: Vec::new(),
            owner: WHOLE,
        }
    }

    pub(super) fn of(&mut self, owner: Owner) {
        self.owner = owner;
    }

    pub(super) fn add(
        &mut self,
        name: &str,
        reference: u32,
        causality: Causality,
        text: &str,
        kind: Kind<Settings<R>, Q>,
    ) {
        let (owner, base) = self.owner;
        self.variables.push(Variable {
            name: name.replace("{}", owner),
            reference: base + reference,
            description: text.replace("{}", owner),
            causality,
            kind,
        });
    }

    /// A real output or local, with its limits and typical size.
    pub(super) fn read(
        &mut self,
        name: &str,
        reference: u32,
        (causality, unit, range): (Causality, &'static str, Range),
        text: &str,
        access: Access<Settings<R>, Q, f64>,
    ) {
        let kind = Kind::Real {
            unit,
            display_unit: display_unit(name, unit),
            range,
            access,
        };
        self.add(name, reference, causality, text, kind);
    }

    /// An integer parameter.
    pub fn count(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings<R>, Q, i32>) {
        self.add(name, reference, Parameter, text, Kind::Integer { range: None, access });
    }

    /// An output that is a count.
    pub(super) fn work(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings<R>, Q, i32>) {
        self.add(name, reference, Output, text, Kind::Integer { range: None, access });
    }

    /// A Boolean parameter.
    pub fn switch(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings<R>, Q, bool>) {
        self.add(name, reference, Parameter, text, Kind::Boolean { access });
    }

    /// A parameter that is an item of the enumeration `of`.
    pub fn choice(
        &mut self,
        name: &str,
        reference: u32,
        of: &'static Enumeration,
        text: &str,
        access: Access<Settings<R>, Q, i32>,
    ) {
        self.add(name, reference, Parameter, text, Kind::Enumeration { of, access });
    }
}

impl<R> Rows<R> {
    pub(super) fn profile(
        &mut self,
        name: &str,
        first: u32,
        unit: &'static str,
        nominal: f64,
        text: &str,
        get: fn(&Readings, usize) -> f64,
    ) {
        self.arrays.push(Array {
            name: format!("profile.{name}"),
            description: format!("{text} at xi = 0/{PROFILE_POINTS}, 1/{PROFILE_POINTS} and so on of the belt length"),
            first,
            size: u32::try_from(PROFILE_POINTS).unwrap_or(u32::MAX),
        });
        for (at, reference) in (0..PROFILE_POINTS).zip(first..) {
            let number = at + 1;
            self.read(
                &format!("profile.{name}[{number}]"),
                reference,
                (Local, unit, Range::typical(nominal)),
                &format!("{text} at xi = {at}/{PROFILE_POINTS} of the belt length"),
                Access::Element(get, at),
            );
        }
    }
}

/// Shares of a whole, which are shown in per cent.
const SHARES: [&str; 4] = ["slip", "efficiency", "efficiency.belt", "friction.fall"];

fn display_unit(name: &str, unit: &str) -> Option<&'static str> {
    match unit {
        "rad" => Some("deg"),
        "rad/s" => Some("rpm"),
        "m" => Some("mm"),
        "N" => Some("kN"),
        "Pa" if name.ends_with("pressure") => Some("bar"),
        "Pa" => Some("MPa"),
        "1" if SHARES.contains(&name) => Some("%"),
        _ => None,
    }
}
