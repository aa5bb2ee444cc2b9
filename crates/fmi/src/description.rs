//! `modelDescription.xml` of both versions, generated from the variable table, and the token made
//! from it.
//!
//! The elements of an array in FMI 2.0 are one array in FMI 3.0, with the value reference of its
//! first element. Its size is fixed: FMI 2.0 names each element.

use super::hash;
use super::log::Category;
use super::table::{Causality, Enumeration, Kind, Table, UnitDefinition, Value, Variable};
use super::unit::{Identity, Unit};
use super::xml::{Element, Number};
use Version::{Three, Two};

/// Version of the standard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    #[default]
    Two,
    /// FMI 3.0.
    Three,
}

/// Value reference of the time in FMI 3.0, which no variable of a table has.
pub(crate) const TIME: u32 = 0;

/// The model description of a unit whose resources have data of this hash.
#[must_use]
pub fn model_description<U: Unit>(version: Version, data: Option<u128>) -> String {
    describe::<U>(version, &token::<U>(version, data)).document()
}

/// The GUID of FMI 2.0 or instantiation token of FMI 3.0: a hash of the description without it, in
/// the form of a GUID. The hash of the data is in it by the bitwise exclusive or: a tool that
/// replaces the data of an FMU can calculate the new token.
#[must_use]
pub fn token<U: Unit>(version: Version, data: Option<u128>) -> String {
    let description = describe::<U>(version, "").document();
    let digits = format!(
        "{:032x}",
        hash::of_bytes(description.as_bytes()) ^ data.unwrap_or_default()
    );
    let [a, b, c, d, e] = [0..8, 8..12, 12..16, 16..20, 20..32].map(|range| &digits[range]);
    format!("{{{a}-{b}-{c}-{d}-{e}}}")
}

fn describe<U: Unit>(version: Version, token: &str) -> Element {
    let (table, settings) = (U::table(), U::Settings::default());
    let described = table
        .variables()
        .iter()
        .filter_map(|one| variable(version, &table, one, &settings));
    let time = (version == Three).then(time);
    let types = table.enumerations.iter().map(|one| type_definition(version, one));
    head(version, &U::IDENTITY, token)
        .child(capabilities::<U>(version))
        .list("UnitDefinitions", table.units.iter().map(unit_definition))
        .list("TypeDefinitions", types)
        .child(log_categories())
        .child(default_experiment(&U::IDENTITY))
        .list("ModelVariables", time.into_iter().chain(described))
        .child(model_structure(version, &table))
}

fn head(version: Version, identity: &Identity, value: &str) -> Element {
    let (number, token) = match version {
        Two => ("2.0", "guid"),
        Three => ("3.0", "instantiationToken"),
    };
    Element::new("fmiModelDescription")
        .with("fmiVersion", number)
        .with("modelName", identity.name)
        .with(token, value)
        .with("description", identity.description)
        .with("author", identity.author)
        .with("version", identity.version)
        .with("license", identity.license)
        .with("generationTool", identity.generation_tool)
        .with("variableNamingConvention", "structured")
}

fn capabilities<U: Unit>(version: Version) -> Element {
    let element = Element::new("CoSimulation").with("modelIdentifier", U::IDENTITY.name);
    let derivatives = U::OUTPUT_DERIVATIVES.then_some(1);
    match version {
        Two => element
            .with("canHandleVariableCommunicationStepSize", true)
            .with_some("canInterpolateInputs", U::INTERPOLATES_INPUTS.then_some(true))
            .with_some("maxOutputDerivativeOrder", derivatives)
            .with("canNotUseMemoryManagementFunctions", true)
            .with("canGetAndSetFMUstate", true)
            .with("canSerializeFMUstate", true),
        // Inputs may jump between the unit's internal steps, but without
        // `recommendedIntermediateInputSmoothness="-1"`: checkers stop at a negative number.
        Three => element
            .with("canGetAndSetFMUState", true)
            .with("canSerializeFMUState", true)
            .with("canHandleVariableCommunicationStepSize", true)
            .with("providesIntermediateUpdate", true)
            .with("mightReturnEarlyFromDoStep", true)
            .with("canReturnEarlyAfterIntermediateUpdate", true)
            .with("hasEventMode", true)
            .with_some("maxOutputDerivativeOrder", derivatives),
    }
}

fn default_experiment(identity: &Identity) -> Element {
    Element::new("DefaultExperiment")
        .with("startTime", 0)
        .with("stopTime", Number(identity.stop_time))
        .with("tolerance", Number(identity.tolerance))
        .with("stepSize", Number(identity.step_size))
}

fn unit_definition(unit: &UnitDefinition) -> Element {
    let (exponents, display) = (unit.exponents.iter(), unit.display.iter());
    let base = exponents.fold(Element::new("BaseUnit"), |base, (name, value)| base.with(name, value));
    let display = display.map(|(name, factor)| {
        let display = Element::new("DisplayUnit").with("name", name);
        display.with("factor", Number(*factor))
    });
    let unit = Element::new("Unit").with("name", unit.name);
    unit.child(base).children(display)
}

fn type_definition(version: Version, enumeration: &Enumeration) -> Element {
    let items = enumeration.items.iter().map(|item| {
        Element::new("Item")
            .with("name", item.name)
            .with("value", item.value)
            .with("description", item.description)
    });
    let named = |tag| {
        Element::new(tag)
            .with("name", enumeration.name)
            .with("description", enumeration.description)
    };
    match version {
        Two => named("SimpleType").child(Element::new("Enumeration").children(items)),
        Three => named("EnumerationType").children(items),
    }
}

/// Categories of the log. All but events are logged without debug logging too.
fn log_categories() -> Element {
    let describe = |category| match category {
        Category::Error => "Why a call failed (always logged)",
        Category::Warning => "What looks wrong but lets the run go on (logged without debug logging too)",
        Category::Discard => {
            "Why a value was not taken or a step not completed (logged without debug logging too)"
        }
        Category::Events => "What the unit did, e.g. how it found its initial state, and the events of a run",
    };
    Element::new("LogCategories").children(Category::ALL.into_iter().map(|category| {
        Element::new("Category")
            .with("name", category.name())
            .with("description", describe(category))
    }))
}

fn time() -> Element {
    Element::new("Float64")
        .with("name", "time")
        .with("valueReference", TIME)
        .with("description", "Time of the simulation")
        .with("causality", "independent")
        .with("variability", "continuous")
        .with("unit", "s")
}

/// The element of a variable, or in FMI 3.0 of the array that begins with it; `None` for further
/// elements of an array.
fn variable<S, R>(
    version: Version,
    table: &Table<S, R>,
    variable: &Variable<S, R>,
    settings: &S,
) -> Option<Element> {
    let reference = variable.reference;
    let array = table.array_of(reference).filter(|_| version == Three);
    let (name, description) = match array {
        Some(array) if array.first != reference => return None,
        Some(array) => (&array.name, &array.description),
        None => (&variable.name, &variable.description),
    };
    let (tag, changes) = match (&variable.kind, version) {
        (Kind::Real { .. }, Two) => ("Real", "continuous"),
        (Kind::Real { .. }, Three) => ("Float64", "continuous"),
        (Kind::Integer { .. }, Two) => ("Integer", "discrete"),
        (Kind::Integer { .. }, Three) => ("Int32", "discrete"),
        (Kind::Boolean { .. }, _) => ("Boolean", "discrete"),
        (Kind::Enumeration { .. }, _) => ("Enumeration", "discrete"),
    };
    let (causality, variability, initial) = match variable.causality {
        Causality::Parameter => ("parameter", "fixed", Some("exact")),
        Causality::Tunable => ("parameter", "tunable", Some("exact")),
        // An input has a start value, but the standard forbids the attribute "initial" for it.
        Causality::Input => ("input", changes, None),
        Causality::Output => ("output", changes, Some("calculated")),
        Causality::Local => ("local", changes, Some("calculated")),
    };
    let head = |tag| {
        Element::new(tag)
            .with("name", name)
            .with("valueReference", reference)
            .with("description", description)
            .with("causality", causality)
            .with("variability", variability)
            .with_some("initial", initial)
    };
    Some(match version {
        Two => head("ScalarVariable").child(typed(Element::new(tag), variable, settings)),
        Three => {
            let head = head(tag).with_some("intermediateUpdate", variable.is_intermediate().then_some(true));
            let size = array.map(|array| Element::new("Dimension").with("start", array.size));
            typed(head, variable, settings).children(size)
        }
    })
}

/// With the attributes of a variable's type, and its start value if it is a setting.
fn typed<S, R>(element: Element, variable: &Variable<S, R>, settings: &S) -> Element {
    let element = match &variable.kind {
        Kind::Real {
            unit,
            display_unit,
            range,
            ..
        } => element
            .with("unit", unit)
            .with_some("displayUnit", *display_unit)
            .with_some("min", range.min.map(Number))
            .with_some("max", range.max.map(Number))
            .with_some("nominal", range.nominal.map(Number)),
        Kind::Integer { range, .. } => element
            .with_some("min", range.map(|(min, _)| min))
            .with_some("max", range.map(|(_, max)| max)),
        Kind::Boolean { .. } => element,
        Kind::Enumeration { of, .. } => element.with("declaredType", of.name),
    };
    match variable.value(settings, None) {
        Some(Value::Real(start)) => element.with("start", Number(start)),
        start => element.with_some("start", start),
    }
}

/// In a run no output depends directly on an input: all effects pass through states. In
/// initialisation mode outputs depend on settings, on all of them where there is no list (FMI 2.0,
/// definition of the model structure; section 2.4.8 of FMI 3.0.2).
fn model_structure<S, R>(version: Version, table: &Table<S, R>) -> Element {
    // FMI 2.0 counts variables from 1; FMI 3.0 has their value references.
    let number = |index: usize| match version {
        Two => (index + 1).to_string(),
        Three => table.variables()[index].reference.to_string(),
    };
    let indices = 0..table.variables().len();
    let outputs = indices.filter(|index| table.variables()[*index].causality == Causality::Output);
    let unknown = |tag, index: usize| match version {
        Two => Element::new("Unknown").with("index", number(index)),
        Three => Element::new(tag).with("valueReference", number(index)),
    };
    let depending = |unknown: Element, known: &[usize]| {
        let numbers: Vec<_> = known.iter().map(|index| number(*index)).collect();
        unknown
            .with("dependencies", numbers.join(" "))
            .with("dependenciesKind", vec!["dependent"; known.len()].join(" "))
    };
    let in_run = outputs.clone().map(|index| depending(unknown("Output", index), &[]));
    let initial = outputs.map(|index| {
        let unknown = unknown("InitialUnknown", index);
        match table.initial_dependencies(&table.variables()[index]) {
            Some(indices) => depending(unknown, &indices),
            None => unknown,
        }
    });
    let structure = Element::new("ModelStructure");
    match version {
        Two => structure.list("Outputs", in_run).list("InitialUnknowns", initial),
        Three => structure.children(in_run).children(initial),
    }
}
