//! The pull chain: what a pushbelt has not, its losses, bending, mesh, the manoeuvre. Other files
//! test laws of both belts.

use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_support::checks::{assert_close, assert_mirrored};
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::run::{Run, started};
use pushbelt_support::steady::{Steady, transmitting};
use pushbelt_support::variators::{MODELS, SPEED, chain, inputs};

/// The steady state at a ratio with a torque on the primary shaft, N·m; the secondary shaft turns
/// at `speed`/ratio.
fn driven(parameters: &Parameters, ratio: f64, torque: f64, speed: f64) -> Steady {
    transmitting(parameters, ratio, 11e3, torque, speed)
}

/// What a chain has not reads 0, its pins move with it, power balances, and reverse running mirrors
/// it.
#[test]
fn a_steady_chain_balances_its_power() {
    for model in MODELS {
        for ratio in [2.2, 1.0, 0.5] {
            for torque in [50.0, -30.0] {
                let state = driven(&chain(model), ratio, torque, SPEED);
                let o = &state.outputs;
                let absent = [o.push_force_max, o.losses.ring, o.losses.layers, o.ring_stress.max];
                assert_eq!(absent, [0.0; 4]);
                assert_eq!([o.primary.idle_arc, o.secondary.idle_arc], [0.0; 2]);
                assert!(o.losses.joints > 0.0 && o.ring_tension_min > 0.0);
                // The pins are at the chain's stretched centre line.
                let stretch = o.belt_speed / o.ring_speed - 1.0;
                assert!((-1e-12..2e-3).contains(&stretch), "{stretch}");
                let allowed = if model == RingModel::Ale { 2e-4 } else { 2e-3 };
                assert!(state.power_defect().abs() < allowed, "{}", state.power_defect());
                assert_mirrored(&driven(&chain(model), ratio, -torque, -SPEED).outputs, o, 1e-6);
            }
        }
    }
}

/// Friction that is set anew to what it is costs nothing: kept derivatives stay.
#[test]
fn friction_that_stays_costs_nothing() {
    let steps = |sets: bool| {
        let mut run = started(chain(RingModel::Ale0), &inputs((0.0, 13e3), (-49.0, 10e3)));
        for k in 1..=20 {
            if sets {
                let friction = run.parameters().friction.clone();
                run.set_friction(friction.pulley, friction.ring).expect("in range");
            }
            let torque = 2.0 * f64::from(k);
            run.advance(1e-3 * f64::from(k), &inputs((torque, 13e3), (-49.0, 10e3)))
                .expect("a step");
        }
        assert!(run.parameters().friction.ring > 0.0 && run.system().parameters.friction.ring == 0.0);
        (run.counts(), run.system().differentiations(), run.outputs().clone())
    };
    assert_eq!(steps(true), steps(false));
}

/// Σ T r_j |v|/R over the four borders of the arcs.
#[test]
fn loss_of_the_joints_is_that_of_their_law() {
    for model in MODELS {
        for ratio in [2.2, 0.5] {
            for factor in [1.0, 2.0] {
                let mut parameters = chain(model);
                parameters.joints.radius *= factor;
                let o = driven(&parameters, ratio, 0.0, SPEED).outputs;
                let tension = 0.5 * (o.ring_tension_max + o.ring_tension_min);
                let curvatures = 1.0 / o.primary.radius + 1.0 / o.secondary.radius;
                let law = 2.0 * tension * parameters.joints.radius * o.ring_speed * curvatures;
                // Tension is not uniform, and the drag is that of the arcs of the reference curve.
                assert_close(o.losses.joints, law, 0.02, "loss of the joints");
            }
        }
    }
}

/// Five times the bending stiffness and a quarter of the elements' length change the thrust ratio
/// little.
#[test]
fn bending_is_negligible_and_the_mesh_fine_enough() {
    for (model, ratios, change, allowed) in [
        (
            RingModel::Ale,
            [1.67, 0.625],
            (|p| p.ring.bending_stiffness *= 5.0) as fn(&mut Parameters),
            5e-3,
        ),
        (RingModel::Ale, [2.2, 0.5], |p| p.mesh = p.mesh.refined(2), 3e-3),
        (RingModel::Ale0, [2.2, 0.5], |p| p.mesh = p.mesh.refined(2), 1e-2),
    ] {
        for ratio in ratios {
            let parameters = chain(model);
            let mut changed = parameters.clone();
            change(&mut changed);
            let [usual, changed] =
                [&parameters, &changed].map(|p| driven(p, ratio, 50.0, SPEED).outputs.thrust_ratio);
            assert_close(usual, changed, allowed, "thrust ratio");
        }
    }
}

/// Launch, shift, torque reversal, over-torque and recovery: energy is balanced, and the chain
/// keeps its tension.
#[test]
fn energy_balance_of_the_manoeuvre() {
    for model in MODELS {
        let manoeuvre = Manoeuvre::read();
        let mut run = Run::new(Manoeuvre::variator(chain(model)), manoeuvre.at(0.0));
        let step = 2e-3;
        for (k, inputs) in manoeuvre.trace(step).into_iter().enumerate() {
            run.inputs = inputs;
            let o = run.go(step, step);
            assert!(o.ring_tension_min > 0.0, "{model:?} at step {k}");
        }
        run.assert_balances();
        let o = run.outputs();
        assert!(!o.macro_slip && o.slip < 0.02, "{}", o.slip);
    }
}
