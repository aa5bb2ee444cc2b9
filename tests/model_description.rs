//! The checked-in model description, and rules for it that validators of FMI don't check.

use std::collections::BTreeSet;
use std::path::Path;

use pushbelt::fmi::Unit;
use pushbelt::fmi::table::{Access, Causality, Kind, Value, Variable};
use pushbelt::unit::{Settings, TERMINALS, VariatorUnit, model_description, model_description3, terminals};
use pushbelt::variator::settings::range_of;

#[test]
fn the_checked_in_files_are_generated_from_the_table() {
    for (name, generated) in [
        ("modelDescription.xml", model_description()),
        ("resources/modelDescription3.xml", model_description3()),
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

/// Elements of an array differ in name, reference and index only and are in order; every variable with an index is such an element.
#[test]
fn arrays_are_their_elements() {
    let table = VariatorUnit::table();
    let mut elements = 0;
    for array in &table.arrays {
        let first = table.by_reference(array.first).expect("listed");
        for (number, reference) in (1..).zip(array.elements()) {
            let element = table.by_reference(reference).expect("listed");
            assert_eq!(element.name, format!("{}[{number}]", array.name));
            assert_eq!(table.array_of(reference), Some(array));
            assert_eq!(element.causality, first.causality);
            let limits = |variable: &Variable<_, _>| match variable.kind {
                Kind::Real { unit, range, .. } => Some((unit, range)),
                _ => None,
            };
            assert_eq!(limits(element), limits(first));
            let Kind::Real {
                access: Access::Element(_, at),
                ..
            } = &element.kind
            else {
                panic!("{} is no element of reals", element.name);
            };
            assert_eq!(at + 1, number);
            elements += 1;
        }
        for beyond in [array.first - 1, array.first + array.size] {
            assert_eq!(table.array_of(beyond), None);
        }
    }
    let indexed = table.variables().iter().filter(|v| v.name.ends_with(']')).count();
    assert_eq!((table.arrays.len(), elements), (9, indexed));
}

/// A terminal's members are variables, at least one input and one output.
#[test]
fn terminals_have_an_input_and_an_output() {
    let table = VariatorUnit::table();
    for terminal in TERMINALS {
        let causality = |variable: &str| table.by_name(variable).map(|v| v.causality);
        let found: Vec<_> = terminal
            .members
            .iter()
            .map(|(_, variable)| causality(variable))
            .collect();
        assert_eq!(
            found,
            [Some(Causality::Input), Some(Causality::Output)],
            "{}",
            terminal.name
        );
    }
}

#[test]
fn names_and_value_references_are_unique() {
    let table = VariatorUnit::table();
    let names: BTreeSet<_> = table.variables().iter().map(|v| &v.name).collect();
    let references: BTreeSet<_> = table.variables().iter().map(|v| v.reference).collect();
    assert_eq!(names.len(), table.variables().len());
    assert_eq!(references.len(), table.variables().len());
    for retired in table.retired {
        assert!(!references.contains(&retired.reference), "{retired} is used again");
        assert!(table.by_name(retired.name).is_none(), "{retired}");
    }
    for variable in table.variables() {
        let found = table.by_reference(variable.reference).expect("listed");
        assert_eq!(found.name, variable.name);
    }
}

/// Master tools store these numbers: new ones may be added, but none may change.
#[test]
fn value_references_do_not_change() {
    let table = VariatorUnit::table();
    for (name, reference) in [
        ("primary.torque", 101),
        ("secondary.torque", 201),
        ("primary.clampingForce", 102),
        ("secondary.clampingForce", 202),
        ("secondary.speedSetpoint", 203),
        ("thrustRatio", 1),
        ("belt.speed", 2),
        ("macroSlip", 10),
        ("ring.tensionMin", 17),
        ("energy.residual", 19),
        ("secondary.speed", 211),
        ("spiral.primary", 118),
        ("primary.drive", 131),
        ("secondary.maxRadius", 239),
        ("ring.model", 1001),
        ("initial.equilibrium", 1014),
        ("friction.pulley", 1051),
        ("solver.maxStep", 1082),
        ("profile.position[1]", 10_001),
        ("profile.slidingSpeed[72]", 10_572),
    ] {
        let variable = table.by_name(name).unwrap_or_else(|| panic!("{name} is missing"));
        assert_eq!(variable.reference, reference, "{name}");
    }
}

/// A setting has a value without readings, and nothing else has.
#[test]
fn settings_are_bound_to_settings_and_readings_to_readings() {
    for variable in VariatorUnit::table().variables() {
        let bound = variable.value(&Settings::default(), None).is_some();
        assert_eq!(bound, variable.causality.is_setting(), "{}", variable.name);
    }
}

/// No tool detects a start value outside min and max, but the unit refuses it.
#[test]
fn start_values_are_legal() {
    let settings = Settings::default();
    for variable in VariatorUnit::table().variables() {
        let start = variable.value(&settings, None);
        let checked = start.map_or(Ok(()), |start| variable.admit(start).map(drop));
        checked.unwrap_or_else(|error| panic!("{error}"));
    }
    assert_eq!(VariatorUnit::check(&settings), Ok(()));
}

#[test]
fn every_number_that_is_set_has_a_range() {
    for variable in VariatorUnit::table().variables() {
        let number = matches!(variable.kind, Kind::Real { .. } | Kind::Integer { .. });
        if variable.causality.is_setting() && number {
            assert!(range_of(&variable.name).is_some(), "{}", variable.name);
        }
    }
}

/// Detects two rows bound to the same field, and a row bound to the wrong one: a value reads back from its own variable and
/// from no other.
#[test]
fn each_setting_has_a_field_of_its_own() {
    let table = VariatorUnit::table();
    let variables = table.variables();
    let read = |settings: &Settings| -> Vec<_> { variables.iter().map(|one| one.value(settings, None)).collect() };
    let before = read(&Settings::default());
    for (at, variable) in variables.iter().enumerate() {
        let other = match (&variable.kind, before[at]) {
            (_, None) => continue,
            (Kind::Real { range, .. }, Some(Value::Real(start))) => {
                Value::Real(range.max.map_or(2.0 * start, |max| 0.5 * (start + max)))
            }
            (Kind::Enumeration { of, .. }, Some(start)) => {
                let mut items = of.items.iter().map(|item| Value::Integer(item.value.into()));
                items.find(|item| *item != start).expect("there is a choice")
            }
            (_, Some(Value::Integer(start))) => Value::Integer(start + 1),
            (_, Some(Value::Boolean(start))) => Value::Boolean(!start),
            (_, Some(start)) => panic!("{} = {start} has another type", variable.name),
        };
        let mut settings = Settings::default();
        variable
            .set(&mut settings, other)
            .unwrap_or_else(|error| panic!("{error}"));
        let after = read(&settings);
        let moved: Vec<_> = (0..before.len()).filter(|i| before[*i] != after[*i]).collect();
        assert_eq!((moved, after[at]), (vec![at], Some(other)), "{}", variable.name);
    }
}

#[test]
fn every_enumeration_item_can_be_set() {
    for variable in VariatorUnit::table().variables() {
        let Kind::Enumeration { of, .. } = &variable.kind else {
            continue;
        };
        for item in of.items.iter().filter(|_| variable.causality.is_setting()) {
            let (mut settings, value) = (Settings::default(), Value::Integer(item.value.into()));
            assert_eq!(variable.set(&mut settings, value), Ok(()));
            assert_eq!(
                variable.value(&settings, None),
                Some(value),
                "{} {}",
                variable.name,
                item.name
            );
        }
    }
}

#[test]
fn units_and_types_in_use_are_declared() {
    let table = VariatorUnit::table();
    for variable in table.variables() {
        match &variable.kind {
            Kind::Real { unit, display_unit, .. } => {
                let declared = table.units.iter().find(|declared| declared.name == *unit);
                let declared = declared.unwrap_or_else(|| panic!("{}: {unit}", variable.name));
                if let Some(shown) = display_unit {
                    assert!(declared.display.iter().any(|(name, _)| name == shown));
                }
            }
            Kind::Enumeration { of, .. } => {
                assert!(table.enumerations.iter().any(|declared| declared.name == of.name));
            }
            _ => {}
        }
    }
}

/// Importers scale by the nominal value, whose default 1 is far from a slip of 0.003.
#[test]
fn every_real_output_has_a_typical_size_within_its_range() {
    let table = VariatorUnit::table();
    for variable in table
        .variables()
        .iter()
        .filter(|variable| !variable.causality.is_setting())
    {
        if let Kind::Real { range, .. } = &variable.kind {
            let nominal = range.nominal.unwrap_or_else(|| panic!("{} has none", variable.name));
            assert!(nominal > 0.0, "{}", variable.name);
            assert!(range.max.is_none_or(|max| nominal <= max), "{}", variable.name);
        }
    }
}

/// User interfaces show forces in kN, lengths in mm and shares in per cent.
#[test]
fn display_units_are_those_of_engineering_practice() {
    let table = VariatorUnit::table();
    for (name, unit, shown) in [
        ("primary.clampingForce", "kN", 13.0),
        ("geometry.centerDistance", "mm", 168.0),
        ("friction.fall", "%", 6.0),
        ("primary.speedSetpoint", "rpm", 2000.0),
    ] {
        let variable = table.by_name(name).expect("listed");
        let Kind::Real {
            unit: base,
            display_unit,
            ..
        } = &variable.kind
        else {
            panic!("{name} is real");
        };
        assert_eq!(*display_unit, Some(unit), "{name}");
        let mut units = table.units.iter().filter(|declared| declared.name == *base);
        let mut displays = units.next().expect("declared").display.iter();
        let (_, factor) = displays.find(|(name, _)| *name == unit).expect("declared");
        let Some(Value::Real(start)) = variable.value(&Settings::default(), None) else {
            panic!("{name} is a setting");
        };
        let value = factor * start;
        assert!((value - shown).abs() < 1e-5 * shown, "{name}: {value} {unit}");
    }
}

/// The model structure lists every output, and none depends directly on an input.
#[test]
fn model_structure_lists_every_output_without_dependencies() {
    let xml = model_description();
    let (_, structure) = xml.split_once("<ModelStructure>").expect("present");
    let (outputs, initial) = structure.split_once("</Outputs>").expect("present");
    let indices: Vec<String> = VariatorUnit::table()
        .variables()
        .iter()
        .zip(1..)
        .filter(|(variable, _)| variable.causality == Causality::Output)
        .map(|(_, index)| format!("index=\"{index}\""))
        .collect();
    assert_eq!(outputs.matches("<Unknown ").count(), indices.len());
    assert_eq!(initial.matches("<Unknown ").count(), indices.len());
    for index in indices {
        assert!(outputs.contains(&format!("{index} dependencies=\"\" dependenciesKind=\"\"")));
        assert!(initial.contains(&index));
    }
}

/// `canSerializeFMUstate` requires `canGetAndSetFMUstate`, which no tool checks.
#[test]
fn capabilities_are_consistent() {
    let xml = model_description();
    let declared = |flag: &str| xml.contains(&format!("{flag}=\"true\""));
    assert!(declared("canGetAndSetFMUstate") || !declared("canSerializeFMUstate"));
}
