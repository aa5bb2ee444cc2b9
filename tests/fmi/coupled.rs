//! Two variators coupled by a master that sorts their variables by the dependencies in the model description.

use std::collections::{BTreeMap, BTreeSet};

use pushbelt::fmi::Unit;
use pushbelt::fmi::log::Status::Ok;
use pushbelt::fmi::slave::Version::Two;
use pushbelt::fmi::unit::Experiment;
use pushbelt::unit::{VariatorUnit, model_description};

use crate::importer::Handles;
use crate::variator::Importer;

/// A variable of one of the two units.
type Node = (usize, &'static str);

/// For each output, the names on which it depends in initialisation mode: all settings where the description has no list.
fn initial_dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let table = VariatorUnit::table();
    let variables = table.variables();
    let name = |index: &str| variables[index.parse::<usize>().expect("an index") - 1].name.clone();
    let settings = || variables.iter().filter(|variable| variable.causality.is_setting());
    let description = model_description();
    let (_, unknowns) = description.split_once("<InitialUnknowns>").expect("a list");
    let attribute = |line: &str, name: &str| {
        let (_, rest) = line.split_once(&format!(" {name}=\""))?;
        Some(rest.split('"').next()?.to_owned())
    };
    let dependencies = |line: &str| {
        let known = match attribute(line, "dependencies") {
            Some(list) => list.split_whitespace().map(name).collect(),
            None => settings().map(|variable| variable.name.clone()).collect(),
        };
        (name(&attribute(line, "index").expect("an index")), known)
    };
    let lines = unknowns.lines().filter(|line| line.contains("<Unknown "));
    lines.map(dependencies).collect()
}

/// An order in which each connected output can be read after what it depends on, or the outputs in a loop.
fn sort(connections: &[(Node, Node)]) -> Result<Vec<(Node, Node)>, Vec<Node>> {
    let depends = initial_dependencies();
    let mut left = connections.to_vec();
    let mut order = Vec::new();
    while !left.is_empty() {
        let is_ready = |(from, _): &(Node, Node)| {
            let needs = &depends[from.1];
            !left
                .iter()
                .any(|(_, (unit, input))| *unit == from.0 && needs.contains(*input))
        };
        let (ready, waiting): (Vec<_>, Vec<_>) = left.iter().copied().partition(is_ready);
        if ready.is_empty() {
            return Err(waiting.into_iter().map(|(from, _)| from).collect());
        }
        order.extend(ready);
        left = waiting;
    }
    Result::Ok(order)
}

/// The second unit drives the first one's primary shaft: it follows its speed and returns its torque.
#[test]
fn units_coupled_by_speed_and_torque_have_no_loop_at_the_start() {
    let order = sort(&[
        ((1, "secondary.externalTorque"), (0, "primary.torque")),
        ((0, "primary.speed"), (1, "secondary.speedSetpoint")),
    ]);
    let order = order.unwrap_or_else(|outputs| panic!("a loop of {outputs:?}"));
    assert_eq!(order[0].0.1, "primary.speed");
    let units = [(); 2].map(|()| Importer::coarse(Two, Handles::default()));
    units[1].choose("secondary.drive", 2);
    units[0].put("initial.primarySpeed", 180.0);
    units[0].put("secondary.torque", -30.0);
    units[1].put("primary.torque", 35.0);
    for unit in &units {
        unit.flag("initial.steady", true);
        assert_eq!(unit.enter(Experiment::default()), Ok);
    }
    // The torque at a shaft with a set point is the one that it needs; the other shaft has its reaction.
    let passed = |(unit, name): Node| {
        let value = units[unit].get(name);
        if name == "secondary.externalTorque" {
            -value
        } else {
            value
        }
    };
    let transfer = || order.iter().for_each(|(from, to)| units[to.0].put(to.1, passed(*from)));
    transfer();
    // One pass is consistent: nothing that was read has changed.
    for (from, to) in &order {
        assert_eq!(units[to.0].get(to.1), passed(*from), "{from:?} to {to:?}");
    }
    let [driven, driving] = [units[1].get("secondary.speed"), units[0].get("primary.speed")];
    assert!((driven / driving - 1.0).abs() < 1e-14, "{driven} {driving}");
    for unit in &units {
        assert_eq!(unit.exit(), Ok);
    }
    for k in 0..20 {
        units.iter().for_each(|unit| unit.advance(f64::from(k) * 1e-3, 1e-3));
        transfer();
    }
    let [first, second] = [units[0].get("primary.speed"), units[1].get("secondary.speed")];
    assert!((first - second).abs() < 0.01 * first, "{first} {second}");
}

/// The secondary speed follows from the load in a steady start: this loop is a real one, which a master has to iterate.
#[test]
fn a_loop_through_the_secondary_shaft_is_found() {
    let sorted = sort(&[
        ((1, "primary.externalTorque"), (0, "secondary.torque")),
        ((0, "secondary.speed"), (1, "primary.speedSetpoint")),
    ]);
    assert_eq!(sorted.expect_err("a loop").len(), 2);
}
