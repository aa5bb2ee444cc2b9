//! `modelDescription.xml` of FMI 3.0, generated from the variable table, and the instantiation token made from it.
//!
//! Names, value references, units and limits are those of FMI 2.0. Where FMI 2.0 has the elements of an array, here is the array, with
//! the value reference of its first element. Its size is fixed: FMI 2.0 names each element.

use std::io::{self, Write};

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;

use crate::fmi::description::{default_experiment, role, start};
use crate::fmi::hash::Fnv;
use crate::fmi::log::Category;
use crate::fmi::table::{Array, Causality, Enumeration, Kind, Table, UnitDefinition, Variable};
use crate::fmi::unit::{Identity, Unit};
use crate::fmi::xml::{Attributes, empty, number, parent, token};

/// Value reference of the time, which no variable of a table has.
pub(super) const TIME: u32 = 0;

/// The model description of a unit.
///
/// # Panics
/// It does not panic: writing to memory does not fail.
#[must_use]
pub fn model_description<U: Unit>() -> String {
    let table = U::table();
    let mut bytes = Vec::new();
    write::<U, _>(&mut bytes, &table, &token_of::<U>(&table)).expect("memory takes all bytes");
    String::from_utf8(bytes).expect("the writer is given text only")
}

/// The instantiation token of a unit: a hash of its description, so that description and binary fit each other.
#[must_use]
pub fn instantiation_token<U: Unit>() -> String {
    token_of::<U>(&U::table())
}

fn token_of<U: Unit>(table: &Table<U::Settings, U::Readings>) -> String {
    let mut hash = Fnv::default();
    write::<U, _>(&mut hash, table, "").expect("a hash takes all bytes");
    token(&hash)
}

/// Whether a variable can be set or read in intermediate update mode: real inputs and outputs can.
pub(super) fn is_intermediate<S, R>(variable: &Variable<S, R>) -> bool {
    matches!(variable.kind, Kind::Real { .. }) && matches!(variable.causality, Causality::Input | Causality::Output)
}

fn write<U: Unit, W: Write>(to: W, table: &Table<U::Settings, U::Readings>, token: &str) -> io::Result<()> {
    let identity = U::IDENTITY;
    let mut xml = Writer::new_with_indent(to, b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    parent(&mut xml, "fmiModelDescription", head(&identity, token), |xml| {
        empty(xml, "CoSimulation", capabilities(&identity))?;
        parent(xml, "UnitDefinitions", vec![], |xml| {
            table.units.iter().try_for_each(|unit| unit_definition(xml, unit))
        })?;
        if !table.enumerations.is_empty() {
            parent(xml, "TypeDefinitions", vec![], |xml| {
                let mut types = table.enumerations.iter();
                types.try_for_each(|enumeration| enumeration_type(xml, enumeration))
            })?;
        }
        parent(xml, "LogCategories", vec![], |xml| {
            Category::ALL.iter().try_for_each(|category| {
                let category: Attributes = vec![
                    ("name", category.name().into()),
                    ("description", log_category(*category).into()),
                ];
                empty(xml, "Category", category)
            })
        })?;
        empty(xml, "DefaultExperiment", default_experiment(&identity))?;
        parent(xml, "ModelVariables", vec![], |xml| model_variables::<U, _>(xml, table))?;
        parent(xml, "ModelStructure", vec![], |xml| model_structure(xml, table))
    })?;
    xml.get_mut().write_all(b"\n")
}

fn head(identity: &Identity, token: &str) -> Attributes {
    vec![
        ("fmiVersion", "3.0".into()),
        ("modelName", identity.name.into()),
        ("instantiationToken", token.into()),
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
    let flags = [
        "canGetAndSetFMUState",
        "canSerializeFMUState",
        "canHandleVariableCommunicationStepSize",
        "providesIntermediateUpdate",
        "mightReturnEarlyFromDoStep",
        "canReturnEarlyAfterIntermediateUpdate",
        "hasEventMode",
    ];
    let mut attributes = vec![("modelIdentifier", identity.name.to_string())];
    attributes.extend(flags.map(|flag| (flag, "true".to_string())));
    attributes.push(("maxOutputDerivativeOrder", "1".into()));
    // Inputs may jump between the unit's own steps.
    attributes.push(("recommendedIntermediateInputSmoothness", "-1".into()));
    attributes
}

/// What is logged under a category. Without logging nothing is: in FMI 2.0 it is otherwise.
fn log_category(category: Category) -> &'static str {
    match category {
        Category::Error => "Why a call failed",
        Category::Warning => "What looks wrong but lets the run go on",
        Category::Discard => "Why a step could not be completed",
        Category::Events => "What the unit did, e.g. how it found its initial state, and the events of a run",
    }
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

fn enumeration_type<W: Write>(xml: &mut Writer<W>, enumeration: &Enumeration) -> io::Result<()> {
    let head: Attributes = vec![
        ("name", enumeration.name.into()),
        ("description", enumeration.description.into()),
    ];
    parent(xml, "EnumerationType", head, |xml| {
        enumeration.items.iter().try_for_each(|item| {
            let item: Attributes = vec![
                ("name", item.name.into()),
                ("value", item.value.to_string()),
                ("description", item.description.into()),
            ];
            empty(xml, "Item", item)
        })
    })
}

/// The time, then every variable and array in the order of the table.
fn model_variables<U: Unit, W: Write>(xml: &mut Writer<W>, table: &Table<U::Settings, U::Readings>) -> io::Result<()> {
    let time: Attributes = vec![
        ("name", "time".into()),
        ("valueReference", TIME.to_string()),
        ("description", "Time of the simulation".into()),
        ("causality", "independent".into()),
        ("variability", "continuous".into()),
        ("unit", "s".into()),
    ];
    empty(xml, "Float64", time)?;
    let settings = U::Settings::default();
    table.variables().iter().try_for_each(|variable| {
        let array = table.array_of(variable.reference);
        match array {
            Some(array) if array.first != variable.reference => Ok(()),
            array => model_variable(xml, variable, array, &settings),
        }
    })
}

fn model_variable<W: Write, S, R>(
    xml: &mut Writer<W>,
    variable: &Variable<S, R>,
    array: Option<&Array>,
    settings: &S,
) -> io::Result<()> {
    let (causality, variability, initial) = role(variable);
    let (name, description) = match array {
        Some(array) => (&array.name, &array.description),
        None => (&variable.name, &variable.description),
    };
    let mut attributes: Attributes = vec![
        ("name", name.clone()),
        ("valueReference", variable.reference.to_string()),
        ("description", description.clone()),
        ("causality", causality.into()),
        ("variability", variability.into()),
    ];
    attributes.extend(initial.map(|initial| ("initial", initial.to_string())));
    if is_intermediate(variable) {
        attributes.push(("intermediateUpdate", "true".into()));
    }
    let tag = typed(&variable.kind, settings, &mut attributes);
    match array {
        None => empty(xml, tag, attributes),
        Some(array) => parent(xml, tag, attributes, |xml| {
            empty(xml, "Dimension", vec![("start", array.size.to_string())])
        }),
    }
}

/// The element of a variable of this type; its attributes are added.
fn typed<S, R>(kind: &Kind<S, R>, settings: &S, attributes: &mut Attributes) -> &'static str {
    match kind {
        Kind::Real {
            unit,
            display_unit,
            range,
            access,
        } => {
            attributes.push(("unit", (*unit).into()));
            attributes.extend(display_unit.map(|unit| ("displayUnit", unit.to_string())));
            attributes.extend(range.min.map(|min| ("min", number(min))));
            attributes.extend(range.max.map(|max| ("max", number(max))));
            attributes.extend(range.nominal.map(|nominal| ("nominal", number(nominal))));
            attributes.extend(start(access, settings).map(|start| ("start", number(start))));
            "Float64"
        }
        Kind::Integer { range, access } => {
            attributes.extend(range.map(|(min, _)| ("min", min.to_string())));
            attributes.extend(range.map(|(_, max)| ("max", max.to_string())));
            attributes.extend(start(access, settings).map(|start| ("start", start.to_string())));
            "Int32"
        }
        Kind::Boolean { access } => {
            attributes.extend(start(access, settings).map(|start| ("start", start.to_string())));
            "Boolean"
        }
        Kind::Enumeration { of, access } => {
            attributes.push(("declaredType", of.name.into()));
            attributes.extend(start(access, settings).map(|start| ("start", start.to_string())));
            "Enumeration"
        }
    }
}

/// As in FMI 2.0: no output depends directly on an input in a run, and at the start outputs depend on everything.
fn model_structure<W: Write, S, R>(xml: &mut Writer<W>, table: &Table<S, R>) -> io::Result<()> {
    let outputs = || {
        let variables = table.variables().iter();
        variables.filter(|variable| variable.causality == Causality::Output)
    };
    let unknown = |variable: &Variable<S, R>| ("valueReference", variable.reference.to_string());
    outputs().try_for_each(|output| {
        let independent = [("dependencies", String::new()), ("dependenciesKind", String::new())];
        empty(
            xml,
            "Output",
            [unknown(output)].into_iter().chain(independent).collect(),
        )
    })?;
    outputs().try_for_each(|output| empty(xml, "InitialUnknown", vec![unknown(output)]))
}
