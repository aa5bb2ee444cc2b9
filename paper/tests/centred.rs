//! `ALE0` with arcs about the axes, as in the paper: its two statements on overdrive and on spiral
//! running.

use std::sync::Arc;

use pushbelt::variator::ring_models::{Ale, Ale0, BeltRing};
use pushbelt::variator::settings::{Drive, Parameters, RIGID_TILT_STIFFNESS, RingModel};
use pushbelt_paper::centred::Centred;
use pushbelt_support::disturbed::{assert_jacobian, disturbed_with, small};
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::run::Run;
use pushbelt_support::steady::load_case_with;
use pushbelt_support::variators::{inputs, variator};

fn rings() -> [(RingModel, Arc<dyn BeltRing>); 3] {
    [
        (RingModel::Ale0, Arc::new(Centred)),
        (RingModel::Ale0, Arc::new(Ale0)),
        (RingModel::Ale, Arc::new(Ale::<2>)),
    ]
}

#[test]
fn jacobian_matches_differences() {
    assert_jacobian(disturbed_with(&small(RingModel::Ale0), Arc::new(Centred), 200.0), 0.4);
}

/// Thrust ratio and spiral running in medium and overdrive, with the default sheaves and with rigid
/// ones. The elements stay on circles about the axes. In underdrive their primary pulley slips
/// through at 30 and 50 N·m.
#[test]
fn thrust_ratio_and_spiral_running() {
    for rigid in [false, true] {
        for torque in [30.0, 50.0, 100.0] {
            for case in &LoadCase::three(&Parameters::default(), torque)[1..] {
                let [centred, free, deflecting] = rings().map(|(model, ring)| {
                    let mut parameters = variator(model);
                    if rigid {
                        parameters.primary.tilt.stiffness = RIGID_TILT_STIFFNESS;
                        parameters.secondary.tilt.stiffness = RIGID_TILT_STIFFNESS;
                    }
                    load_case_with(&parameters, ring, case)
                });
                let thrust = |of: &pushbelt_support::steady::Steady| of.outputs.thrust_ratio;
                let spiral = |of: &pushbelt_support::steady::Steady| {
                    of.outputs.primary.spiral.max(of.outputs.secondary.spiral)
                };
                println!(
                    "{}, {torque} N·m, rigid sheaves {rigid}: thrust ratio {:.3}, {:.3} with free centres, {:.3} ALE ({:+.1} %, {:+.1} %); \
                     spiral {:.3}, {:.3}, {:.3} mm",
                    case.name,
                    thrust(&centred),
                    thrust(&free),
                    thrust(&deflecting),
                    100.0 * (thrust(&centred) / thrust(&deflecting) - 1.0),
                    100.0 * (thrust(&free) / thrust(&deflecting) - 1.0),
                    1e3 * spiral(&centred),
                    1e3 * spiral(&free),
                    1e3 * spiral(&deflecting),
                );
                for centre in centred.system.belt.layout.centres() {
                    assert_eq!(centred.state.q[centre], 0.0);
                }
                assert!(spiral(&centred) < 1e-6 && spiral(&deflecting) > 1e-5);
                assert!(centred.power_defect().abs() < 1e-3, "{}", centred.power_defect());
            }
        }
    }
}

/// The balances of energy and elements under a primary force that is raised by a fifth. The ratio
/// hardly moves: without spiral running, all elements slide radially at once.
#[test]
fn balances_under_a_step_of_force() {
    let mut parameters = variator(RingModel::Ale0);
    parameters.primary.drive = Drive::Speed;
    let [centred, free] = rings()
        .map(|(_, ring)| ring)
        .into_iter()
        .take(2)
        .map(|ring| {
            let mut run = Run::with_ring(parameters.clone(), ring, inputs((0.0, 13e3), (-49.0, 10e3)));
            run.inputs.primary.clamping_force = 1.2 * run.variator.outputs().primary.axial_force;
            let start = run.variator.outputs().ratio_geometric;
            run.watch(0.1, 1e-3, |_, _| {});
            run.assert_balances();
            run.variator.outputs().ratio_geometric / start - 1.0
        })
        .collect::<Vec<_>>()[..]
    else {
        unreachable!("two rings")
    };
    println!("change of the ratio in 0.1 s: {centred:+.4}, with free centres {free:+.4}");
    assert!(free < -0.02 && centred > 0.5 * free);
}
