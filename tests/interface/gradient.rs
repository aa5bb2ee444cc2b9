//! Derivatives of the outputs of a steady start.

use pushbelt::fmi::table::Value;
use pushbelt::fmi::unit::{Experiment, Unit};
use pushbelt::unit::{Settings, VariatorUnit, gradient};
use pushbelt::variator::settings::{Axial, Parameters};
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::shared_library::reference;
use pushbelt_support::variators::{MODELS, chain, variator};

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

/// A steady start at a load case.
fn settings(parameters: &Parameters, case: &LoadCase) -> Settings {
    let (parameters, mut inputs) = case.start(parameters);
    inputs.primary.clamping_force = 1.2 * case.clamping;
    Settings {
        parameters,
        inputs,
        ..Settings::default()
    }
}

fn started(settings: &Settings, near: Option<&VariatorUnit>) -> VariatorUnit {
    let (experiment, mut remarks) = (Experiment::default(), Vec::new());
    let unit = match near {
        Some(near) => VariatorUnit::start_near(near, settings, &experiment, &mut remarks),
        None => VariatorUnit::start(settings, &experiment, &mut remarks),
    };
    unit.expect("a start")
}

struct Gradient(serde_json::Value);

impl Gradient {
    fn new(unit: &mut VariatorUnit, settings: &Settings, variables: &[&str]) -> Self {
        let references: Vec<u32> = variables.iter().map(|name| reference(name)).collect();
        let text = gradient(unit, settings, &references).expect("a gradient");
        Self(serde_json::from_str(&text).expect("JSON"))
    }

    fn row(&self, output: &str) -> usize {
        let mut outputs = self.0["outputs"].as_array().expect("outputs").iter();
        outputs.position(|one| one["name"] == output).expect("an output")
    }

    fn value(&self, output: &str) -> f64 {
        let found = &self.0["outputs"][self.row(output)];
        found["value"].as_f64().expect("a value")
    }

    /// Over the variable of index `k`; not a number where there is none.
    fn derivative(&self, output: &str, k: usize) -> f64 {
        let found = &self.0["gradient"][self.row(output)][k];
        found.as_f64().unwrap_or(f64::NAN)
    }
}

/// Central differences of solved states over 0.1 % of each variable. Of entries above 1 % of the
/// largest of their output half differ by less than 2e-4, and all by less than 1 %.
#[test]
fn a_gradient_is_that_of_solved_states() {
    let table = VariatorUnit::table();
    for parameters in [variator(MODELS[0]), variator(MODELS[1]), chain(MODELS[1])] {
        let mut errors = Vec::new();
        for case in LoadCase::three(&parameters, 50.0) {
            let settings = settings(&parameters, &case);
            let mut unit = started(&settings, None);
            let found = Gradient::new(&mut unit, &settings, &VARIABLES);
            assert_eq!(found.0["held"], "ratio");
            let mut rows = READ.map(|_| Vec::new());
            for (k, name) in VARIABLES.into_iter().enumerate() {
                let value = found.0["variables"][k]["value"].as_f64().expect("a value");
                let [above, below] = [3e-4, -3e-4].map(|step| {
                    let (mut other, moved) = (settings.clone(), Value::Real(value * (1.0 + step)));
                    let variable = table.by_name(name).expect("a variable");
                    variable.set(&mut other, moved).expect("a value");
                    Gradient::new(&mut started(&other, Some(&unit)), &other, &[])
                });
                for (row, output) in rows.iter_mut().zip(READ) {
                    let solved = (above.value(output) - below.value(output)) / 6e-4;
                    row.push((name, value * found.derivative(output, k), solved));
                }
            }
            for (row, output) in rows.iter().zip(READ) {
                let largest = row.iter().fold(0.0, |most: f64, (.., solved)| most.max(solved.abs()));
                for (name, own, solved) in row.iter().filter(|(.., solved)| solved.abs() > 1e-2 * largest) {
                    let error = (own / solved - 1.0).abs();
                    assert!(error < 1e-2, "{output} over {name}, {}: {own}, {solved}", case.name);
                    errors.push(error);
                }
            }
        }
        errors.sort_by(f64::total_cmp);
        let median = errors[(errors.len() - 1) / 2];
        assert!(median < 2e-4, "{errors:?}");
    }
}

/// By the chain rule dy/dp at constant force F is ∂y/∂p − ∂y/∂i ∂F/∂p/(∂F/∂i) at constant ratio i.
#[test]
fn under_both_forces_the_ratio_follows() {
    let parameters = variator(MODELS[1]);
    let mut held = settings(&parameters, &LoadCase::three(&parameters, 50.0)[1]);
    let mut free = held.clone();
    (free.parameters.initial.equilibrium, free.parameters.primary.axial) = (true, Axial::Force);
    let found = Gradient::new(&mut started(&free, None), &free, &VARIABLES);
    assert_eq!(found.0["held"], "clamping forces");
    held.parameters.initial.ratio = found.value("ratio.geometric");
    let other = Gradient::new(&mut started(&held, None), &held, &VARIABLES);
    let ratio = VARIABLES.iter().position(|name| *name == "initial.ratio");
    let ratio = ratio.expect("a variable");
    for output in READ {
        for (k, name) in VARIABLES.iter().enumerate().filter(|(k, _)| *k != ratio) {
            let [of_ratio, of_variable] =
                [ratio, k].map(|k| other.derivative("primary.clampingForceTotal", k));
            let by_ratio = other.derivative(output, ratio) * of_variable / of_ratio;
            let (own, direct) = (found.derivative(output, k), other.derivative(output, k));
            assert!(
                (own - direct + by_ratio).abs() < 3e-3 * (direct.abs() + by_ratio.abs()),
                "{output} over {name}: {own}, {direct} - {by_ratio}"
            );
        }
    }
}

/// At the end of a range, extremes, and what has no gradient.
#[test]
fn a_gradient_is_refused_where_there_is_none() {
    let parameters = variator(MODELS[0]);
    let mut settings = settings(&parameters, &LoadCase::three(&parameters, 50.0)[1]);
    settings.parameters.belt.play = 0.0;
    let mut unit = started(&settings, None);
    let found = Gradient::new(&mut unit, &settings, &["belt.play"]);
    for (name, is_defined) in [("slip", true), ("primary.idleArc", false), ("ring.tensionMax", false)] {
        assert_eq!(found.derivative(name, 0).is_finite(), is_defined, "{name}");
    }
    let refused = |unit: &mut VariatorUnit, references: &[u32], part: &str| {
        let reason = gradient(unit, &settings, references).expect_err("no gradient");
        assert!(reason.contains(part), "{reason}");
    };
    for name in ["belt.kind", "slip"] {
        refused(&mut unit, &[reference(name)], name);
    }
    refused(&mut unit, &[99_999], "99999");
    let mut step = unit.begin(1e-3, &settings, None).expect("a step");
    unit.advance(1e-3, &mut step, &settings, &mut Vec::new())
        .expect("a step");
    unit.finish(&step, &mut Vec::new());
    refused(&mut unit, &[], "before the first step");
}
