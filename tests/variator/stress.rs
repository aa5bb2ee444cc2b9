//! Stress in the layers of the ring, from the fields of the variator.

use pushbelt::pulley::Pulley;
use pushbelt::variator::settings::{Outputs, PROFILE_POINTS, Parameters, RingModel};
use pushbelt_support::checks::assert_close;
use pushbelt_support::run::Run;
use pushbelt_support::steady::transmitting;
use pushbelt_support::variators::{MODELS, SPEED, coarse, inputs, variator};

/// Area of all layers of both sets, m², and ½ E t, N/m.
fn section(parameters: &Parameters) -> [f64; 2] {
    let layers = &parameters.layers;
    let area = 2.0 * f64::from(layers.count) * layers.width * layers.thickness;
    [area, 0.5 * parameters.ring.axial_stiffness / area * layers.thickness]
}

/// At full load the largest stress is on the smaller pulley: tension over area and E t/2 times the
/// curvature there less the residual one. Its cycle there has half the bending stress as its
/// amplitude. Both but for the tension's change around the loop, which the layers do not share
/// alike; friction on elements and between layers is low, so it is small.
#[test]
fn stress_at_full_load_is_tension_and_bending_on_the_smaller_pulley() {
    for model in MODELS {
        let mut parameters = variator(model);
        (parameters.friction.ring, parameters.layers.friction) = (0.01, 0.01);
        let [area, bending] = section(&parameters);
        for (ratio, torque, force) in [(2.3, 150.0, 30e3), (0.43, 150.0, 30e3), (0.43, 100.0, 10e3)] {
            let o = transmitting(&parameters, ratio, force, torque, SPEED).outputs;
            let stress = &o.ring_stress;
            let (small, large) = if ratio > 1.0 {
                (Pulley::Primary, Pulley::Secondary)
            } else {
                (Pulley::Secondary, Pulley::Primary)
            };
            let radius = o.primary.radius.min(o.secondary.radius) + parameters.belt.pitch_offset;
            let (of_bending, residual) = (bending / radius, bending * parameters.layers.residual_curvature);
            let [low, high] = [o.ring_tension_min, o.ring_tension_max].map(|tension| tension / area);
            assert_close(stress.max, high + of_bending - residual, 0.04, "largest stress");
            // The tension changes along the arc too.
            let of_tension = 0.5 * (high - low);
            assert!((stress.amplitude[small] - 0.5 * of_bending).abs() < 0.02 * of_bending + of_tension);
            let upper = stress.amplitude[small] + stress.mean[small];
            assert_close(upper, stress.max, 1e-9, "upper end of the cycle");
            assert!(stress.amplitude[large] < 0.6 * stress.amplitude[small]);
        }
    }
}

/// Both rings have the same stress: `ALE0` on the curvature of its reference curve, `ALE` on that
/// of the deflected ring.
#[test]
fn both_rings_have_the_same_stress() {
    for (ratio, torque, force) in [(2.3, 100.0, 20e3), (1.0, 100.0, 15e3), (0.5, 100.0, 15e3)] {
        let outputs = |model| transmitting(&variator(model), ratio, force, torque, SPEED).outputs;
        let [ale0, ale] = MODELS.map(|model| outputs(model).ring_stress);
        assert_close(ale.max, ale0.max, 0.03, "largest stress");
        for pulley in Pulley::BOTH {
            assert_close(ale.amplitude[pulley], ale0.amplitude[pulley], 0.06, "amplitude");
            assert!((ale.mean[pulley] - ale0.mean[pulley]).abs() < 0.06 * ale0.max);
        }
    }
}

/// The residual curvature shifts stresses of bending and moves nothing.
#[test]
fn residual_curvature_shifts_the_mean_only() {
    let run = |curvature: f64| {
        let mut parameters = coarse(RingModel::Ale);
        parameters.initial.ratio = 0.6;
        parameters.layers.residual_curvature = curvature;
        Run::new(parameters, inputs((50.0, 16e3), (-27.0, 10e3))).go(0.02, 1e-3)
    };
    let (straight, bent) = (run(0.0), run(5.0));
    let [_, bending] = section(&variator(RingModel::Ale));
    let (a, b) = (&straight.ring_stress, &bent.ring_stress);
    assert_close(a.max - b.max, 5.0 * bending, 1e-9, "shift of the largest stress");
    for pulley in Pulley::BOTH {
        assert_close(a.amplitude[pulley], b.amplitude[pulley], 1e-9, "amplitude");
        assert_close(a.mean[pulley] - b.mean[pulley], 5.0 * bending, 1e-9, "mean");
    }
    let still = |o: &Outputs| Outputs {
        ring_stress: Default::default(),
        ..o.clone()
    };
    assert_eq!(still(&straight), still(&bent));
}

/// The field along the belt is that of the face whose cycles are the outputs. It has a point every
/// 10 mm.
#[test]
fn the_field_has_the_cycles_of_the_outputs() {
    let mut parameters = variator(RingModel::Ale);
    parameters.initial.ratio = 0.5;
    let mut run = Run::new(parameters, inputs((50.0, 20e3), (-24.0, 11e3)));
    let o = run.go(0.02, 1e-3);
    let profile = run.variator.profile();
    assert!(profile.radial_deviation.iter().all(|off| off.abs() < 2e-3));
    let field = profile.ring_stress;
    let (low, high) = field.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), stress| {
        (low.min(*stress), high.max(*stress))
    });
    let stress = &o.ring_stress;
    assert_close(high, stress.max, 0.03, "largest stress");
    let valley = stress.mean.secondary - stress.amplitude.secondary;
    assert_close(low, valley, 0.03, "smallest stress");
    // The primary arc is the middle of the loop.
    let peak = stress.mean.primary + stress.amplitude.primary;
    let on_primary = field[PROFILE_POINTS / 3..=2 * PROFILE_POINTS / 3].iter();
    let highest = on_primary.fold(0.0, |high: f64, stress| high.max(*stress));
    assert_close(highest, peak, 0.05, "stress on the primary arc");
}
