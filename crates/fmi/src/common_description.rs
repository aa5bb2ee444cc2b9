//! What the descriptions of both versions have in common: units, enumerations, log categories, variables.

use std::io::{self, Write};

use quick_xml::writer::Writer;

use super::hash::Fnv;
use super::log::Category;
use super::table::{Causality, Enumeration, Kind, UnitDefinition, Value, Variable};
use super::unit::Identity;
use super::xml::{Attributes, empty, number, parent, token};

/// A description that `write` writes with the token it is given: [`token_of`] it.
pub(super) fn text_of(write: impl Fn(&mut dyn Write, &str) -> io::Result<()>) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes, &token_of(&write)).expect("memory takes all bytes");
    String::from_utf8(bytes).expect("the writer is given text only")
}

/// A hash of that description, so that description and binary fit each other.
pub(super) fn token_of(write: impl Fn(&mut dyn Write, &str) -> io::Result<()>) -> String {
    let mut hash = Fnv::default();
    write(&mut hash, "").expect("a hash takes all bytes");
    token(&hash)
}

/// Attributes of the whole, for a version of the standard with its token.
pub(super) fn head(identity: &Identity, version: &str, (token, value): (&'static str, &str)) -> Attributes {
    vec![
        ("fmiVersion", version.into()),
        ("modelName", identity.name.into()),
        (token, value.into()),
        ("description", identity.description.into()),
        ("author", identity.author.into()),
        ("version", identity.version.into()),
        ("license", identity.license.into()),
        ("generationTool", identity.generation_tool.into()),
        ("variableNamingConvention", "structured".into()),
    ]
}

pub(super) fn default_experiment(identity: &Identity) -> Attributes {
    vec![
        ("startTime", "0".into()),
        ("stopTime", number(identity.stop_time)),
        ("tolerance", number(identity.tolerance)),
        ("stepSize", number(identity.step_size)),
    ]
}

/// Every unit, with its display units.
pub(super) fn unit_definitions<W: Write>(xml: &mut Writer<W>, units: &[UnitDefinition]) -> io::Result<()> {
    if units.is_empty() {
        return Ok(());
    }
    parent(xml, "UnitDefinitions", vec![], |xml| {
        units.iter().try_for_each(|unit| unit_definition(xml, unit))
    })
}

fn unit_definition<W: Write>(xml: &mut Writer<W>, unit: &UnitDefinition) -> io::Result<()> {
    parent(xml, "Unit", vec![("name", unit.name.into())], |xml| {
        let exponents = unit
            .exponents
            .iter()
            .map(|(base, exponent)| (*base, exponent.to_string()));
        empty(xml, "BaseUnit", exponents.collect())?;
        unit.display.iter().try_for_each(|(name, factor)| {
            let display: Attributes = vec![("name", (*name).into()), ("factor", number(*factor))];
            empty(xml, "DisplayUnit", display)
        })
    })
}

/// Every enumeration, written by `write`.
pub(super) fn type_definitions<W: Write>(
    xml: &mut Writer<W>,
    enumerations: &[&Enumeration],
    write: impl Fn(&mut Writer<W>, &Enumeration) -> io::Result<()>,
) -> io::Result<()> {
    if enumerations.is_empty() {
        return Ok(());
    }
    parent(xml, "TypeDefinitions", vec![], |xml| {
        enumerations.iter().try_for_each(|enumeration| write(xml, enumeration))
    })
}

/// Attributes of an enumeration's type.
pub(super) fn enumeration_head(enumeration: &Enumeration) -> Attributes {
    vec![
        ("name", enumeration.name.into()),
        ("description", enumeration.description.into()),
    ]
}

/// The items of an enumeration.
pub(super) fn enumeration_items<W: Write>(xml: &mut Writer<W>, enumeration: &Enumeration) -> io::Result<()> {
    enumeration.items.iter().try_for_each(|item| {
        let item: Attributes = vec![
            ("name", item.name.into()),
            ("value", item.value.to_string()),
            ("description", item.description.into()),
        ];
        empty(xml, "Item", item)
    })
}

/// Every log category, described by `describe`.
pub(super) fn log_categories<W: Write>(
    xml: &mut Writer<W>,
    describe: impl Fn(Category) -> &'static str,
) -> io::Result<()> {
    parent(xml, "LogCategories", vec![], |xml| {
        Category::ALL.into_iter().try_for_each(|category| {
            let category: Attributes = vec![
                ("name", category.name().into()),
                ("description", describe(category).into()),
            ];
            empty(xml, "Category", category)
        })
    })
}

/// Attributes of a variable, or of the array that begins with it, whatever its type.
pub(super) fn variable_head<S, R>(variable: &Variable<S, R>, [name, description]: [&String; 2]) -> Attributes {
    let (causality, variability, initial) = role(variable);
    let mut head: Attributes = vec![
        ("name", name.clone()),
        ("valueReference", variable.reference.to_string()),
        ("description", description.clone()),
        ("causality", causality.into()),
        ("variability", variability.into()),
    ];
    head.extend(initial.map(|initial| ("initial", initial.to_string())));
    head
}

/// The attributes `causality`, `variability` and `initial` of a variable.
fn role<S, R>(variable: &Variable<S, R>) -> (&'static str, &'static str, Option<&'static str>) {
    let real = matches!(variable.kind, Kind::Real { .. });
    match variable.causality {
        Causality::Parameter => ("parameter", "fixed", Some("exact")),
        Causality::Tunable => ("parameter", "tunable", Some("exact")),
        // An input has a start value, but the standard forbids the attribute "initial" for it.
        Causality::Input if real => ("input", "continuous", None),
        Causality::Input => ("input", "discrete", None),
        Causality::Output if real => ("output", "continuous", Some("calculated")),
        Causality::Output => ("output", "discrete", Some("calculated")),
        Causality::Local if real => ("local", "continuous", Some("calculated")),
        Causality::Local => ("local", "discrete", Some("calculated")),
    }
}

/// Attributes that state a variable's type, with its start value if it is a setting.
pub(super) fn typed<S, R>(variable: &Variable<S, R>, settings: &S) -> Attributes {
    let mut typed = Attributes::new();
    match &variable.kind {
        Kind::Real {
            unit,
            display_unit,
            range,
            ..
        } => {
            typed.push(("unit", (*unit).into()));
            typed.extend(display_unit.map(|unit| ("displayUnit", unit.to_string())));
            typed.extend(range.min.map(|min| ("min", number(min))));
            typed.extend(range.max.map(|max| ("max", number(max))));
            typed.extend(range.nominal.map(|nominal| ("nominal", number(nominal))));
        }
        Kind::Integer { range, .. } => {
            typed.extend(range.map(|(min, _)| ("min", min.to_string())));
            typed.extend(range.map(|(_, max)| ("max", max.to_string())));
        }
        Kind::Boolean { .. } => {}
        Kind::Enumeration { of, .. } => typed.push(("declaredType", of.name.into())),
    }
    typed.extend(variable.value(settings, None).map(|start| match start {
        Value::Real(start) => ("start", number(start)),
        start => ("start", start.to_string()),
    }));
    typed
}
