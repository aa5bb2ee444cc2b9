//! The ALE beam law: its load is the gradient of its energy along every motion of a mesh point, one part of the energy at a
//! time.

use nalgebra::SVector;
use num_dual::Dual64;
use pushbelt::reference_curve::{ReferenceCurve, ReferencePoint, TwoPulley};
use pushbelt::ring::Ring;
use pushbelt::ring::ale::{add_elasticity, dissipation_density, energy_density};
use pushbelt::ring::kinematics::{LineLoad, RingPoint, embed, inward_normal};
use pushbelt::scalar::{Real, zero_vector};
use pushbelt_support::noise;

use crate::assert_near;

const THETA: f64 = 0.25;
/// (∂l/∂Θ)/l of the element around the mesh point.
const GROWTH: f64 = 0.7;

/// Unknowns of a mesh point, or their variations.
#[derive(Clone, Copy)]
struct Shape<T: Real, const D: usize> {
    theta: T,
    slope: SVector<T, D>,
    bend: SVector<T, D>,
}

/// A steel ring with L = 1 m, d_A = 0.2 m (E = 2.1e11 N/m², ρ = 7800 kg/m³).
fn solid() -> Ring {
    Ring {
        mass_per_length: 154.0,
        axial_stiffness: 154.0 / 7800.0 * 2.1e11,
        bending_stiffness: 35_000.0,
        lateral_bending_stiffness: 35_000.0,
        damping: 0.0,
    }
}

/// A point on the primary arc, where the reference curve is bent.
fn reference<T: Real<Constant = f64>>(theta: T) -> ReferencePoint<T> {
    TwoPulley::point(&TwoPulley::new(0.2, 1.0).frame(theta), 2, 0.3)
}

/// The mesh point, with (r')˙ and w.
fn point<T: Real<Constant = f64>, const D: usize>(
    shape: &Shape<T, D>,
    slope_dot: SVector<T, D>,
    w: T,
) -> RingPoint<T, D> {
    let reference = reference(shape.theta);
    let (stretch, inverse_stretch) = shape.slope.dot(&shape.slope).root_and_inverse();
    let t = shape.slope * inverse_stretch;
    // The material is at rest at the mesh point: ṙ|_η = −w r', r̈|_η = −2w (r')˙|_η − w² r''.
    RingPoint {
        reference,
        r: embed(reference.r),
        r_dot: -shape.slope * w,
        r_ddot: slope_dot * (w * -2.0) - shape.bend * (w * w),
        slope: shape.slope,
        slope_dot,
        bend: shape.bend,
        stretch,
        inverse_stretch,
        t,
        n: inward_normal(&t),
        w,
        w_dot: T::zero(),
        strain_gradient: t.dot(&shape.bend),
    }
}

fn resting<T: Real<Constant = f64>, const D: usize>(shape: &Shape<T, D>) -> RingPoint<T, D> {
    point(shape, zero_vector(), T::zero())
}

/// Stretched by `strain` and bent as much relative to the reference curve, in all directions.
fn deflected<const D: usize>(strain: f64) -> Shape<f64, D> {
    let reference = reference(THETA);
    let mut random = noise(6);
    let mut aside = || SVector::from_fn(|_, _| strain * random());
    Shape {
        theta: THETA,
        slope: embed(reference.t * (1.0 + strain)) + aside(),
        bend: embed(reference.n * reference.kappa) + aside() * 20.0,
    }
}

/// Power of the load in random directions against num-dual's derivative of the energy.
fn assert_gradient<const D: usize>(ring: &Ring, shape: &Shape<f64, D>) {
    let mut load = LineLoad::zero();
    add_elasticity(ring, &resting(shape), GROWTH, &mut load);
    let mut random = noise(8);
    for _ in 0..20 {
        let by = Shape {
            theta: random(),
            slope: SVector::<f64, D>::from_fn(|_, _| random()),
            bend: SVector::<f64, D>::from_fn(|_, _| 20.0 * random()),
        };
        let moved = Shape {
            theta: Dual64::new(shape.theta, by.theta),
            slope: shape.slope.zip_map(&by.slope, Dual64::new),
            bend: shape.bend.zip_map(&by.bend, Dual64::new),
        };
        let energy = energy_density(ring, &resting(&moved));
        // Along Θ the element gets longer, and its energy increases with it.
        let expected = energy.eps + energy.re * GROWTH * by.theta;
        let parts = [
            load.slope.dot(&by.slope),
            load.bend.dot(&by.bend),
            load.theta * by.theta,
        ];
        let scale = parts.iter().map(|part| part.abs()).sum::<f64>();
        assert!(scale > 0.0, "the regime has a load");
        assert_near(parts.iter().sum(), expected, scale, 1e-12, "δV");
    }
}

/// Each stiffness alone, then all of them.
#[test]
fn load_is_the_gradient_of_the_energy() {
    let limp = Ring {
        axial_stiffness: 0.0,
        bending_stiffness: 0.0,
        lateral_bending_stiffness: 0.0,
        ..solid()
    };
    let stretching = Ring {
        axial_stiffness: solid().axial_stiffness,
        ..limp
    };
    let bending = Ring {
        bending_stiffness: solid().bending_stiffness,
        ..limp
    };
    for ring in [stretching, bending, solid()] {
        for strain in [1e-3, 0.1, -1e-3] {
            assert_gradient::<2>(&ring, &deflected(strain));
            assert_gradient::<3>(&ring, &deflected(strain));
        }
    }
    let aside = Ring {
        lateral_bending_stiffness: solid().lateral_bending_stiffness,
        ..limp
    };
    assert_gradient::<3>(&aside, &deflected(1e-3));
}

/// Loads with damping and without it, in motion: (r')˙ and w.
fn damping<const D: usize>(slope_dot: SVector<f64, D>, w: f64) -> (f64, f64) {
    let damped = Ring {
        damping: 1e-4,
        ..solid()
    };
    let point = point(&deflected(1e-3), slope_dot, w);
    let [with, without] = [&damped, &solid()].map(|ring| {
        let mut load = LineLoad::zero();
        add_elasticity(ring, &point, GROWTH, &mut load);
        load
    });
    assert_eq!((with.bend, with.theta), (without.bend, without.theta));
    let power = (with.slope - without.slope).dot(&slope_dot) + (with.drift - without.drift) * w;
    (power, dissipation_density(&damped, &point))
}

fn assert_damping<const D: usize>(slope_dot: SVector<f64, D>, w: f64) {
    let (power, dissipated) = damping(slope_dot, w);
    assert!(dissipated > 0.0);
    assert_near(power, dissipated, dissipated, 1e-9, "power of damping");
}

#[test]
fn power_of_damping_where_the_ring_stretches() {
    let t = reference(THETA).t;
    assert_damping::<2>(embed(t * 3.0), 0.0);
    assert_damping::<3>(embed(t * -3.0), 0.0);
}

/// The strain of a particle changes as it moves through a stationary strain field.
#[test]
fn power_of_damping_where_particles_move_through_a_strain_field() {
    assert_damping::<2>(zero_vector(), 30.0);
    assert_damping::<2>(zero_vector(), -30.0);
    assert_damping::<3>(embed(reference(THETA).t * 2.0), 30.0);
}

/// A rigid rotation does not change the strain.
#[test]
fn a_rigid_rotation_has_no_damping() {
    let shape = deflected::<2>(1e-3);
    let turning = SVector::from([-shape.slope[1], shape.slope[0]]) * 5.0;
    let (power, dissipated) = damping::<2>(turning, 0.0);
    let stretching = damping::<2>(shape.slope * 5.0, 0.0).1;
    assert!(
        dissipated < 1e-20 * stretching && power.abs() < 1e-9 * stretching,
        "{power} {dissipated}"
    );
}
