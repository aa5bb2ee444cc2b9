//! Derivatives of steady starts.

use pushbelt::fmi::unit::{Experiment, Unit};
use pushbelt::unit::{Settings, VariatorUnit, gradient};
use pushbelt::variator::settings::{Axial, Drive};
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::variators::{MODELS, SPEED, chain, variator};
use serde_json::Value;

/// Laws, loads and content; then geometry, ratio and speed. With the relative step of the reference.
const VARIABLES: [&str; 20] = [
    "friction.pulley",
    "friction.ring",
    "friction.velocity",
    "belt.play",
    "belt.pushStiffness",
    "contact.stiffness",
    "primary.torque",
    "secondary.clampingForce",
    "secondary.tiltStiffness",
    "secondary.tiltClearance",
    "secondary.drag.constant",
    "belt.filmDamping",
    "ring.bendingStiffness",
    "belt.pitchOffset",
    "geometry.beltLength",
    "geometry.centerDistance",
    "geometry.wedgeAngle",
    "initial.ratio",
    "initial.primarySpeed",
    "secondary.speedSetpoint",
];

fn settings(case: &LoadCase, parameters: &pushbelt::variator::settings::Parameters) -> Settings {
    let mut found = Settings {
        parameters: parameters.clone(),
        ..Settings::default()
    };
    let p = &mut found.parameters;
    (
        p.initial.steady,
        p.initial.ratio,
        p.initial.primary_speed,
        p.initial.equilibrium,
    ) = (true, case.task().ratio, SPEED, false);
    (p.primary.axial, p.secondary.drive) = (Axial::Held, Drive::Speed);
    found.inputs.primary.torque = case.torque;
    found.inputs.secondary.clamping_force = case.clamping;
    found.inputs.secondary.speed_setpoint = SPEED / case.task().ratio;
    found
}

fn answer(unit: &mut VariatorUnit, settings: &Settings, references: &[u32]) -> Value {
    serde_json::from_str(&gradient(unit, settings, references).expect("a gradient")).expect("JSON")
}

#[test]
fn a_gradient_is_that_of_converged_states() {
    for parameters in [MODELS.map(variator).to_vec(), vec![chain(MODELS[1])]].concat() {
        for case in LoadCase::three(&parameters, 50.0) {
            let table = VariatorUnit::table();
            let settings = settings(&case, &parameters);
            let mut unit =
                VariatorUnit::start(&settings, &Experiment::default(), &mut Vec::new()).expect("a start");
            let known: Vec<_> = VARIABLES
                .iter()
                .filter_map(|name| {
                    let f = table.by_name(name);
                    if f.is_none() {
                        println!("unknown {name}");
                    }
                    f
                })
                .collect();
            let references: Vec<u32> = known.iter().map(|v| v.reference).collect();
            let begin = std::time::Instant::now();
            let found = answer(&mut unit, &settings, &references);
            println!("{} {:?}", case.name, begin.elapsed() / references.len() as u32);
            for (k, variable) in known.iter().enumerate() {
                let value: f64 = found["variables"][k]["value"].as_f64().unwrap();
                for relative in [1e-3, 1e-4] {
                    let step = relative * value.abs();
                    let [above, below] = [step, -step].map(|more| {
                        let mut other = settings.clone();
                        variable
                            .set(&mut other, pushbelt::fmi::table::Value::Real(value + more))
                            .expect("a value");
                        let mut unit =
                            VariatorUnit::start_near(&unit, &other, &Experiment::default(), &mut Vec::new())
                                .expect("a start");
                        answer(&mut unit, &other, &[])
                    });
                    let mut worst = (0.0, 0.0, 0.0, String::new());
                    print!("  {} {relative}: ", variable.name);
                    for (i, output) in found["outputs"].as_array().unwrap().iter().enumerate() {
                        let read = |all: &Value| all["outputs"][i]["value"].as_f64().unwrap();
                        let slope = (read(&above) - read(&below)) / (2.0 * step);
                        let Some(own) = found["gradient"][i][k].as_f64() else {
                            continue;
                        };
                        let name = output["name"].as_str().unwrap();
                        if ["thrustRatio", "slip", "loss.total"].contains(&name) {
                            print!("{name} {own:.5e} {slope:.5e}; ");
                        }
                        let error = (own - slope).abs() / slope.abs().max(1e-300);
                        // relative effect on output
                        let size = (slope * value / output["value"].as_f64().unwrap()).abs();
                        if error > worst.0 && size > 1e-2 {
                            worst = (error, own, slope, name.to_string());
                        }
                    }
                    println!("worst {worst:?}");
                }
            }
        }
    }
}
