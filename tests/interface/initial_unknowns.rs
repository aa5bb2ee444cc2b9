//! Dependencies of the outputs in initialisation mode: those that the table declares, and those
//! that are found by changes of each setting.

use pushbelt::fmi::Unit;
use pushbelt::fmi::table::{Causality, Kind, Table, Value, Variable};
use pushbelt::fmi::unit::Experiment;
use pushbelt::unit::{Settings, VariatorUnit};
use pushbelt::variator::settings::Readings;
use std::collections::{BTreeMap, BTreeSet};

type Row = Variable<Settings, Readings>;

/// Rounding as a share of a value: a speed is passed on as that of the belt, over radii.
const ROUNDING: f64 = 1e-14;
/// Speed below which a shaft stands still, rad/s.
const STILL: f64 = 1e-3;

/// Settings in which one differs a little, if there are such.
fn changed(variable: &Row, settings: &Settings) -> Option<Settings> {
    let value = variable.value(settings, None)?;
    let candidates: Vec<Value> = match (&variable.kind, value) {
        (_, Value::Real(value)) => [1.001 * value, 0.999 * value, value + 1e-3, value - 1e-3]
            .map(Value::Real)
            .into(),
        (Kind::Enumeration { of, .. }, _) => {
            of.items.iter().map(|item| Value::Integer(item.value.into())).collect()
        }
        (_, Value::Integer(value)) => [value + 1, value + 2, value - 1].map(Value::Integer).into(),
        (_, Value::Boolean(value)) => vec![Value::Boolean(!value)],
    };
    let others = candidates.into_iter().filter(|other| *other != value);
    let mut legal = others.filter_map(|other| {
        let mut changed = settings.clone();
        variable.set(&mut changed, other).ok()?;
        VariatorUnit::check(&changed).ok()?;
        Some(changed)
    });
    legal.next()
}

fn number(value: Value) -> f64 {
    match value {
        Value::Real(value) => value,
        Value::Integer(value) => i32::try_from(value).expect("a count").into(),
        Value::Boolean(value) => f64::from(u8::from(value)),
    }
}

/// The outputs at the start, if there is one.
fn outputs(table: &Table<Settings, Readings>, settings: &Settings) -> Option<Vec<(String, f64)>> {
    let mut unit = VariatorUnit::start(settings, &Experiment::default(), &mut Vec::new()).ok()?;
    let readings = unit.readings(false);
    let of = |variable: &Row| {
        let value = variable.value(settings, Some(readings)).expect("readings");
        (variable.name.clone(), number(value))
    };
    let outputs = table.variables().iter().filter(|v| v.causality == Causality::Output);
    Some(outputs.map(of).collect())
}

/// A coarse reference ring with these values.
fn settings(table: &Table<Settings, Readings>, values: &[(&str, Value)]) -> Settings {
    let coarse = ["ring.model", "mesh.primaryArc", "mesh.secondaryArc", "mesh.strand"];
    let coarse = coarse.into_iter().zip([1, 4, 4, 4].map(Value::Integer));
    let mut settings = Settings::default();
    for (name, value) in coarse.chain(values.iter().copied()) {
        let variable = table.by_name(name).expect("listed");
        variable.set(&mut settings, value).expect("admissible");
    }
    settings
}

/// The settings on which each output depends, by trial about these settings.
fn found(table: &Table<Settings, Readings>, settings: &Settings) -> BTreeMap<String, BTreeSet<String>> {
    let at = outputs(table, settings).expect("a start");
    let mut depends = BTreeMap::<_, BTreeSet<_>>::new();
    for known in table.variables().iter().filter(|v| v.causality.is_setting()) {
        let Some(others) = changed(known, settings).and_then(|changed| outputs(table, &changed)) else {
            continue;
        };
        for ((name, before), (_, after)) in at.iter().zip(others) {
            let size = before.abs().max(after.abs());
            let stands = name.ends_with(".speed") && size < STILL;
            if (after - before).abs() > ROUNDING * size && !stands {
                depends.entry(name.clone()).or_default().insert(known.name.clone());
            }
        }
    }
    depends
}

/// Every dependency that is found is declared, for shafts under torque or with a set point at the
/// primary one; and each that is declared is found in one of the starts.
#[test]
fn the_declared_dependencies_are_those_that_are_found() {
    use Value::{Boolean as B, Integer as I, Real as R};
    let table = VariatorUnit::table();
    #[rustfmt::skip]
    let starts: &[&[(&str, Value)]] = &[
        &[],
        &[("initial.steady", B(false))],
        &[("initial.equilibrium", B(true))],
        &[("initial.primarySpeed", R(0.0))],
        &[("initial.ratio", R(1.8)), ("primary.torque", R(-20.0)), ("secondary.torque", R(30.0))],
        &[("primary.drive", I(2))],
        &[("primary.drive", I(2)), ("secondary.drive", I(2))],
        &[("initial.steady", B(false)), ("secondary.drive", I(2))],
        &[("primary.axial", I(2))],
        &[("solver.mode", I(2))],
        &[("belt.kind", I(2))],
        &[("initial.primarySpeed", R(0.0)), ("secondary.axial", I(2)), ("primary.cylinder.area", R(0.01)),
          ("primary.cylinder.seal", R(100.0))],
        &[("initial.primarySpeed", R(0.0)), ("primary.axial", I(2)), ("secondary.cylinder.area", R(0.01))],
    ];
    let mut seen = BTreeMap::<String, BTreeSet<String>>::new();
    for start in starts {
        for (name, knowns) in found(&table, &settings(&table, start)) {
            let output = table.by_name(&name).expect("listed");
            if let Some(declared) = table.initial_dependencies(output) {
                let declared: BTreeSet<_> =
                    declared.iter().map(|place| &table.variables()[*place].name).collect();
                let missing: Vec<_> = knowns.iter().filter(|known| !declared.contains(known)).collect();
                assert!(missing.is_empty(), "{name} with {start:?} also depends on {missing:?}");
            }
            seen.entry(name).or_default().extend(knowns);
        }
    }
    let outputs = || table.variables().iter().filter(|v| v.causality == Causality::Output);
    let listed = outputs().filter_map(|v| Some((v, table.initial_dependencies(v)?)));
    assert_eq!(listed.clone().count(), 12);
    for (output, places) in listed {
        let seen = seen.remove(&output.name).unwrap_or_default();
        for place in places {
            let known = &table.variables()[place].name;
            assert!(seen.contains(known), "{} does not depend on {known}", output.name);
        }
    }
    // What has no list depends on the loads, but for outputs of misaligned pulleys and slipping ones.
    for output in outputs() {
        let others =
            ["belt.lateralMax", "belt.skew", "macroSlip", "pastPeak"].contains(&output.name.as_str());
        if table.initial_dependencies(output).is_none() && !others {
            assert!(seen[&output.name].contains("secondary.torque"), "{}", output.name);
        }
    }
}

/// A set point at the secondary shaft alone: the primary speed is solved for, as the documentation
/// says.
#[test]
fn with_a_set_point_at_the_secondary_shaft_alone_the_primary_speed_depends_on_loads() {
    let table = VariatorUnit::table();
    let depends = found(&table, &settings(&table, &[("secondary.drive", Value::Integer(2))]));
    assert!(depends["primary.speed"].contains("primary.torque"));
}
