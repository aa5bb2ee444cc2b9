//! Derivatives of the outputs of a steady start.

use pushbelt::fmi::table::Value;
use pushbelt::fmi::unit::{Experiment, Unit};
use pushbelt::unit::{Settings, VariatorUnit, gradient};
use pushbelt::variator::settings::{Axial, Drive, Parameters};
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::variators::{MODELS, SPEED, chain, variator};

/// Laws and content; loads; geometry and speed.
const VARIABLES: [&str; 14] = [
    "friction.pulley",
    "friction.ring",
    "belt.play",
    "belt.pushStiffness",
    "contact.stiffness",
    "secondary.tiltStiffness",
    "secondary.tiltClearance",
    "primary.torque",
    "secondary.clampingForce",
    "belt.pitchOffset",
    "geometry.beltLength",
    "geometry.wedgeAngle",
    "initial.ratio",
    "secondary.speedSetpoint",
];
const READ: [&str; 5] = ["thrustRatio", "slip", "efficiency", "loss.total", "primary.axialForce"];

/// A steady start at a load case; with `held` false in equilibrium of both clamping forces.
fn settings(parameters: &Parameters, case: &LoadCase, held: bool) -> Settings {
    let mut found = Settings {
        parameters: parameters.clone(),
        ..Settings::default()
    };
    let (p, inputs) = (&mut found.parameters, &mut found.inputs);
    (p.initial.steady, p.initial.ratio, p.secondary.drive) = (true, case.task().ratio, Drive::Speed);
    (p.initial.equilibrium, p.primary.axial) = (!held, if held { Axial::Held } else { Axial::Force });
    (inputs.primary.torque, inputs.secondary.clamping_force) = (case.torque, case.clamping);
    inputs.primary.clamping_force = 1.2 * case.clamping;
    inputs.secondary.speed_setpoint = SPEED / p.initial.ratio;
    found
}

fn started(settings: &Settings, near: Option<&VariatorUnit>) -> VariatorUnit {
    let (experiment, mut remarks) = (Experiment::default(), Vec::new());
    let unit = match near {
        Some(near) => VariatorUnit::start_near(near, settings, &experiment, &mut remarks),
        None => VariatorUnit::start(settings, &experiment, &mut remarks),
    };
    unit.expect("a start")
}

fn answer(unit: &mut VariatorUnit, settings: &Settings, references: &[u32]) -> serde_json::Value {
    serde_json::from_str(&gradient(unit, settings, references).expect("a gradient")).expect("JSON")
}

/// Central differences of solved states over 0.1 % of each variable. Of entries above 1 % of the
/// largest of their output half differ by less than 2e-4, and all by less than 1 %.
#[test]
fn a_gradient_is_that_of_solved_states() {
    let table = VariatorUnit::table();
    let variables = VARIABLES.map(|name| table.by_name(name).expect("a variable"));
    let references = variables.map(|variable| variable.reference);
    for parameters in [variator(MODELS[0]), variator(MODELS[1]), chain(MODELS[1])] {
        let mut errors = Vec::new();
        for case in LoadCase::three(&parameters, 50.0) {
            let settings = settings(&parameters, &case, true);
            let mut unit = started(&settings, None);
            let found = answer(&mut unit, &settings, &references);
            assert_eq!(found["held"], "ratio");
            let mut rows = READ.map(|_| Vec::new());
            for (k, variable) in variables.iter().enumerate() {
                let value = found["variables"][k]["value"].as_f64().expect("a value");
                let [above, below] = [1e-3, -1e-3].map(|step| {
                    let (mut other, moved) = (settings.clone(), Value::Real(value * (1.0 + step)));
                    variable.set(&mut other, moved).expect("a value");
                    let mut unit = started(&other, Some(&unit));
                    answer(&mut unit, &other, &[])
                });
                for (i, output) in found["outputs"].as_array().expect("outputs").iter().enumerate() {
                    if let Some(row) = READ.iter().position(|name| output["name"] == *name) {
                        let read =
                            |of: &serde_json::Value| of["outputs"][i]["value"].as_f64().expect("a value");
                        let own = found["gradient"][i][k].as_f64().expect("a derivative");
                        rows[row].push([value * own, (read(&above) - read(&below)) / 2e-3]);
                    }
                }
            }
            for (row, name) in rows.iter().zip(READ) {
                let largest = row.iter().fold(0.0, |most: f64, [_, solved]| most.max(solved.abs()));
                for (k, [own, solved]) in row
                    .iter()
                    .enumerate()
                    .filter(|(_, [_, one])| one.abs() > 1e-2 * largest)
                {
                    let error = (own / solved - 1.0).abs();
                    assert!(
                        error < 1e-2,
                        "{name} over {}, {}: {own}, {solved}",
                        VARIABLES[k],
                        case.name
                    );
                    errors.push(error);
                }
            }
        }
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
        assert!(at(0.5) < 2e-4, "{errors:?}");
    }
}

/// By the chain rule dy/dp at constant force F is ∂y/∂p − ∂y/∂i ∂F/∂p/(∂F/∂i) at constant ratio i.
#[test]
fn under_both_forces_the_ratio_follows() {
    let table = VariatorUnit::table();
    let references = VARIABLES.map(|name| table.by_name(name).expect("a variable").reference);
    let parameters = variator(MODELS[1]);
    let free = settings(&parameters, &LoadCase::three(&parameters, 50.0)[1], false);
    let found = answer(&mut started(&free, None), &free, &references);
    assert_eq!(found["held"], "clamping forces");
    let row = |name: &str| {
        let outputs = found["outputs"].as_array().expect("outputs");
        outputs
            .iter()
            .position(|output| output["name"] == name)
            .expect("an output")
    };
    let mut held = free.clone();
    (held.parameters.initial.equilibrium, held.parameters.primary.axial) = (false, Axial::Held);
    held.parameters.initial.ratio = found["outputs"][row("ratio.geometric")]["value"]
        .as_f64()
        .expect("a ratio");
    let other = answer(&mut started(&held, None), &held, &references);
    let ratio = VARIABLES
        .iter()
        .position(|name| *name == "initial.ratio")
        .expect("a variable");
    let of = |all: &serde_json::Value, output: &str, k: usize| {
        all["gradient"][row(output)][k].as_f64().expect("a derivative")
    };
    for output in READ {
        for (k, name) in VARIABLES.iter().enumerate().filter(|(k, _)| *k != ratio) {
            let force = "primary.clampingForceTotal";
            let [direct, by_ratio] = [
                of(&other, output, k),
                of(&other, output, ratio) * of(&other, force, k) / of(&other, force, ratio),
            ];
            let (own, size) = (of(&found, output, k), direct.abs() + by_ratio.abs());
            assert!(
                (own - direct + by_ratio).abs() < 3e-3 * size,
                "{output} over {name}: {own}, {direct} - {by_ratio}"
            );
        }
    }
}

/// At the end of a range, extremes, and what has no gradient.
#[test]
fn a_gradient_is_refused_where_there_is_none() {
    let parameters = variator(MODELS[0]);
    let case = LoadCase::three(&parameters, 50.0)[1];
    let mut settings = settings(&parameters, &case, true);
    settings.parameters.belt.play = 0.0;
    let mut unit = started(&settings, None);
    let table = VariatorUnit::table();
    let of = |name: &str| table.by_name(name).expect("a variable").reference;
    let found = answer(&mut unit, &settings, &[of("belt.play")]);
    let outputs = found["outputs"].as_array().expect("outputs");
    for (name, is_defined) in [("slip", true), ("primary.idleArc", false), ("ring.tensionMax", false)] {
        let row = outputs
            .iter()
            .position(|output| output["name"] == name)
            .expect("an output");
        assert_eq!(found["gradient"][row][0].is_f64(), is_defined, "{name}");
    }
    for (reference, part) in [(of("belt.kind"), "belt.kind"), (of("slip"), "slip"), (99_999, "99999")] {
        let refused = gradient(&mut unit, &settings, &[reference]).expect_err("no gradient");
        assert!(refused.contains(part), "{refused}");
    }
    let mut step = unit.begin(1e-3, &settings, None).expect("a step");
    unit.advance(1e-3, &mut step, &settings, &mut Vec::new())
        .expect("a step");
    unit.finish(&step, &mut Vec::new());
    assert!(
        gradient(&mut unit, &settings, &[])
            .expect_err("no gradient")
            .contains("before the first step")
    );
}
