//! The ALE ring as a Kirchhoff beam: inertia and elastic energy (paper 4; `docs/theory.md`, section
//! 3). One law in the plane (D = 2) and in space.
//!
//! Energy V = ½∫EA γ² dξ + ½∫EI κ_n² dξ (17), γ = |r'| − 1 (20), stress-free when straight. The
//! paper's κ_n = n_refᵀ r'' mixes stretch into bending; here κ_n = n_refᵀ r'' − κ_ref (t_refᵀ r' −
//! 1). In space V also contains ½∫EI_b κ_b² dξ, κ_b = −w'' (24) with the deflection w along z:
//! sections stay upright, as elements between two flanks hold them.
//!
//! V is differentiated at fixed η, dξ = ξ_η dη included. The result contains the border terms
//! ½EI\[κ²\] dξ_k/dΘ that the paper's (18), (23b) lose where κ_ref jumps at a moving arc border.
//!
//! Inertia is ∫ m_r Pᵀ Dv/Dt dξ, not as printed in (14), (26b).
//!
//! Kelvin–Voigt damping T = EA (γ + η Dγ/Dt) has the virtual power of Dγ/Dt = γ̇ + w γ', with the
//! mean of γ' over a cell of the mesh: the pointwise γ' excites waves as short as an element
//! (`docs/decisions.md`). The moment EI η n_refᵀ (r'')˙ damps bending that changes at a mesh point,
//! without loss in steady running.

use super::Ring;
use super::kinematics::{LineLoad, RingPoint, RingVariation, embed, in_plane};
use crate::reference_curve::ReferencePoint;
use crate::scalar::Real;
use nalgebra::SVector;

/// Adds inertia as the force m_r Dv/Dt against δv.
#[inline(always)]
pub fn add_inertia<T: Real, const D: usize>(ring: &Ring, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) {
    let force = point.acceleration() * T::from(ring.mass_per_length);
    load.position += force;
    load.drift += force.dot(&point.slope);
}

/// Bending measure κ_n, 1/m.
#[inline(always)]
pub fn curvature<T: Real, const D: usize>(point: &RingPoint<T, D>) -> T {
    let reference = &point.reference;
    reference.n.dot(&in_plane(&point.bend))
        - reference.kappa * (reference.t.dot(&in_plane(&point.slope)) - 1.0)
}

/// Rate of bending n_refᵀ (r'')˙ at fixed η, 1/(m s).
#[inline(always)]
fn bending_rate<T: Real, const D: usize>(point: &RingPoint<T, D>) -> T {
    point.reference.n.dot(&in_plane(&point.bend_dot))
}

/// Energies, the integrands of (6), (17), and damping of the ring at a point.
#[derive(Clone, Copy, Debug)]
pub struct RingDensity<T> {
    /// Kinetic energy per dξ, J/m.
    pub kinetic: T,
    /// Energy of the strain γ per dξ, J/m.
    pub membrane: T,
    /// Energy of bending per dξ, J/m.
    pub bending: T,
    /// Power of damping per dξ, W/m.
    pub viscous: T,
}

/// Their values at a point.
#[inline(always)]
pub fn density<T: Real, const D: usize>(ring: &Ring, point: &RingPoint<T, D>) -> RingDensity<T> {
    let (velocity, gamma, rate, kappa) =
        (point.velocity(), point.strain(), point.strain_rate(), curvature(point));
    let kappa_dot = bending_rate(point);
    let mut bending = kappa * kappa * ring.bending_stiffness;
    let mut damped = rate * rate * ring.axial_stiffness + kappa_dot * kappa_dot * ring.bending_stiffness;
    for i in 2..D {
        bending += point.bend[i] * point.bend[i] * ring.lateral_bending_stiffness;
        damped += point.bend_dot[i] * point.bend_dot[i] * ring.lateral_bending_stiffness;
    }
    RingDensity {
        kinetic: velocity.dot(&velocity) * (0.5 * ring.mass_per_length),
        membrane: gamma * gamma * (0.5 * ring.axial_stiffness),
        bending: bending * 0.5,
        viscous: damped * ring.damping,
    }
}

/// ∂κ_n/∂Θ at these r' and r''; `one` is 0 where they are variations.
#[inline(always)]
fn kappa_theta<T: Real, const D: usize>(
    reference: &ReferencePoint<T>,
    slope: &SVector<T, D>,
    bend: &SVector<T, D>,
    one: f64,
) -> T {
    let (slope, bend) = (in_plane(slope), in_plane(bend));
    -(reference.chi_theta * reference.t.dot(&bend))
        - reference.kappa_theta * (reference.t.dot(&slope) - one)
        - reference.kappa * reference.chi_theta * reference.n.dot(&slope)
}

/// Adds ∂V/∂q and the damping force; `dilation` = (∂l/∂Θ)/l of the element. Returns the ring
/// tension T, N.
#[inline(always)]
pub fn add_elasticity<T: Real, const D: usize>(
    ring: &Ring,
    point: &RingPoint<T, D>,
    dilation: T,
    load: &mut LineLoad<T, D>,
) -> T {
    let reference = &point.reference;
    let kappa = curvature(point);
    let moment = kappa * ring.bending_stiffness;
    let resisting = bending_rate(point) * (ring.bending_stiffness * ring.damping);
    let viscous = point.strain_rate() * ring.viscosity();
    let tension = point.strain() * ring.axial_stiffness + viscous;
    load.slope += point.t * tension - embed(reference.t * (moment * reference.kappa));
    load.bend += embed(reference.n * (moment + resisting));
    for i in 2..D {
        load.bend[i] += (point.bend[i] + point.bend_dot[i] * ring.damping) * ring.lateral_bending_stiffness;
    }
    load.drift += viscous * point.strain_gradient;
    let kappa_theta = kappa_theta(reference, &point.slope, &point.bend, 1.0);
    let RingDensity { membrane, bending, .. } = density(ring, point);
    load.theta += moment * kappa_theta + (membrane + bending) * dilation;
    tension
}

/// Adds the variation of [`add_inertia`].
#[inline(always)]
pub fn vary_inertia<T: Real, const D: usize>(
    ring: &Ring,
    point: &RingPoint<T, D>,
    by: &RingVariation<T, D>,
    load: &mut LineLoad<T, D>,
) {
    let mass = T::from(ring.mass_per_length);
    let w = point.w;
    let force = (by.r_ddot + by.slope * point.w_dot + by.slope_dot * (w * 2.0) + by.bend * (w * w)) * mass;
    load.position += force;
    load.drift += force.dot(&point.slope) + point.acceleration().dot(&by.slope) * mass;
}

/// Adds the variation of [`add_elasticity`]. Returns that of the ring tension, N.
#[inline(always)]
pub fn vary_elasticity<T: Real, const D: usize>(
    ring: &Ring,
    point: &RingPoint<T, D>,
    by: &RingVariation<T, D>,
    dilation: T,
    load: &mut LineLoad<T, D>,
) -> T {
    let reference = &point.reference;
    let (t_ref, n_ref) = (&reference.t, &reference.n);
    let viscosity = ring.viscosity();
    let kappa = curvature(point);
    let d_kappa = n_ref.dot(&in_plane(&by.bend)) - reference.kappa * t_ref.dot(&in_plane(&by.slope));
    let (moment, d_moment) = (kappa * ring.bending_stiffness, d_kappa * ring.bending_stiffness);
    let d_resisting = n_ref.dot(&in_plane(&by.bend_dot)) * (ring.bending_stiffness * ring.damping);
    let (gradient, d_gradient) = (point.strain_gradient, by.strain_gradient);
    let viscous = point.strain_rate() * viscosity;
    let d_viscous =
        (by.t.dot(&point.slope_dot) + point.t.dot(&by.slope_dot) + point.w * d_gradient) * viscosity;
    let tension = point.strain() * ring.axial_stiffness + viscous;
    let d_tension = by.stretch * ring.axial_stiffness + d_viscous;
    load.slope += by.t * tension + point.t * d_tension - embed(t_ref * (d_moment * reference.kappa));
    load.bend += embed(n_ref * (d_moment + d_resisting));
    let mut d_energy = point.strain() * by.stretch * ring.axial_stiffness + moment * d_kappa;
    for i in 2..D {
        let lateral = by.bend[i] * ring.lateral_bending_stiffness;
        load.bend[i] += lateral + by.bend_dot[i] * (ring.lateral_bending_stiffness * ring.damping);
        d_energy += point.bend[i] * lateral;
    }
    load.drift += d_viscous * gradient + viscous * d_gradient;
    load.theta += d_moment * kappa_theta(reference, &point.slope, &point.bend, 1.0)
        + moment * kappa_theta(reference, &by.slope, &by.bend, 0.0)
        + d_energy * dilation;
    d_tension
}
