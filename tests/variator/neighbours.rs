//! Steady starts near one another: the same states for a fraction of the work.

use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Drive, Inputs, Outputs, Parameters};
use pushbelt_support::checks::assert_close;
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::run::{restored, started};
use pushbelt_support::variators::{MODELS, SPEED, chain, variator};

type Change = fn(&mut Parameters, &mut Inputs);

/// Changes by some per cent, of laws, loads, geometry and content; and of the driven shaft.
const CHANGES: [Change; 8] = [
    |p, _| p.friction.pulley *= 1.01,
    |p, _| p.belt.pitch_offset *= 1.01,
    |p, _| p.belt.play *= 1.1,
    |p, _| p.geometry.belt_length *= 1.001,
    |_, i| i.secondary.clamping_force *= 1.05,
    |_, i| i.primary.torque *= 1.05,
    |p, _| p.initial.ratio *= 1.01,
    |p, i| {
        (p.primary.drive, p.secondary.drive) = (Drive::Speed, Drive::Torque);
        i.primary.speed_setpoint = SPEED;
        i.secondary.torque = -0.95 * p.initial.ratio * i.primary.torque;
    },
];

fn near(other: &Variator, parameters: Parameters, inputs: &Inputs) -> Variator {
    let mut variator = Variator::new(parameters).expect("valid parameters");
    variator.start_near(other);
    variator.initialise(0.0, inputs).expect("a start");
    variator
}

/// Median of the Jacobians at most 5, the same states within 1e-6, and the work of all a fifth at
/// most, also from a stored state and on another mesh.
#[test]
fn neighbours_are_found_from_one_another() {
    for parameters in [MODELS.map(variator).to_vec(), vec![chain(MODELS[1])]].concat() {
        let (mut jacobians, mut all, mut cold_all) = (Vec::new(), 0, 0);
        for case in LoadCase::three(&parameters, 50.0) {
            let (parameters, inputs) = case.start(&parameters);
            let mut from = started(parameters.clone(), &inputs);
            let stored = restored(&mut from, parameters.clone());
            for (k, change) in CHANGES.into_iter().enumerate() {
                let (mut parameters, mut inputs) = (parameters.clone(), inputs);
                change(&mut parameters, &mut inputs);
                let other = if k % 2 == 0 { &from } else { &stored };
                let mut found = near(other, parameters.clone(), &inputs);
                let mut cold = started(parameters, &inputs);
                let (work, cold_work) = (found.start_work(), cold.start_work());
                jacobians.push(work.factorizations);
                all += work.residuals + 12 * work.factorizations;
                cold_all += cold_work.residuals + 12 * cold_work.factorizations;
                let [a, b] = [found.outputs(), cold.outputs()];
                let read = |o: &Outputs| {
                    [
                        o.primary.axial_force,
                        o.slip,
                        o.losses.total(),
                        o.ratio_geometric,
                        o.primary.speed,
                    ]
                };
                for (a, b) in read(a).into_iter().zip(read(b)) {
                    assert_close(a, b, 1e-6, &format!("change {k}, {}", case.name));
                }
            }
        }
        jacobians.sort_unstable();
        let median = jacobians[jacobians.len() / 2];
        assert!(median <= 5 && 5 * all <= cold_all, "{jacobians:?}, {all} of {cold_all}");
    }
}

/// Where the other state is too far off, or there is none, the start has the bits of one without.
#[test]
fn far_from_a_neighbour_a_start_is_as_without() {
    let [parameters, pins] = [variator(MODELS[1]), chain(MODELS[1])];
    let [under, _, over] = LoadCase::three(&parameters, 50.0);
    let (wanted, inputs) = over.start(&parameters);
    let without = started(wanted.clone(), &inputs);
    let mut unloaded = wanted.clone();
    unloaded.initial.steady = false;
    for (other, inputs_of_other) in [
        under.start(&parameters),
        LoadCase::three(&pins, 50.0)[2].start(&pins),
        (unloaded, inputs),
    ] {
        let found = near(&started(other, &inputs_of_other), wanted.clone(), &inputs);
        assert_eq!(found.state(), without.state());
        assert!(found.start_work().residuals < 2 * without.start_work().residuals);
    }
}
