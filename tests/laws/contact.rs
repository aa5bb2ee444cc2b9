//! Flank contact.

use crate::{assert_near, slope};
use pushbelt::contact::{FlankForce, FlankMotion, energy_density, flank_force};
use pushbelt::scalar::{Dual, Real, Tangent};
use pushbelt_support::laws::{contact, cos_beta, friction};
use pushbelt_support::noise;

const MICRON: f64 = 1e-6;

/// g, Dg/Dt, v_t and v_f as a motion.
fn motion<T>([penetration, penetration_rate, tangential, along_flank]: [T; 4]) -> FlankMotion<T> {
    FlankMotion {
        penetration,
        penetration_rate,
        tangential,
        along_flank,
    }
}

fn force<T: Real>(x: [T; 4]) -> FlankForce<T> {
    flank_force(&contact(), &friction(), cos_beta(), &motion(x))
}

fn figures<T: Real>(x: [T; 4]) -> [T; 4] {
    let force = force(x);
    [force.normal, force.viscous, force.tangential, force.along_flank]
}

/// Derivatives with respect to g, Dg/Dt, v_t and v_f against differences. Each
/// difference has an error of at most 1e-6 of the force's change over the width of the law's
/// transition.
fn assert_derivatives(x: [f64; 4]) {
    let widths = [contact().roughness, 1.0, friction().velocity, friction().velocity];
    let tangents = figures(std::array::from_fn(|i| Tangent::<4, f64>::seed(x[i], i, 1.0)));
    for (i, width) in widths.into_iter().enumerate() {
        for (k, exact) in tangents.into_iter().enumerate() {
            let (what, slope_there) = (format!("∂f{k}/∂x{i} at {x:?}"), exact.eps[i]);
            let scale = slope_there
                .abs()
                .max(exact.re.abs() / width)
                .max(1e-10 * contact().stiffness);
            let moved = |h: f64| {
                let mut x = x;
                x[i] += h;
                figures(x)[k]
            };
            assert_near(slope(moved, 1e-2 * width), slope_there, scale, 1e-6, &what);
        }
    }
}

/// In stiction, sliding around and along the flank, at breaking contact, without contact and in
/// deep contact.
#[test]
fn derivatives_in_each_regime() {
    let (v0, roughness) = (friction().velocity, contact().roughness);
    let regimes = [
        [20.0 * MICRON, 1e-3, 1e-2 * v0, -2e-2 * v0],
        [20.0 * MICRON, 1e-3, 30.0 * v0, 0.0],
        [20.0 * MICRON, 1e-3, 0.0, -30.0 * v0],
        [-roughness, -0.2, v0, v0],
        [0.0, -0.2, v0, v0],
        [roughness, -0.2, v0, v0],
        [-30.0 * MICRON, -0.1, 1e-2, 0.0],
        [500.0 * MICRON, 1e-2, 3.0 * v0, v0],
    ];
    regimes.into_iter().for_each(assert_derivatives);
}

/// The axial part p cos β of the normal force, at rest.
fn axial(penetration: f64) -> f64 {
    force([penetration, 0.0, 0.0, 0.0]).normal * cos_beta()
}

/// The axial force of the flank on its sheave is −∂E/∂g, E by differentiation: in contact, at first
/// touch and in a gap.
#[test]
fn normal_force_is_the_derivative_of_the_energy() {
    for penetration in [20.0, 500.0, 0.0, -20.0].map(|g| g * MICRON) {
        let g = Dual::seed(penetration, 0, 1.0);
        let depth = g.soft_plus(contact().roughness).value;
        let energy = energy_density(&contact(), cos_beta(), g, depth);
        let found = axial(penetration);
        assert_near(energy.eps[0], found, found, 1e-12, "∂E/∂g");
    }
}

/// Power of friction per flank and pitch-line length, W/m.
fn friction_power(x: [f64; 4]) -> f64 {
    let force = force(x);
    force.tangential * x[2] + force.along_flank * x[3]
}

/// μ p_el, N/m.
fn cone(penetration: f64) -> f64 {
    friction().pulley * force([penetration, 0.0, 0.0, 0.0]).normal
}

/// −μ p v²/v₀: a viscous creep.
#[test]
fn friction_is_viscous_creep_in_stiction() {
    let v = 1e-3 * friction().velocity;
    for [along, across] in [[v, 0.0], [0.0, v], [0.6 * v, -0.8 * v]] {
        let expected = -cone(20.0 * MICRON) * v * v / friction().velocity;
        let power = friction_power([20.0 * MICRON, 0.0, along, across]);
        assert_near(power, expected, expected.abs(), 1e-6, "power of friction");
    }
}

/// −μ(v) p |v| in every direction of sliding and at every penetration rate of the flanks; at the
/// speed of the fall, half of the fall is reached.
#[test]
fn friction_dissipates_its_full_power_in_sliding() {
    let v = friction().fall_speed;
    assert!(v > 500.0 * friction().velocity);
    for [along, across] in [[v, 0.0], [0.0, -v], [-0.6 * v, 0.8 * v]] {
        for penetration_rate in [-0.5, 0.0, 0.5] {
            let expected = -cone(20.0 * MICRON) * (1.0 - 0.5 * friction().fall) * v;
            let power = friction_power([20.0 * MICRON, penetration_rate, along, across]);
            assert_near(power, expected, expected.abs(), 1e-6, "power of friction");
        }
    }
}

/// In any motion, also where damping reduces the normal force, friction opposes sliding and is
/// inside the cone, and damping opposes the penetration.
#[test]
fn friction_and_damping_never_supply_energy() {
    let mut random = noise(1);
    for _ in 0..10_000 {
        let x = [100.0 * MICRON, 2.0, 1.0, 1.0].map(|size| size * random() * (20.0 * random()).exp());
        let found = force(x);
        assert!(friction_power(x) < 0.0, "{x:?}");
        let friction = found.tangential.hypot(found.along_flank);
        assert!(friction < cone(x[0]) * (1.0 + 1e-12), "{x:?}");
        assert!(found.viscous * x[1] > 0.0, "{x:?}");
    }
}
