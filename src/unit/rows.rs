//! The rows of the variable table while it is built.

use super::settings::{Settings, StandardRings};
use crate::fmi::table::{Access, Array, Causality, Enumeration, Kind, Range, Variable};
use crate::variator::settings::{PROFILE_POINTS, Readings, range_of};

use Causality::{Local, Output, Parameter};

/// The pulley of the rows that follow: the name that replaces `{}`, and the number that is added to the references.
pub(super) type Owner = (&'static str, u32);
pub(super) const WHOLE: Owner = ("", 0);
pub(super) const PRIMARY: Owner = ("primary", 100);
pub(super) const SECONDARY: Owner = ("secondary", 200);

/// The rows of the table so far, and the pulley of the next ones.
pub struct Rows<R = StandardRings> {
    pub(super) variables: Vec<Variable<Settings<R>, Readings>>,
    pub(super) arrays: Vec<Array>,
    owner: Owner,
}

impl<R> Rows<R> {
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

    fn range(&self, name: &str) -> Option<(f64, f64)> {
        range_of(&name.replace("{}", self.owner.0))
    }

    pub(super) fn add(
        &mut self,
        name: &str,
        reference: u32,
        causality: Causality,
        text: &str,
        kind: Kind<Settings<R>, Readings>,
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

    /// A real parameter or input.
    pub(super) fn set(
        &mut self,
        name: &str,
        reference: u32,
        causality: Causality,
        unit: &'static str,
        text: &str,
        access: Access<Settings<R>, Readings, f64>,
    ) {
        let (min, max) = self.range(name).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let range = Range {
            min: min.is_finite().then_some(min),
            max: max.is_finite().then_some(max),
            nominal: None,
        };
        let kind = Kind::Real {
            unit,
            display_unit: display_unit(name, unit),
            range,
            access,
        };
        self.add(name, reference, causality, text, kind);
    }

    /// A real output or local, with its limits and typical size.
    pub(super) fn read(
        &mut self,
        name: &str,
        reference: u32,
        (causality, unit, range): (Causality, &'static str, Range),
        text: &str,
        access: Access<Settings<R>, Readings, f64>,
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
    pub fn count(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings<R>, Readings, i32>) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the limits of integers are small whole numbers"
        )]
        let range = self.range(name).map(|(min, max)| (min as i32, max as i32));
        self.add(name, reference, Parameter, text, Kind::Integer { range, access });
    }

    /// An output that is a count.
    pub(super) fn work(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings<R>, Readings, i32>) {
        self.add(name, reference, Output, text, Kind::Integer { range: None, access });
    }

    /// A Boolean parameter.
    pub fn switch(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings<R>, Readings, bool>) {
        self.add(name, reference, Parameter, text, Kind::Boolean { access });
    }

    /// A parameter that is an item of the enumeration `of`.
    pub fn choice(
        &mut self,
        name: &str,
        reference: u32,
        of: &'static Enumeration,
        text: &str,
        access: Access<Settings<R>, Readings, i32>,
    ) {
        self.add(name, reference, Parameter, text, Kind::Enumeration { of, access });
    }

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
