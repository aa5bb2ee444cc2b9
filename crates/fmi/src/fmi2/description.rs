//! `modelDescription.xml` of FMI 2.0, generated from the variable table, and the GUID made from it.

use std::io::{self, Write};

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;

use crate::common_description::{
    default_experiment, enumeration_head, enumeration_items, head, log_categories, text_of, token_of, type_definitions,
    typed, unit_definitions, variable_head,
};
use crate::log::Category;
use crate::table::{Causality, Enumeration, Kind, Table, Variable};
use crate::unit::Unit;
use crate::xml::{Attributes, empty, parent};

/// The model description of a unit.
///
/// # Panics
/// It does not panic: writing to memory does not fail.
#[must_use]
pub fn model_description<U: Unit>() -> String {
    let table = U::table();
    text_of(|to, guid| write::<U, _>(to, &table, guid))
}

/// The GUID of a unit: a hash of its description, so that description and binary fit each other.
#[must_use]
pub fn guid<U: Unit>() -> String {
    let table = U::table();
    token_of(|to, guid| write::<U, _>(to, &table, guid))
}

fn write<U: Unit, W: Write>(to: W, table: &Table<U::Settings, U::Readings>, guid: &str) -> io::Result<()> {
    let identity = U::IDENTITY;
    let mut xml = Writer::new_with_indent(to, b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    parent(
        &mut xml,
        "fmiModelDescription",
        head(&identity, "2.0", ("guid", guid)),
        |xml| {
            empty(xml, "CoSimulation", capabilities::<U>())?;
            unit_definitions(xml, table.units)?;
            type_definitions(xml, table.enumerations, type_definition)?;
            log_categories(xml, Category::description)?;
            empty(xml, "DefaultExperiment", default_experiment(&identity))?;
            let settings = U::Settings::default();
            parent(xml, "ModelVariables", vec![], |xml| {
                table
                    .variables()
                    .iter()
                    .try_for_each(|variable| scalar_variable(xml, variable, &settings))
            })?;
            parent(xml, "ModelStructure", vec![], |xml| model_structure(xml, table))
        },
    )?;
    xml.get_mut().write_all(b"\n")
}

fn capabilities<U: Unit>() -> Attributes {
    let mut attributes = vec![
        ("modelIdentifier", U::IDENTITY.name.into()),
        ("canHandleVariableCommunicationStepSize", "true".into()),
    ];
    if U::INTERPOLATES_INPUTS {
        attributes.push(("canInterpolateInputs", "true".into()));
    }
    if U::OUTPUT_DERIVATIVES {
        attributes.push(("maxOutputDerivativeOrder", "1".into()));
    }
    let flags = [
        "canNotUseMemoryManagementFunctions",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
    ];
    attributes.extend(flags.map(|flag| (flag, "true".into())));
    attributes
}

fn type_definition<W: Write>(xml: &mut Writer<W>, enumeration: &Enumeration) -> io::Result<()> {
    parent(xml, "SimpleType", enumeration_head(enumeration), |xml| {
        parent(xml, "Enumeration", vec![], |xml| enumeration_items(xml, enumeration))
    })
}

fn scalar_variable<W: Write, S, R>(xml: &mut Writer<W>, variable: &Variable<S, R>, settings: &S) -> io::Result<()> {
    let head = variable_head(variable, [&variable.name, &variable.description]);
    parent(xml, "ScalarVariable", head, |xml| {
        empty(xml, tag(&variable.kind), typed(variable, settings))
    })
}

/// The element that states a variable's type.
fn tag<S, R>(kind: &Kind<S, R>) -> &'static str {
    match kind {
        Kind::Real { .. } => "Real",
        Kind::Integer { .. } => "Integer",
        Kind::Boolean { .. } => "Boolean",
        Kind::Enumeration { .. } => "Enumeration",
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
    if outputs().next().is_none() {
        return Ok(());
    }
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
