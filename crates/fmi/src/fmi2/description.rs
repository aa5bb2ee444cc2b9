//! `modelDescription.xml` of FMI 2.0, generated from the variable table, and the GUID made from it.

use crate::common_description::{
    default_experiment, depending, head, items, log_categories, token_of, token_with, typed, unit_definition,
    variable_head,
};
use crate::log::Category;
use crate::table::{Causality, Enumeration, Kind, Table, Variable};
use crate::unit::Unit;
use crate::xml::Element;

/// The model description of a unit.
#[must_use]
pub fn model_description<U: Unit>() -> String {
    describe::<U>(&guid::<U>()).document()
}

/// The model description of a unit with data of this hash in its resources.
#[must_use]
pub fn model_description_with<U: Unit>(data: u128) -> String {
    describe::<U>(&guid_with::<U>(Some(data))).document()
}

/// The GUID of a unit: a hash of its description, so that description and binary fit each other.
#[must_use]
pub fn guid<U: Unit>() -> String {
    guid_with::<U>(U::data(&U::Settings::default()))
}

/// The GUID of a unit with data of this hash.
pub(crate) fn guid_with<U: Unit>(data: Option<u128>) -> String {
    token_with(&token_of(describe::<U>), data)
}

fn describe<U: Unit>(guid: &str) -> Element {
    let (table, settings) = (U::table(), U::Settings::default());
    let variables = table.variables().iter();
    head(&U::IDENTITY, "2.0", ("guid", guid))
        .child(capabilities::<U>())
        .list("UnitDefinitions", table.units.iter().map(unit_definition))
        .list(
            "TypeDefinitions",
            table.enumerations.iter().map(|one| type_definition(one)),
        )
        .child(log_categories(Category::description))
        .child(default_experiment(&U::IDENTITY))
        .list("ModelVariables", variables.map(|one| scalar_variable(one, &settings)))
        .child(model_structure(&table))
}

fn capabilities<U: Unit>() -> Element {
    Element::new("CoSimulation")
        .with("modelIdentifier", U::IDENTITY.name)
        .with("canHandleVariableCommunicationStepSize", true)
        .with_some("canInterpolateInputs", U::INTERPOLATES_INPUTS.then_some(true))
        .with_some("maxOutputDerivativeOrder", U::OUTPUT_DERIVATIVES.then_some(1))
        .with("canNotUseMemoryManagementFunctions", true)
        .with("canGetAndSetFMUstate", true)
        .with("canSerializeFMUstate", true)
}

fn type_definition(enumeration: &Enumeration) -> Element {
    Element::new("SimpleType")
        .with("name", enumeration.name)
        .with("description", enumeration.description)
        .child(Element::new("Enumeration").children(items(enumeration)))
}

fn scalar_variable<S, R>(variable: &Variable<S, R>, settings: &S) -> Element {
    let tag = match &variable.kind {
        Kind::Real { .. } => "Real",
        Kind::Integer { .. } => "Integer",
        Kind::Boolean { .. } => "Boolean",
        Kind::Enumeration { .. } => "Enumeration",
    };
    let head = variable_head("ScalarVariable", variable, [&variable.name, &variable.description]);
    head.child(typed(Element::new(tag), variable, settings))
}

/// In a run no output depends directly on an input: all effects pass through states. In initialisation mode outputs depend on
/// settings, on all of them where there is no list (FMI 2.0, definition of the model structure).
fn model_structure<S, R>(table: &Table<S, R>) -> Element {
    let unknowns = || {
        let numbered = table.variables().iter().zip(1..);
        let outputs = numbered.filter(|(variable, _)| variable.causality == Causality::Output);
        outputs.map(|(variable, index): (_, u32)| (variable, Element::new("Unknown").with("index", index)))
    };
    let initial = unknowns().map(|(variable, unknown)| match table.initial_dependencies(variable) {
        Some(places) => {
            let indices = (1..).zip(0..table.variables().len());
            depending(
                unknown,
                indices
                    .filter(|(_, place)| places.contains(place))
                    .map(|(index, _)| index),
            )
        }
        None => unknown,
    });
    Element::new("ModelStructure")
        .list("Outputs", unknowns().map(|(_, unknown)| depending(unknown, [])))
        .list("InitialUnknowns", initial)
}
