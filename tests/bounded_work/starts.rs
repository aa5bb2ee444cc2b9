//! The work of starts is bounded, whatever the parameters.

use pushbelt::fmi::Unit;
use pushbelt::fmi::table::{Causality, Kind, Value};
use pushbelt::unit::VariatorUnit;
use pushbelt::variator::settings::{RingModel, range_of};
use pushbelt_support::noise;
use pushbelt_support::run::tried;
use pushbelt_support::variators::{MODELS, inputs, variator};

/// Residuals that a start may take: of the search for a steady state, and of a belt that settles at
/// a standstill, twice.
const MOST_RESIDUALS: u64 = 250_000 + 2 * 20_000;

/// Random parameters and inputs: some near their defaults, some anywhere in their ranges. An error
/// names a variable with its value.
#[test]
fn random_parameters_start_with_bounded_work_or_a_named_error() {
    let table = VariatorUnit::table();
    let mut noise = noise(62);
    let mut uniform = move || noise() + 0.5;
    let (mut started, mut failed) = (0, 0);
    while started + failed < 40 {
        let mut settings = <VariatorUnit as Unit>::Settings::default();
        settings.parameters.ring_model = MODELS[usize::from(uniform() < 0.3)];
        for variable in table.variables() {
            // Meshes and tolerances change the work of a residual or the number of steps, as they
            // are meant to.
            let of_numerics = ["mesh.", "solver.", "inputs.", "initial.ratio"];
            let chosen = variable.causality == Causality::Parameter || variable.causality == Causality::Input;
            let (Kind::Real { .. }, Some(range)) = (&variable.kind, range_of(&variable.name)) else {
                continue;
            };
            if !chosen || of_numerics.iter().any(|name| variable.name.starts_with(name)) || uniform() > 0.2 {
                continue;
            }
            let Some(Value::Real(usual)) = variable.value(&settings, None) else {
                continue;
            };
            let far = uniform() < 0.25;
            let factor = 10_f64.powf((uniform() - 0.5) * if far { 4.0 } else { 0.6 });
            let value = (usual * factor).clamp(*range.start(), *range.end());
            variable.set(&mut settings, Value::Real(value)).expect("in its range");
        }
        if <VariatorUnit as Unit>::check(&settings).is_err() {
            continue;
        }
        let (residuals, error) = tried(settings.parameters, &settings.inputs);
        assert!(residuals <= MOST_RESIDUALS, "{residuals} residuals, {error:?}");
        if let Some(error) = error {
            let named = |name: &str| error.contains(&format!("{name} = "));
            let is_named = table.variables().iter().any(|variable| named(&variable.name));
            assert!(is_named, "{error}");
            failed += 1;
        } else {
            started += 1;
        }
    }
    assert!(started > 10);
}

/// Small forces away from ratio 1 under a small torque: a state is found, or the unloaded one is
/// taken, within the bound.
fn small_clamping_forces(model: RingModel, starts: [(f64, f64); 3]) {
    for (force, ratio) in starts {
        let mut parameters = variator(model);
        parameters.initial.ratio = ratio;
        let (residuals, error) = tried(parameters, &inputs((0.1, force), (-0.1 * ratio, force)));
        assert!(residuals <= MOST_RESIDUALS && error.is_none());
    }
}

#[test]
fn small_clamping_forces_start_with_bounded_work_ale0() {
    small_clamping_forces(RingModel::Ale0, [(50.0, 0.4), (50.0, 2.2), (200.0, 0.6)]);
}

#[test]
fn small_clamping_forces_start_with_bounded_work_ale() {
    small_clamping_forces(RingModel::Ale, [(50.0, 0.6), (200.0, 0.4), (200.0, 1.6)]);
}
