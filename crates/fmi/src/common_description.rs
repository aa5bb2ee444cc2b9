//! Common parts of the descriptions of both versions: units, enumerations, log categories, variables.

use super::hash;
use super::log::Category;
use super::table::{Causality, Enumeration, Kind, UnitDefinition, Value, Variable};
use super::unit::Identity;
use super::xml::{Element, Number};

/// A hash of a description without its token, in the form of a GUID, so that description and binary fit each other.
pub(super) fn token_of(describe: impl Fn(&str) -> Element) -> String {
    let digits = format!("{:032x}", hash::of_bytes(describe("").document().as_bytes()));
    let [a, b, c, d, e] = [0..8, 8..12, 12..16, 16..20, 20..32].map(|range| &digits[range]);
    format!("{{{a}-{b}-{c}-{d}-{e}}}")
}

/// The description's element, for a version of the standard with its token.
pub(super) fn head(identity: &Identity, version: &str, (token, value): (&'static str, &str)) -> Element {
    Element::new("fmiModelDescription")
        .with("fmiVersion", version)
        .with("modelName", identity.name)
        .with(token, value)
        .with("description", identity.description)
        .with("author", identity.author)
        .with("version", identity.version)
        .with("license", identity.license)
        .with("generationTool", identity.generation_tool)
        .with("variableNamingConvention", "structured")
}

pub(super) fn default_experiment(identity: &Identity) -> Element {
    Element::new("DefaultExperiment")
        .with("startTime", 0)
        .with("stopTime", Number(identity.stop_time))
        .with("tolerance", Number(identity.tolerance))
        .with("stepSize", Number(identity.step_size))
}

/// A unit, with its display units.
pub(super) fn unit_definition(unit: &UnitDefinition) -> Element {
    let base = unit
        .exponents
        .iter()
        .fold(Element::new("BaseUnit"), |base, (name, exponent)| {
            base.with(name, exponent)
        });
    let display = unit.display.iter().map(|(name, factor)| {
        let display = Element::new("DisplayUnit").with("name", name);
        display.with("factor", Number(*factor))
    });
    Element::new("Unit")
        .with("name", unit.name)
        .child(base)
        .children(display)
}

/// The items of an enumeration.
pub(super) fn items(enumeration: &Enumeration) -> impl Iterator<Item = Element> {
    enumeration.items.iter().map(|item| {
        Element::new("Item")
            .with("name", item.name)
            .with("value", item.value)
            .with("description", item.description)
    })
}

/// Every log category, described by `describe`.
pub(super) fn log_categories(describe: fn(Category) -> &'static str) -> Element {
    Element::new("LogCategories").children(Category::ALL.into_iter().map(|category| {
        Element::new("Category")
            .with("name", category.name())
            .with("description", describe(category))
    }))
}

/// The element of a variable, or of the array that begins with it, whatever its type.
pub(super) fn variable_head<S, R>(
    tag: &'static str,
    variable: &Variable<S, R>,
    [name, description]: [&String; 2],
) -> Element {
    let (causality, variability, initial) = role(variable);
    Element::new(tag)
        .with("name", name)
        .with("valueReference", variable.reference)
        .with("description", description)
        .with("causality", causality)
        .with("variability", variability)
        .with_some("initial", initial)
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

/// With the attributes of a variable's type, and its start value if it is a setting.
pub(super) fn typed<S, R>(element: Element, variable: &Variable<S, R>, settings: &S) -> Element {
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

/// With the dependencies of an unknown on these known variables, given by the numbers that the version of the standard uses.
pub(super) fn depending(unknown: Element, known: impl IntoIterator<Item = u32>) -> Element {
    let numbers: Vec<_> = known.into_iter().map(|number| number.to_string()).collect();
    unknown
        .with("dependencies", numbers.join(" "))
        .with("dependenciesKind", vec!["dependent"; numbers.len()].join(" "))
}
