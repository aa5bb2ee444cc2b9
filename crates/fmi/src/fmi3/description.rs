//! `modelDescription.xml` of FMI 3.0, generated from the variable table, and the instantiation token made from it.
//!
//! Names, value references, units and limits are those of FMI 2.0. Where FMI 2.0 has the elements of an array, here is the array, with
//! the value reference of its first element. Its size is fixed: FMI 2.0 names each element.

use std::io::{self, Write};

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;

use crate::common_description::{
    default_experiment, enumeration_head, enumeration_items, head, log_categories, text_of, token_of, type_definitions,
    typed, unit_definitions, variable_head,
};
use crate::log::Category;
use crate::slave::TIME;
use crate::table::{Array, Causality, Enumeration, Kind, Table, Variable};
use crate::unit::Unit;
use crate::xml::{Attributes, empty, parent};

/// The model description of a unit.
///
/// # Panics
/// It does not panic: writing to memory does not fail.
#[must_use]
pub fn model_description<U: Unit>() -> String {
    let table = U::table();
    text_of(|to, token| write::<U, _>(to, &table, token))
}

/// The instantiation token of a unit: a hash of its description, so that description and binary fit each other.
#[must_use]
pub fn instantiation_token<U: Unit>() -> String {
    let table = U::table();
    token_of(|to, token| write::<U, _>(to, &table, token))
}

/// Whether a variable can be set or read in intermediate update mode: real inputs and outputs can.
pub(super) fn is_intermediate<S, R>(variable: &Variable<S, R>) -> bool {
    matches!(variable.kind, Kind::Real { .. }) && matches!(variable.causality, Causality::Input | Causality::Output)
}

fn write<U: Unit, W: Write>(to: W, table: &Table<U::Settings, U::Readings>, token: &str) -> io::Result<()> {
    let identity = U::IDENTITY;
    let mut xml = Writer::new_with_indent(to, b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    parent(
        &mut xml,
        "fmiModelDescription",
        head(&identity, "3.0", ("instantiationToken", token)),
        |xml| {
            empty(xml, "CoSimulation", capabilities::<U>())?;
            unit_definitions(xml, table.units)?;
            type_definitions(xml, table.enumerations, enumeration_type)?;
            log_categories(xml, log_category)?;
            empty(xml, "DefaultExperiment", default_experiment(&identity))?;
            parent(xml, "ModelVariables", vec![], |xml| model_variables::<U, _>(xml, table))?;
            parent(xml, "ModelStructure", vec![], |xml| model_structure(xml, table))
        },
    )?;
    xml.get_mut().write_all(b"\n")
}

fn capabilities<U: Unit>() -> Attributes {
    let flags = [
        "canGetAndSetFMUState",
        "canSerializeFMUState",
        "canHandleVariableCommunicationStepSize",
        "providesIntermediateUpdate",
        "mightReturnEarlyFromDoStep",
        "canReturnEarlyAfterIntermediateUpdate",
        "hasEventMode",
    ];
    let mut attributes = vec![("modelIdentifier", U::IDENTITY.name.to_string())];
    attributes.extend(flags.map(|flag| (flag, "true".to_string())));
    if U::OUTPUT_DERIVATIVES {
        attributes.push(("maxOutputDerivativeOrder", "1".into()));
    }
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

fn enumeration_type<W: Write>(xml: &mut Writer<W>, enumeration: &Enumeration) -> io::Result<()> {
    parent(xml, "EnumerationType", enumeration_head(enumeration), |xml| {
        enumeration_items(xml, enumeration)
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
    let [name, description] = match array {
        Some(array) => [&array.name, &array.description],
        None => [&variable.name, &variable.description],
    };
    let mut attributes = variable_head(variable, [name, description]);
    if is_intermediate(variable) {
        attributes.push(("intermediateUpdate", "true".into()));
    }
    attributes.extend(typed(variable, settings));
    let tag = tag(&variable.kind);
    match array {
        None => empty(xml, tag, attributes),
        Some(array) => parent(xml, tag, attributes, |xml| {
            empty(xml, "Dimension", vec![("start", array.size.to_string())])
        }),
    }
}

/// The element of a variable of this type.
fn tag<S, R>(kind: &Kind<S, R>) -> &'static str {
    match kind {
        Kind::Real { .. } => "Float64",
        Kind::Integer { .. } => "Int32",
        Kind::Boolean { .. } => "Boolean",
        Kind::Enumeration { .. } => "Enumeration",
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
