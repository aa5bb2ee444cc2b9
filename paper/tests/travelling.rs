//! Travelling rings in the variator: start from the steady state of ALE, results close to it,
//! energy balance, and continuation from a stored state bit for bit.

use std::sync::Arc;

use pushbelt::archive::Archive;
use pushbelt::variator::linear::{LinearError, linearise_at};
use pushbelt::variator::ring_models::{Ale, BeltRing};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Axial, Drive, Inputs, Mode, Parameters, RingModel};
use pushbelt_paper_lab::{ancf, rcm, travelling};
use pushbelt_support::checks::{assert_close, assert_pinned};
use pushbelt_support::load_cases::{LoadCase, ratio};
use pushbelt_support::run::Run;
use pushbelt_support::variators::{SPEED, inputs, variator};

/// The paper's test rig (5.4): the primary sheave held, its speed given, torque and force on the
/// secondary pulley.
fn rig(ring: Arc<dyn BeltRing>, theta: f64, torque: f64) -> Run {
    let mut parameters = variator(RingModel::Ale);
    parameters.primary.drive = Drive::Speed;
    parameters.primary.axial = Axial::Held;
    parameters.initial.ratio = ratio(theta);
    let case = LoadCase::new(&parameters, "", theta, torque);
    let load = -0.97 * torque * ratio(theta);
    Run::with_ring(parameters, ring, inputs((0.0, case.clamping), (load, case.clamping)))
}

/// Means of thrust ratio and of the ring tension's range over the last part of a run.
fn means(run: &mut Run, settle: f64, span: f64) -> [f64; 3] {
    run.go(settle, 5e-4);
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    run.watch(span, 2e-4, |_, o| {
        for (sum, x) in sums
            .iter_mut()
            .zip([o.thrust_ratio, o.ring_tension_min, o.ring_tension_max])
        {
            *sum += x;
        }
        count += 1.0;
    });
    sums.map(|sum| sum / count)
}

/// In under-, medium and overdrive, over two passes of an element: the thrust ratio is that of ALE
/// within the error of the elements' shape, and so is the tension of the co-rotational ring; the
/// balances of energy and elements hold.
#[test]
fn three_ratios_near_ale() {
    for theta in [-0.4, 0.0, 0.4] {
        let mut ale = rig(Arc::new(Ale::<2>), theta, 50.0);
        let [thrust, lowest, highest] = means(&mut ale, 5e-4, 1e-3);
        for (ring, bound) in [(rcm(), RCM_THRUST), (ancf(), ANCF_THRUST)] {
            let name = ring.name();
            let mut run = rig(ring, theta, 50.0);
            let [found, low, high] = means(&mut run, 2e-3, 2e-3);
            println!(
                "{name} at Θ = {theta}: thrust ratio {found:.4} against {thrust:.4}, tension {low:.0} to {high:.0} N against \
                 {lowest:.0} to {highest:.0} N, residual {:.3} of what is allowed, {:?}",
                run.residual,
                run.variator.counts()
            );
            assert!((found / thrust - 1.0).abs() < bound);
            if name == "RCM" {
                // Measured: 0.4 and 0.4, 0.1 and 0.8, 3.1 and 3.7 %.
                let bound = if theta > 0.0 { 0.05 } else { 0.015 };
                assert_close(low, lowest, bound, "lowest tension");
                assert_close(high, highest, bound, "highest tension");
            }
            run.assert_balances();
        }
    }
}

/// The tension of the co-rotational ring is uniform along an element, and close to ALE's mean:
/// +0.4, −1.1, −2.9 %. ANCF's membrane locks where the curvature jumps inside an element, so its
/// tension varies by more than its mean (the paper's 5.4: it reacts very stiff): +5, −3, −13 %.
const RCM_THRUST: f64 = 0.05;
const ANCF_THRUST: f64 = 0.15;

/// Start from standstill on the clamped ring of `ALE`; torques act at once. The initial stretch of
/// the elements relaxes in microseconds. The oil between the push elements dissipates part of it so
/// fast that the energy balance requires shorter steps.
#[test]
fn a_run_may_start_at_a_standstill() {
    for ring in travelling() {
        let name = ring.name();
        let mut parameters = variator(RingModel::Ale);
        parameters.initial.primary_speed = 0.0;
        parameters.solver.tolerance = 1e-5;
        let mut run = Run::with_ring(parameters, ring, inputs((20.0, 8e3), (-10.0, 8e3)));
        let o = run.go(6e-3, 1e-3);
        println!("{name}: residual {:.2} of what is allowed", run.residual);
        assert!(o.primary.speed > 0.5 && o.ring_speed > 0.0, "{}", o.primary.speed);
        run.assert_balances();
    }
}

fn stored(variator: &mut Variator) -> Vec<u8> {
    let mut archive = Archive::writer();
    variator.serialize(&mut archive);
    archive.into_bytes()
}

/// A run continues from a stored state bit for bit, although the order of the unknowns in stored
/// factors is that of an earlier drift.
#[test]
fn runs_continue_from_stored_states_bit_for_bit() {
    for ring in travelling() {
        let mut run = rig(Arc::clone(&ring), 0.0, 50.0);
        run.go(1e-3, 2.5e-4);
        let bytes = stored(&mut run.variator);
        let mut other =
            Variator::with_ring(run.variator.parameters().clone(), ring).expect("valid parameters");
        let mut archive = Archive::reader(&bytes);
        other.serialize(&mut archive);
        archive.finish().expect("it fits");
        for to in [1.25e-3, 1.5e-3] {
            run.variator.advance(to, &run.inputs).expect("a step");
            other.advance(to, &run.inputs).expect("a step");
        }
        assert_eq!(run.variator.state(), other.state());
        assert_eq!(run.variator.outputs(), other.outputs());
        assert_eq!(stored(&mut run.variator), stored(&mut other));
    }
}

/// The reference curve follows the ring: s moves with the belt, Θ and the multipliers stay small.
#[test]
fn the_mesh_follows_the_ring() {
    for ring in travelling() {
        let mut run = rig(ring, 0.0, 50.0);
        let layout = run.variator.system().belt.layout;
        let before = run.variator.state().q[layout.theta()];
        let o = run.go(3e-3, 1e-3);
        let [drift, theta] = [layout.drift(), layout.theta()].map(|at| run.variator.state().q[at]);
        let distance = o.belt_speed * 3e-3;
        assert!((drift / distance - 1.0).abs() < 0.05, "{drift} {distance}");
        assert!((theta - before).abs() < 1e-3);
    }
}

/// A travelling ring has no steady state for a linear model.
#[test]
fn there_is_no_linear_model() {
    for ring in travelling() {
        let mut variator = Variator::with_ring(Parameters::default(), ring).expect("valid parameters");
        let refused = linearise_at(&mut variator, &Inputs::default(), 10.0, &[]);
        assert!(matches!(refused, Err(LinearError::Unsteady(_))));
    }
}

/// Work per millisecond, so that a slower solver is detected without a clock.
#[test]
fn work_per_millisecond_is_bounded() {
    for (ring, steps, residuals, factorizations) in [(rcm(), 99, 706, 22), (ancf(), 129, 1400, 69)] {
        let name = ring.name();
        let mut run = rig(ring, 0.0, 50.0);
        assert!((run.variator.outputs().primary.speed / SPEED - 1.0).abs() < 1e-9);
        run.go(1e-3, 1e-3);
        let counts = run.variator.counts();
        println!("{name}: {counts:?}");
        assert_pinned(counts.steps, steps, "steps");
        assert_pinned(counts.residuals, residuals, "residuals");
        assert_pinned(counts.factorizations, factorizations, "factorizations");
    }
}

/// The energy balance of a shift in overdrive with all losses.
#[test]
fn energy_balance_with_all_losses() {
    let span = 0.02;
    let mut parameters = variator(RingModel::Ale);
    parameters.initial.ratio = 0.6;
    let mut run = Run::with_ring(parameters, rcm(), inputs((20.0, 12e3), (-11.0, 10e3)));
    run.go(0.25 * span, 1e-3);
    run.inputs.primary.clamping_force = 16e3;
    let o = run.go(0.75 * span, 1e-3);
    println!(
        "{:.2} of what is allowed; layers {:.1} W, shafts {:.1} W",
        run.residual, o.losses.layers, o.losses.shafts
    );
    assert!(o.losses.layers > 1.0 && o.losses.shafts > 50.0);
    run.assert_balances();
}

#[test]
fn real_time_is_refused() {
    for ring in travelling() {
        let mut parameters = Parameters::default();
        parameters.solver.mode = Mode::RealTime;
        let error = Variator::with_ring(parameters, ring).expect_err("refused");
        assert!(
            error.to_string().starts_with("solver.mode = 2 is out of range"),
            "{error}"
        );
    }
}
