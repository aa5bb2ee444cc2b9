//! The pull chain: its derivatives, limit cases, losses, symmetry, runs.

use std::sync::Arc;

use pushbelt::pulley::Pulley;
use pushbelt::reference_curve::TwoPulley;
use pushbelt::variator::belt_ring::{Ale, Ale0, BeltRing, deflecting_equations, guided_equations};
use pushbelt::variator::linear::linearise;
use pushbelt::variator::pulleys::loads::ShaftMode;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{BeltKind, Inputs, Mode, Outputs, Parameters, RingModel};
use pushbelt::variator::steady::solve::SteadyTask;
use pushbelt_support::checks::assert_close;
use pushbelt_support::disturbed::{
    Equations, assert_derivatives_by_hand, assert_jacobian, assert_update_of_slopes, disturbed, small,
};
use pushbelt_support::load_cases::{given, pair, speeds};
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::run::Run;
use pushbelt_support::steady::{Steady, steady};
use pushbelt_support::variators::{MODELS, SPEED, belt_alone, chain, full_slip_torque, inputs, rigid};

/// Clamping force on the secondary pulley, N.
const FORCE: f64 = 11e3;

fn small_chain(model: RingModel) -> Parameters {
    Parameters {
        kind: BeltKind::PullChain,
        ..small(model)
    }
}

fn in_space() -> Parameters {
    Parameters {
        spatial: true,
        ..small_chain(RingModel::Ale)
    }
}

/// The steady state at a ratio with a torque on the primary shaft, N·m; the secondary shaft turns at `speed`/ratio.
fn driven(parameters: &Parameters, ratio: f64, torque: f64, speed: f64) -> Steady {
    let task = SteadyTask {
        shaft: pair(ShaftMode::Fixed, ShaftMode::Torque(torque)),
        ..given(ratio, Pulley::Primary, FORCE, 0.01)
    };
    steady(parameters, &task, speeds(ratio, speed))
}

#[test]
fn hand_written_derivatives_are_those_of_forward_differentiation() {
    let of = |parameters: Parameters, ring: Arc<dyn BeltRing>, equations: Equations| {
        assert_derivatives_by_hand(&parameters, &ring, equations);
        assert_update_of_slopes(&parameters, &ring);
    };
    let planar = deflecting_equations::<2, TwoPulley>;
    of(small_chain(RingModel::Ale), Arc::new(Ale::<2>), planar);
    let spatial = deflecting_equations::<3, TwoPulley>;
    of(in_space(), Arc::new(Ale::<3>), spatial);
    let guided = guided_equations::<TwoPulley>;
    of(small_chain(RingModel::Ale0), Arc::new(Ale0), guided);
}

#[test]
fn jacobian_is_that_of_differences() {
    for parameters in [small_chain(RingModel::Ale), small_chain(RingModel::Ale0), in_space()] {
        for speed in [200.0, -200.0] {
            assert_jacobian(disturbed(&parameters, speed), 1e-2);
        }
    }
}

/// What a chain has not reads 0, its pins move with it, and power and moments balance.
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
            }
        }
    }
}

/// Σ T r_j |v|/R over the four borders of the arcs.
#[test]
fn loss_of_the_joints_is_that_of_their_law() {
    for model in MODELS {
        for ratio in [2.2, 0.5] {
            let parameters = chain(model);
            let state = driven(&parameters, ratio, 0.0, SPEED);
            let o = &state.outputs;
            let tension = 0.5 * (o.ring_tension_max + o.ring_tension_min);
            let curvatures = 1.0 / o.primary.radius + 1.0 / o.secondary.radius;
            let law = 2.0 * tension * parameters.joints.radius * o.ring_speed * curvatures;
            // Tension is not uniform, and the drag is that of the arcs of the reference curve.
            assert_close(o.losses.joints, law, 0.02, "loss of the joints");
            let mut twice = parameters.clone();
            twice.joints.radius *= 2.0;
            let doubled = driven(&twice, ratio, 0.0, SPEED).outputs.losses.joints;
            assert_close(
                doubled,
                2.0 * o.losses.joints,
                0.02,
                "loss of joints with twice the radius",
            );
        }
    }
}

/// Without friction F_P/F_S = α_P/α_S, in the limit of stiff contact on a fine mesh.
#[test]
fn without_friction_the_thrust_ratio_is_that_of_the_wrap_angles() {
    for model in MODELS {
        for ratio in [0.45, 1.0, 2.2] {
            let mut parameters = belt_alone(rigid(chain(model)));
            parameters.friction.pulley = 1e-9;
            parameters.contact.stiffness = 4e10;
            parameters.ring.bending_stiffness = 1e-3;
            parameters.mesh = parameters.mesh.refined(2);
            let task = given(ratio, Pulley::Primary, 10.0e3, 0.0);
            let state = steady(&parameters, &task, speeds(ratio, SPEED));
            let wrap = state.wrap();
            let off = state.outputs.thrust_ratio * wrap.secondary / wrap.primary - 1.0;
            assert!(off.abs() < 3e-4, "{off}");
        }
    }
}

#[test]
fn a_pulley_that_slips_all_around_transmits_its_capacity() {
    for model in MODELS {
        for slip in [0.5, -0.5] {
            let parameters = belt_alone(chain(model));
            let slipping = pair(SPEED / 2.0 * (1.0 - slip), SPEED);
            let o = steady(&parameters, &given(2.0, Pulley::Primary, 10.0e3, 0.0), slipping).outputs;
            let law = -slip.signum() * full_slip_torque(&parameters, &o.primary);
            assert_close(o.primary.shaft_torque, law, 2e-3, "torque at full slip");
        }
    }
}

#[test]
fn reverse_running_mirrors_the_steady_state() {
    for model in MODELS {
        let of = |sign: f64| driven(&chain(model), 1.6, sign * 40.0, sign * SPEED).outputs;
        let (forward, reverse) = (of(1.0), of(-1.0));
        for (a, b, what) in [
            (reverse.thrust_ratio, forward.thrust_ratio, "thrust ratio"),
            (reverse.primary.speed, -forward.primary.speed, "primary speed"),
            (reverse.belt_speed, -forward.belt_speed, "belt speed"),
            (reverse.ring_tension_max, forward.ring_tension_max, "tension"),
            (reverse.losses.joints, forward.losses.joints, "loss of the joints"),
            (reverse.losses.total(), forward.losses.total(), "losses"),
        ] {
            assert_close(a, b, 1e-6, what);
        }
    }
}

/// Five times the bending stiffness changes the thrust ratio by less than 0.5 %.
#[test]
fn bending_is_negligible() {
    for ratio in [1.67, 1.0, 0.625] {
        let parameters = chain(RingModel::Ale);
        let mut stiffer = parameters.clone();
        stiffer.ring.bending_stiffness *= 5.0;
        let of = |parameters| driven(parameters, ratio, 50.0, SPEED).outputs.thrust_ratio;
        let (one, five) = (of(&parameters), of(&stiffer));
        assert_close(five, one, 5e-3, "thrust ratio with five times the bending stiffness");
    }
}

/// A quarter of the elements' length.
#[test]
fn the_mesh_is_fine_enough() {
    for (model, allowed) in [(RingModel::Ale, 3e-3), (RingModel::Ale0, 1e-2)] {
        for ratio in [2.2, 0.5] {
            let parameters = chain(model);
            let mut fine = parameters.clone();
            fine.mesh = fine.mesh.refined(2);
            let of = |parameters| driven(parameters, ratio, 50.0, SPEED).outputs.thrust_ratio;
            assert_close(
                of(&parameters),
                of(&fine),
                allowed,
                "thrust ratio on a mesh twice as fine",
            );
        }
    }
}

/// Launch, shift, torque reversal, over-torque and recovery: energy is balanced, and the chain keeps its tension.
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
        let o = run.variator.outputs().clone();
        assert!(!o.macro_slip && o.slip < 0.02, "{}", o.slip);
    }
}

/// A chain at rest under clamping forces holds a torque, and its energy is balanced.
#[test]
fn a_standstill_holds_the_torque() {
    for model in MODELS {
        let mut parameters = chain(model);
        parameters.initial.primary_speed = 0.0;
        let mut run = Run::new(parameters, inputs((20.0, 11e3), (-20.0, 11e3)));
        let o = run.go(0.2, 2e-3);
        run.assert_balances();
        assert!(o.primary.speed.abs() < 0.5, "{model:?}: {} rad/s", o.primary.speed);
        assert!(o.ring_tension_min > 0.0);
    }
}

/// A torque jumps while the clamping forces fall, at a low speed and without damping of the chain: a strand loses its tension for a
/// moment.
#[test]
fn a_slack_strand_gives_a_warning() {
    let mut parameters = chain(RingModel::Ale);
    parameters.initial.primary_speed = 20.0;
    parameters.solver.input_ramp = 0.0;
    parameters.ring.damping = 0.0;
    let mut run = Run::new(parameters, inputs((40.0, 11e3), (-39.0, 9e3)));
    run.go(5e-3, 1e-3);
    assert!(!run.warned("slack"), "{:?}", run.messages);
    run.inputs = inputs((-150.0, 100.0), (150.0, 100.0));
    run.go(0.03, 1e-3);
    assert!(run.warned("a real chain would be slack"), "{:?}", run.messages);
}

#[test]
fn snapshots_repeat_bit_for_bit() {
    for (model, mode) in [
        (RingModel::Ale, Mode::Accurate),
        (RingModel::Ale0, Mode::Accurate),
        (RingModel::Ale, Mode::RealTime),
    ] {
        let mut parameters = chain(model);
        parameters.solver.mode = mode;
        let mut one = Run::new(parameters, inputs((40.0, 12e3), (-39.0, 10e3)));
        one.go(0.02, 1e-3);
        let mut snapshot = one.clone();
        for run in [&mut one, &mut snapshot] {
            run.go(0.02, 1e-3);
        }
        assert_eq!(one.variator.state(), snapshot.variator.state());
        assert_eq!(one.variator.outputs(), snapshot.variator.outputs());
    }
}

/// Real time follows the accurate run.
#[test]
fn real_time_follows_the_accurate_run() {
    for model in MODELS {
        let of = |mode: Mode| {
            let mut parameters = chain(model);
            parameters.solver.mode = mode;
            let mut run = Run::new(parameters, inputs((40.0, 11e3), (-40.0, 10e3)));
            run.inputs.primary.clamping_force = 13e3;
            run.inputs.primary.torque = 55.0;
            run.go(0.3, 1e-3)
        };
        let (accurate, bounded) = (of(Mode::Accurate), of(Mode::RealTime));
        for (a, b, what) in [
            (bounded.thrust_ratio, accurate.thrust_ratio, "thrust ratio"),
            (bounded.ratio_geometric, accurate.ratio_geometric, "ratio"),
            (bounded.primary.speed, accurate.primary.speed, "primary speed"),
            (bounded.slip, accurate.slip, "slip"),
        ] {
            assert_close(a, b, 0.02, what);
        }
    }
}

/// The linear model is stable but for the slow modes of speed and ratio, and has the gain of a run.
#[test]
fn the_linear_model_follows_a_small_step() {
    for model in MODELS {
        let mut parameters = chain(model);
        parameters.solver.tolerance = 1e-7;
        let start = inputs((20.0, 11e3), (-19.0, 11e3));
        let ratio = |o: &Outputs| o.ratio_geometric;
        let read: [&dyn Fn(&Outputs) -> f64; 1] = [&ratio];
        let linear = linearise(&parameters, &start, 100.0, &read).expect("a steady state");
        assert!(linear.a.len() < 40, "{} states up to 100 Hz", linear.a.len());
        let mut variator = Variator::new(parameters).expect("valid parameters");
        variator.initialise(0.0, &start).expect("a start");
        let load = linear
            .loads
            .iter()
            .position(|load| format!("{load:?}").contains("ClampingForce(Primary)"))
            .expect("a clamping force");
        let step = 20.0;
        let mut after = start;
        after.primary.clamping_force = variator.outputs().primary.axial_force + step;
        let mut before = start;
        before.primary.clamping_force = variator.outputs().primary.axial_force;
        let mut still = variator.clone();
        let time = 0.05;
        let mut change = 0.0;
        for (run, inputs, sign) in [(&mut still, &before, -1.0), (&mut variator, &after, 1.0)] {
            for k in 1..=50 {
                run.advance(f64::from(k) * 1e-3, inputs).expect("a step");
            }
            change += sign * run.outputs().ratio_geometric;
        }
        let predicted = response(&linear.a, linear.b.iter().map(|row| row[load]), &linear.c[0], time) * step;
        assert_close(change, predicted, 0.1, "ratio after a small step");
    }
}

/// c ∫ e^{At} b dt over a time, by small steps of the trapezoidal rule.
fn response(a: &[Vec<f64>], b: impl Iterator<Item = f64>, c: &[f64], time: f64) -> f64 {
    let n = a.len();
    let mut whole = nalgebra::DMatrix::<f64>::zeros(n + 1, n + 1);
    for (i, b) in b.enumerate() {
        for j in 0..n {
            whole[(i, j)] = a[i][j] * time;
        }
        whole[(i, n)] = b * time;
    }
    let flow = whole.exp();
    (0..n).map(|k| c[k] * flow[(k, n)]).sum()
}

/// A pushbelt's parameters with `belt.kind` = 2 run, too.
#[test]
fn parameters_of_a_pushbelt_run_as_a_chain() {
    let parameters = Parameters {
        kind: BeltKind::PullChain,
        ..Parameters::default()
    };
    let mut run = Run::new(parameters, Inputs::default());
    run.go(0.05, 1e-3);
    run.assert_balances();
}
