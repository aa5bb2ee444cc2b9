//! The overlay in directions that rotate with the reference curve, A_i = [t, n, b]_ref in (10): the
//! same belt in other coordinates.

use std::sync::Arc;

use pushbelt::variator::ring_models::{Ale, Ale0, BeltRing};
use pushbelt::variator::settings::{Drive, Parameters, RingModel};
use pushbelt_paper::belts::{Forward, Rotated};
use pushbelt_paper::unit::PaperRings;
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::run::Run;
use pushbelt_support::steady::load_case_with;
use pushbelt_support::variators::{inputs, variator};

/// Fixed directions and those of the curve, in the plane.
fn plane() -> [Arc<dyn BeltRing>; 2] {
    [Arc::new(Ale::<2>), Arc::new(Rotated::<2>)]
}

/// The same in space.
fn space() -> [Arc<dyn BeltRing>; 2] {
    [Arc::new(Ale::<3>), Arc::new(Rotated::<3>)]
}

/// Derivatives by forward differentiation: the same belt, to the tolerance of the steady solution.
#[test]
fn forward_differentiation_has_the_same_steady_states() {
    let pairs: [[Arc<dyn BeltRing>; 2]; 2] = [
        [Arc::new(Ale::<2>), Arc::new(Forward(Ale::<2>))],
        [Arc::new(Ale0), Arc::new(Forward(Ale0))],
    ];
    for (pair, model) in pairs.into_iter().zip([RingModel::Ale, RingModel::Ale0]) {
        let parameters = variator(model);
        for case in LoadCase::three(&parameters, 50.0) {
            let [hand, forward] = pair.clone().map(|ring| load_case_with(&parameters, ring, &case));
            let off = forward.outputs.thrust_ratio / hand.outputs.thrust_ratio - 1.0;
            assert!(off.abs() < 1e-6, "{model:?}, {}: {off}", case.name);
        }
    }
}

/// The two choices interpolate differently between nodes. Their difference is that of the
/// discretisation, and smaller on a finer mesh.
#[test]
fn both_choices_have_the_same_steady_states() {
    let parameters = variator(RingModel::Ale);
    for case in LoadCase::three(&parameters, 50.0) {
        let off = [1, 2].map(|refinement| {
            let mut fixed = parameters.clone();
            fixed.mesh = fixed.mesh.refined(refinement);
            let [fixed, turning] = plane().map(|ring| load_case_with(&fixed, ring, &case));
            let (f, t) = (&fixed.outputs, &turning.outputs);
            let off = |of: fn(&pushbelt::variator::settings::Outputs) -> f64| of(t) / of(f) - 1.0;
            let off = [off(|o| o.thrust_ratio), off(|o| o.ring_tension_max), off(|o| o.efficiency)];
            println!(
                "{}, {refinement} times: thrust ratio {:+.2e}, largest tension {:+.2e}, efficiency {:+.2e} off; power defect {:.1e}; {} instead of \
                 {} factorizations",
                case.name,
                off[0],
                off[1],
                off[2],
                turning.power_defect(),
                turning.counts.factorizations,
                fixed.counts.factorizations
            );
            assert!(turning.power_defect().abs() < 3e-4);
            off
        });
        for (found, allowed) in off.iter().zip([[2e-3, 1e-2, 2e-4], [1e-3, 3e-3, 5e-5]]) {
            for (off, allowed) in found.iter().zip(allowed) {
                assert!(off.abs() < allowed, "{}: {off} of {allowed}", case.name);
            }
        }
    }
}

/// In space the third direction is the same.
#[test]
fn misaligned_pulleys_load_both_choices_equally() {
    let mut parameters = Parameters {
        spatial: true,
        ..variator(RingModel::Ale)
    };
    parameters.geometry.pulley_offset = 5e-4;
    let case = LoadCase::new(&parameters, "medium", 0.0, 50.0);
    let [f, t] = space().map(|ring| load_case_with(&parameters, ring, &case).outputs);
    assert!(f.lateral_max > 1e-4);
    for (of, allowed) in [
        ((f.lateral_max, t.lateral_max), 1e-3),
        ((f.skew, t.skew), 1e-3),
        ((f.thrust_ratio, t.thrust_ratio), 3e-3),
    ] {
        let (fixed, turning) = of;
        assert!((turning / fixed - 1.0).abs() < allowed, "{turning} {fixed}");
    }
}

/// In a shift the directions rotate. The balances of energy and elements hold as in fixed
/// directions.
#[test]
fn energy_balance_of_a_shift() {
    let [fixed, turned] = plane().map(|ring| {
        let mut parameters = variator(RingModel::Ale);
        parameters.primary.drive = Drive::Speed;
        let name = format!("{ring:?}");
        let mut run = Run::with_ring(parameters, ring, inputs((0.0, 13e3), (-49.0, 10e3)));
        run.inputs.primary.clamping_force = 1.2 * run.variator.outputs().primary.axial_force;
        let mut residual = 0.0_f64;
        run.watch(0.1, 1e-3, |_, o| residual = residual.max(o.energy_residual.abs()));
        run.assert_balances();
        let outputs = run.variator.outputs().clone();
        println!(
            "{name}: ratio {:.5}, {residual:.2} J, {:?}",
            outputs.ratio_geometric,
            run.variator.counts()
        );
        outputs
    });
    assert!(fixed.ratio_geometric < 0.98);
    assert!((turned.ratio_geometric / fixed.ratio_geometric - 1.0).abs() < 1e-3);
    assert!((turned.thrust_ratio / fixed.thrust_ratio - 1.0).abs() < 5e-3);
}

/// The option requires a ring that deflects, on the aligned mesh.
#[test]
fn directions_require_a_deflecting_ring_on_the_aligned_mesh() {
    let turning = PaperRings {
        reference_directions: true,
        ..PaperRings::default()
    };
    turning.check().expect("ALE on its own mesh");
    let of_model = |model| PaperRings { model, ..turning };
    let even = PaperRings {
        aligned: false,
        ..turning
    };
    for refused in [even, of_model(RingModel::Ale0 as i32), of_model(3)] {
        let error = refused.check().expect_err("no such ring");
        assert_eq!(error.variable, "ring.referenceDirections");
    }
}
