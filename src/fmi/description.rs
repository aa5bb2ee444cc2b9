//! `modelDescription.xml` of FMI 2.0, generated from the variable table, and the GUID made from it.

use std::io::{self, Write};

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;

use super::hash::Fnv;
use super::log::Category;
use super::table::{Access, Causality, Enumeration, Kind, Table, UnitDefinition, Variable};
use super::unit::{Identity, Unit};
use super::xml::{Attributes, empty, number, parent, token};

/// The model description of a unit.
///
/// # Panics
/// It does not panic: writing to memory does not fail.
#[must_use]
pub fn model_description<U: Unit>() -> String {
    let table = U::table();
    let mut bytes = Vec::new();
    write::<U, _>(&mut bytes, &table, &guid_of::<U>(&table)).expect("memory takes all bytes");
    String::from_utf8(bytes).expect("the writer is given text only")
}

/// The GUID of a unit: a hash of its description, so that description and binary fit each other.
#[must_use]
pub fn guid<U: Unit>() -> String {
    guid_of::<U>(&U::table())
}

fn guid_of<U: Unit>(table: &Table<U::Settings, U::Readings>) -> String {
    let mut hash = Fnv::default();
    write::<U, _>(&mut hash, table, "").expect("a hash takes all bytes");
    token(&hash)
}

fn write<U: Unit, W: Write>(to: W, table: &Table<U::Settings, U::Readings>, guid: &str) -> io::Result<()> {
    let identity = U::IDENTITY;
    let mut xml = Writer::new_with_indent(to, b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    parent(&mut xml, "fmiModelDescription", head(&identity, guid), |xml| {
        empty(xml, "CoSimulation", capabilities(&identity))?;
        parent(xml, "UnitDefinitions", vec![], |xml| {
            table.units.iter().try_for_each(|unit| unit_definition(xml, unit))
        })?;
        parent(xml, "TypeDefinitions", vec![], |xml| {
            table
                .enumerations
                .iter()
                .try_for_each(|enumeration| type_definition(xml, enumeration))
        })?;
        parent(xml, "LogCategories", vec![], |xml| {
            Category::ALL.iter().try_for_each(|category| {
                let category: Attributes = vec![
                    ("name", category.name().into()),
                    ("description", category.description().into()),
                ];
                empty(xml, "Category", category)
            })
        })?;
        empty(xml, "DefaultExperiment", default_experiment(&identity))?;
        let settings = U::Settings::default();
        parent(xml, "ModelVariables", vec![], |xml| {
            table
                .variables()
                .iter()
                .try_for_each(|variable| scalar_variable(xml, variable, &settings))
        })?;
        parent(xml, "ModelStructure", vec![], |xml| model_structure(xml, table))
    })?;
    xml.get_mut().write_all(b"\n")
}

fn head(identity: &Identity, guid: &str) -> Attributes {
    vec![
        ("fmiVersion", "2.0".into()),
        ("modelName", identity.name.into()),
        ("guid", guid.into()),
        ("description", identity.description.into()),
        ("author", identity.author.into()),
        ("version", identity.version.into()),
        ("license", identity.license.into()),
        (
            "generationTool",
            format!("{} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")),
        ),
        ("variableNamingConvention", "structured".into()),
    ]
}

fn capabilities(identity: &Identity) -> Attributes {
    vec![
        ("modelIdentifier", identity.name.into()),
        ("canHandleVariableCommunicationStepSize", "true".into()),
        ("canInterpolateInputs", "true".into()),
        ("maxOutputDerivativeOrder", "1".into()),
        ("canNotUseMemoryManagementFunctions", "true".into()),
        ("canGetAndSetFMUstate", "true".into()),
        ("canSerializeFMUstate", "true".into()),
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

fn type_definition<W: Write>(xml: &mut Writer<W>, enumeration: &Enumeration) -> io::Result<()> {
    let head: Attributes = vec![
        ("name", enumeration.name.into()),
        ("description", enumeration.description.into()),
    ];
    parent(xml, "SimpleType", head, |xml| {
        parent(xml, "Enumeration", vec![], |xml| {
            enumeration.items.iter().try_for_each(|item| {
                let item: Attributes = vec![
                    ("name", item.name.into()),
                    ("value", item.value.to_string()),
                    ("description", item.description.into()),
                ];
                empty(xml, "Item", item)
            })
        })
    })
}

fn scalar_variable<W: Write, S, R>(xml: &mut Writer<W>, variable: &Variable<S, R>, settings: &S) -> io::Result<()> {
    let (causality, variability, initial) = role(variable);
    let mut head: Attributes = vec![
        ("name", variable.name.clone()),
        ("valueReference", variable.reference.to_string()),
        ("description", variable.description.clone()),
        ("causality", causality.into()),
        ("variability", variability.into()),
    ];
    head.extend(initial.map(|initial| ("initial", initial.to_string())));
    parent(xml, "ScalarVariable", head, |xml| {
        let (tag, typed) = type_of(&variable.kind, settings);
        empty(xml, tag, typed)
    })
}

/// The attributes `causality`, `variability` and `initial` of a variable.
pub(super) fn role<S, R>(variable: &Variable<S, R>) -> (&'static str, &'static str, Option<&'static str>) {
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

/// The element that states a variable's type, and its attributes.
fn type_of<S, R>(kind: &Kind<S, R>, settings: &S) -> (&'static str, Attributes) {
    let mut typed = Attributes::new();
    let tag = match kind {
        Kind::Real {
            unit,
            display_unit,
            range,
            access,
        } => {
            typed.push(("unit", (*unit).into()));
            typed.extend(display_unit.map(|unit| ("displayUnit", unit.to_string())));
            typed.extend(range.min.map(|min| ("min", number(min))));
            typed.extend(range.max.map(|max| ("max", number(max))));
            typed.extend(range.nominal.map(|nominal| ("nominal", number(nominal))));
            typed.extend(start(access, settings).map(|start| ("start", number(start))));
            "Real"
        }
        Kind::Integer { range, access } => {
            typed.extend(range.map(|(min, _)| ("min", min.to_string())));
            typed.extend(range.map(|(_, max)| ("max", max.to_string())));
            typed.extend(start(access, settings).map(|start| ("start", start.to_string())));
            "Integer"
        }
        Kind::Boolean { access } => {
            typed.extend(start(access, settings).map(|start| ("start", start.to_string())));
            "Boolean"
        }
        Kind::Enumeration { of, access } => {
            typed.push(("declaredType", of.name.into()));
            typed.extend(start(access, settings).map(|start| ("start", start.to_string())));
            "Enumeration"
        }
    };
    (tag, typed)
}

/// The start value of a setting; readings have none.
pub(super) fn start<S, R, T>(access: &Access<S, R, T>, settings: &S) -> Option<T> {
    match access {
        Access::Setting { get, .. } => Some(get(settings)),
        Access::Reading(_) | Access::Element(..) => None,
    }
}

/// In a run no output depends directly on an input: all effects pass through states. In initialisation mode the
/// outputs do depend on parameters and inputs, since a steady start solves for them, so no list is given there.
fn model_structure<W: Write, S, R>(xml: &mut Writer<W>, table: &Table<S, R>) -> io::Result<()> {
    let outputs = || {
        let numbered = table.variables().iter().zip(1_usize..);
        numbered
            .filter(|(variable, _)| variable.causality == Causality::Output)
            .map(|(_, index)| ("index", index.to_string()))
    };
    parent(xml, "Outputs", vec![], |xml| {
        outputs().try_for_each(|index| {
            empty(
                xml,
                "Unknown",
                vec![
                    index,
                    ("dependencies", String::new()),
                    ("dependenciesKind", String::new()),
                ],
            )
        })
    })?;
    parent(xml, "InitialUnknowns", vec![], |xml| {
        outputs().try_for_each(|index| empty(xml, "Unknown", vec![index]))
    })
}
