//! The checked-in model description, and rules for it that validators of FMI don't check.

use pushbelt::fmi::table::{Causality, Kind, Value};
use pushbelt::fmi::{Unit, Version};
use pushbelt::unit::{Settings, TERMINALS, VariatorUnit, model_description, terminals};
use pushbelt::variator::settings::range_of;
use std::collections::BTreeSet;
use std::path::Path;

#[test]
fn the_checked_in_files_are_generated_from_the_table() {
    for (name, generated) in [
        ("modelDescription.xml", model_description(Version::Two)),
        ("resources/modelDescription3.xml", model_description(Version::Three)),
        ("resources/terminalsAndIcons.xml", terminals()),
        ("fmu-build/exports.def", pushbelt_library::definition()),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        let checked_in = std::fs::read_to_string(&path).unwrap_or_default();
        let differing = generated.lines().zip(checked_in.lines()).position(|(a, b)| a != b);
        let shorter = generated.lines().count().min(checked_in.lines().count());
        assert!(
            generated == checked_in,
            "{name} differs from the tables, first in line {}; write it by `cargo fmu describe`",
            differing.map_or(shorter, |line| line + 1)
        );
    }
}

#[test]
fn terminals_have_an_input_and_an_output() {
    let table = VariatorUnit::table();
    for terminal in TERMINALS {
        let causality = |(_, name): &(_, &str)| table.by_name(name).map(|variable| variable.causality);
        let found: Vec<_> = terminal.members.iter().map(causality).collect();
        let expected = [Some(Causality::Input), Some(Causality::Output)];
        assert_eq!(found, expected, "{}", terminal.name);
    }
}

#[test]
fn names_and_value_references_are_unique() {
    let table = VariatorUnit::table();
    let variables = table.variables();
    let names: BTreeSet<_> = variables.iter().map(|v| &v.name).collect();
    let references: BTreeSet<_> = variables.iter().map(|v| v.reference).collect();
    assert_eq!([names.len(), references.len()], [variables.len(); 2]);
    let retired: Vec<u32> = table.retired.iter().map(|one| one.reference).collect();
    assert_eq!(retired, [1036, 1039, 1075, 1048, 1045]);
    for retired in table.retired {
        assert!(!references.contains(&retired.reference), "{retired} is used again");
        assert!(table.by_name(retired.name).is_none(), "{retired}");
    }
}

/// Importer tools store these numbers: new ones may be added, but none may change.
#[test]
fn value_references_do_not_change() {
    let table = VariatorUnit::table();
    for (name, reference) in [
        ("primary.torque", 101),
        ("secondary.clampingForce", 202),
        ("secondary.speedSetpoint", 203),
        ("thrustRatio", 1),
        ("pastPeak", 38),
        ("spiral.primary", 118),
        ("primary.drive", 131),
        ("secondary.maxRadius", 239),
        ("friction.pulley", 1051),
        ("solver.maxStep", 1082),
        ("profile.slidingSpeed[72]", 10_572),
    ] {
        let variable = table.by_name(name).unwrap_or_else(|| panic!("{name} is missing"));
        assert_eq!(variable.reference, reference, "{name}");
    }
}

/// A setting has a value without readings, nothing else has, and that value is legal: no tool
/// detects a start value outside min and max. Every number that is set has a range. A calculated
/// number has a nominal value within its range: importers scale by it, and the default 1 is far
/// from a slip of 0.003.
#[test]
fn settings_have_legal_start_values_and_outputs_a_typical_size() {
    let mut settings = Settings::default();
    for variable in VariatorUnit::table().variables() {
        let (name, start) = (&variable.name, variable.value(&settings, None));
        assert_eq!(start.is_some(), variable.causality.is_setting(), "{name}");
        let Some(start) = start else {
            if let Kind::Real { range, .. } = &variable.kind {
                let nominal = range.nominal.unwrap_or_else(|| panic!("{name} has none"));
                assert!(nominal > 0.0 && range.max.is_none_or(|max| nominal <= max), "{name}");
            }
            continue;
        };
        assert_eq!(variable.set(&mut settings, start), Ok(()));
        let number = matches!(variable.kind, Kind::Real { .. } | Kind::Integer { .. });
        assert!(!number || range_of(name).is_some(), "{name}");
    }
    assert_eq!(VariatorUnit::check(&settings), Ok(()));
}

/// Detects two rows bound to the same field, and a row bound to the wrong one: a value, of an
/// enumeration each item, reads back from its own variable and from no other.
#[test]
fn each_setting_has_a_field_of_its_own() {
    let table = VariatorUnit::table();
    let variables = table.variables();
    let read =
        |settings: &Settings| -> Vec<_> { variables.iter().map(|one| one.value(settings, None)).collect() };
    let before = read(&Settings::default());
    for (at, variable) in variables.iter().enumerate() {
        let others = match (&variable.kind, before[at]) {
            (_, None) => continue,
            (Kind::Real { range, .. }, Some(Value::Real(start))) => {
                vec![Value::Real(range.max.map_or(2.0 * start, |max| 0.5 * (start + max)))]
            }
            (Kind::Enumeration { of, .. }, Some(start)) => {
                let items = of.items.iter().map(|item| Value::Integer(item.value.into()));
                items.filter(|item| *item != start).collect()
            }
            (_, Some(Value::Integer(start))) => vec![Value::Integer(start + 1)],
            (_, Some(Value::Boolean(start))) => vec![Value::Boolean(!start)],
            (_, Some(start)) => panic!("{} = {start} has another type", variable.name),
        };
        for other in others {
            let mut settings = Settings::default();
            assert_eq!(variable.set(&mut settings, other), Ok(()));
            let after = read(&settings);
            let moved: Vec<_> = (0..before.len()).filter(|i| before[*i] != after[*i]).collect();
            assert_eq!((moved, after[at]), (vec![at], Some(other)), "{}", variable.name);
        }
    }
}
