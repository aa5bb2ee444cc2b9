//! Two variators coupled by a master that sorts their variables by the dependencies in the model description.

use std::collections::{BTreeMap, BTreeSet};

use pushbelt::fmi::Unit;
use pushbelt::fmi::log::Status::Ok;
use pushbelt::unit::exports::c_abi::*;
use pushbelt::unit::{VariatorUnit, model_description};

use crate::importer::*;

/// A variable of one of the two units.
type Node = (usize, String);

/// For each output, the names on which it depends in initialisation mode: all settings where the description has no list.
fn initial_dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let table = VariatorUnit::table();
    let names: Vec<_> = table.variables().iter().map(|variable| variable.name.clone()).collect();
    let name = |index: &str| names[index.parse::<usize>().expect("an index") - 1].clone();
    let settings = || {
        let settings = table
            .variables()
            .iter()
            .filter(|variable| variable.causality.is_setting());
        settings.map(|variable| variable.name.clone())
    };
    let description = model_description();
    let (_, unknowns) = description.split_once("<InitialUnknowns>").expect("a list");
    let attribute = |line: &str, name: &str| {
        let (_, rest) = line.split_once(&format!(" {name}=\""))?;
        Some(rest.split('"').next()?.to_owned())
    };
    let lines = unknowns.lines().filter(|line| line.contains("<Unknown "));
    lines
        .map(|line| {
            let unknown = name(&attribute(line, "index").expect("an index"));
            let known = attribute(line, "dependencies");
            let known = known.map_or_else(
                || settings().collect(),
                |list| list.split_whitespace().map(name).collect(),
            );
            (unknown, known)
        })
        .collect()
}

/// An order in which each connected output can be read after what it depends on, or the outputs in a loop.
fn sort(connections: &[(Node, Node)]) -> Result<Vec<(Node, Node)>, Vec<Node>> {
    let depends = initial_dependencies();
    let mut left = connections.to_vec();
    let mut order = Vec::new();
    while !left.is_empty() {
        let is_ready = |(from, _): &(Node, Node)| {
            let needs = &depends[&from.1];
            !left
                .iter()
                .any(|(_, (unit, input))| *unit == from.0 && needs.contains(input))
        };
        let (ready, waiting): (Vec<_>, Vec<_>) = left.iter().cloned().partition(is_ready);
        if ready.is_empty() {
            return Err(waiting.into_iter().map(|(from, _)| from).collect());
        }
        order.extend(ready);
        left = waiting;
    }
    std::result::Result::Ok(order)
}

fn connection(from: (usize, &str), to: (usize, &str)) -> (Node, Node) {
    ((from.0, from.1.to_owned()), (to.0, to.1.to_owned()))
}

/// The second unit drives the first one's primary shaft: it follows its speed and returns its torque.
#[test]
fn units_coupled_by_speed_and_torque_have_no_loop_at_the_start() {
    let connections = [
        connection((1, "secondary.externalTorque"), (0, "primary.torque")),
        connection((0, "primary.speed"), (1, "secondary.speedSetpoint")),
    ];
    let order = sort(&connections).unwrap_or_else(|outputs| panic!("a loop of {outputs:?}"));
    assert_eq!(order[0].0.1, "primary.speed");
    let units = [Importer::new(c"first"), Importer::new(c"second")];
    for unit in &units {
        unit.make_cheap();
        assert_eq!(unit.set_boolean("initial.steady", 1), Ok);
    }
    assert_eq!(units[1].set_integer("secondary.drive", 2), Ok);
    assert_eq!(units[0].set_real("initial.primarySpeed", 180.0), Ok);
    assert_eq!(units[0].set_real("secondary.torque", -30.0), Ok);
    assert_eq!(units[1].set_real("primary.torque", 35.0), Ok);
    for unit in &units {
        // SAFETY: an instance.
        unsafe {
            assert_eq!(fmi2SetupExperiment(unit.c, 1, 1e-4, 0.0, 0, 0.0), Ok);
            assert_eq!(fmi2EnterInitializationMode(unit.c), Ok);
        }
    }
    // The torque at a shaft with a set point is the one that it needs; the other shaft has its reaction.
    let passed = |from: &Node| {
        let value = units[from.0].real(&from.1);
        if from.1 == "secondary.externalTorque" {
            -value
        } else {
            value
        }
    };
    let transfer = || {
        for (from, to) in &order {
            assert_eq!(units[to.0].set_real(&to.1, passed(from)), Ok);
        }
    };
    transfer();
    // One pass is consistent: nothing that was read has changed.
    for (from, to) in &order {
        assert_eq!(units[to.0].real(&to.1), passed(from), "{from:?} to {to:?}");
    }
    let [driven, driving] = [units[1].real("secondary.speed"), units[0].real("primary.speed")];
    assert!((driven / driving - 1.0).abs() < 1e-14, "{driven} {driving}");
    for unit in &units {
        // SAFETY: an instance.
        assert_eq!(unsafe { fmi2ExitInitializationMode(unit.c) }, Ok);
    }
    for k in 0..20 {
        for unit in &units {
            assert_eq!(unit.step(f64::from(k) * 1e-3, 1e-3), Ok, "{:?}", unit.record);
        }
        transfer();
    }
    let [first, second] = [units[0].real("primary.speed"), units[1].real("secondary.speed")];
    assert!((first - second).abs() < 0.01 * first, "{first} {second}");
}

/// The secondary speed follows from the load in a steady start: this loop is a real one, which a master has to iterate.
#[test]
fn a_loop_through_the_secondary_shaft_is_found() {
    let connections = [
        connection((1, "primary.externalTorque"), (0, "secondary.torque")),
        connection((0, "secondary.speed"), (1, "primary.speedSetpoint")),
    ];
    assert_eq!(sort(&connections).expect_err("a loop").len(), 2);
}
