//! `modelDescription.xml` of FMI 3.0, generated from the variable table, and the instantiation token made from it.
//!
//! Names, value references, units and limits are those of FMI 2.0. The elements of an array in FMI 2.0 are one array here, with
//! the value reference of its first element. Its size is fixed: FMI 2.0 names each element.

use crate::common_description::{
    default_experiment, depending, head, items, log_categories, token_of, token_with, typed, unit_definition,
    variable_head,
};
use crate::log::Category;
use crate::slave::TIME;
use crate::table::{Causality, Enumeration, Kind, Table, Variable};
use crate::unit::Unit;
use crate::xml::Element;

/// The model description of a unit.
#[must_use]
pub fn model_description<U: Unit>() -> String {
    describe::<U>(&instantiation_token::<U>()).document()
}

/// The model description of a unit with data of this hash in its resources.
#[must_use]
pub fn model_description_with<U: Unit>(data: u128) -> String {
    describe::<U>(&instantiation_token_with::<U>(Some(data))).document()
}

/// The instantiation token of a unit: a hash of its description, so that description and binary fit each other.
#[must_use]
pub fn instantiation_token<U: Unit>() -> String {
    instantiation_token_with::<U>(U::data(&U::Settings::default()))
}

/// The instantiation token of a unit with data of this hash.
pub(crate) fn instantiation_token_with<U: Unit>(data: Option<u128>) -> String {
    token_with(&token_of(describe::<U>), data)
}

/// Whether a variable can be set or read in intermediate update mode: real inputs and outputs can.
pub(super) fn is_intermediate<S, R>(variable: &Variable<S, R>) -> bool {
    matches!(variable.kind, Kind::Real { .. }) && matches!(variable.causality, Causality::Input | Causality::Output)
}

fn describe<U: Unit>(token: &str) -> Element {
    let (table, settings) = (U::table(), U::Settings::default());
    let variables = table.variables().iter();
    let variables = variables.filter_map(|variable| model_variable(&table, variable, &settings));
    head(&U::IDENTITY, "3.0", ("instantiationToken", token))
        .child(capabilities::<U>())
        .list("UnitDefinitions", table.units.iter().map(unit_definition))
        .list(
            "TypeDefinitions",
            table.enumerations.iter().map(|one| enumeration_type(one)),
        )
        .child(log_categories(log_category))
        .child(default_experiment(&U::IDENTITY))
        .list("ModelVariables", [time()].into_iter().chain(variables))
        .child(model_structure(&table))
}

fn capabilities<U: Unit>() -> Element {
    let flags = [
        "canGetAndSetFMUState",
        "canSerializeFMUState",
        "canHandleVariableCommunicationStepSize",
        "providesIntermediateUpdate",
        "mightReturnEarlyFromDoStep",
        "canReturnEarlyAfterIntermediateUpdate",
        "hasEventMode",
    ];
    let name = Element::new("CoSimulation").with("modelIdentifier", U::IDENTITY.name);
    let flags = flags.into_iter().fold(name, |element, flag| element.with(flag, true));
    // Inputs may jump between the unit's internal steps, but without `recommendedIntermediateInputSmoothness="-1"`: checkers stop at
    // a negative number.
    flags.with_some("maxOutputDerivativeOrder", U::OUTPUT_DERIVATIVES.then_some(1))
}

/// What is logged under a category. In contrast to FMI 2.0, only errors are logged without debug logging.
fn log_category(category: Category) -> &'static str {
    match category {
        Category::Error => "Why a call failed (always logged)",
        Category::Warning => "What looks wrong but lets the run go on",
        Category::Discard => "Why a step could not be completed",
        Category::Events => "What the unit did, e.g. how it found its initial state, and the events of a run",
    }
}

fn enumeration_type(enumeration: &Enumeration) -> Element {
    Element::new("EnumerationType")
        .with("name", enumeration.name)
        .with("description", enumeration.description)
        .children(items(enumeration))
}

/// The independent variable.
fn time() -> Element {
    Element::new("Float64")
        .with("name", "time")
        .with("valueReference", TIME)
        .with("description", "Time of the simulation")
        .with("causality", "independent")
        .with("variability", "continuous")
        .with("unit", "s")
}

/// The element of a variable or of the array that begins with it; `None` for further elements of an array.
fn model_variable<S, R>(table: &Table<S, R>, variable: &Variable<S, R>, settings: &S) -> Option<Element> {
    let array = table.array_of(variable.reference);
    let names = match array {
        Some(array) if array.first != variable.reference => return None,
        Some(array) => [&array.name, &array.description],
        None => [&variable.name, &variable.description],
    };
    let tag = match &variable.kind {
        Kind::Real { .. } => "Float64",
        Kind::Integer { .. } => "Int32",
        Kind::Boolean { .. } => "Boolean",
        Kind::Enumeration { .. } => "Enumeration",
    };
    let head = variable_head(tag, variable, names);
    let head = head.with_some("intermediateUpdate", is_intermediate(variable).then_some(true));
    let size = array.map(|array| Element::new("Dimension").with("start", array.size));
    Some(typed(head, variable, settings).children(size))
}

/// As in FMI 2.0, no output depends directly on an input in a run, and at the start outputs depend on settings, on all of them
/// where there is no list (section 2.4.8 of FMI 3.0.2).
fn model_structure<S, R>(table: &Table<S, R>) -> Element {
    let outputs = || {
        let variables = table.variables().iter();
        variables.filter(|one| one.causality == Causality::Output)
    };
    let unknown = |tag, output: &Variable<S, R>| Element::new(tag).with("valueReference", output.reference);
    let initial = outputs().map(|output| {
        let unknown = unknown("InitialUnknown", output);
        match table.initial_dependencies(output) {
            Some(places) => depending(unknown, places.iter().map(|place| table.variables()[*place].reference)),
            None => unknown,
        }
    });
    Element::new("ModelStructure")
        .children(outputs().map(|output| depending(unknown("Output", output), [])))
        .children(initial)
}
