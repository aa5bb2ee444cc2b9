//! The planar geometrically exact Kirchhoff beam, for rings whose unknowns are positions: `ANCF`
//! and `RCM`.
//!
//! V = ½∫EA γ² dx̄ + ½∫EI κ² dx̄, γ = |r'| − 1, stress-free when straight. κ = (r' × r'')/|r'|² is
//! the turning of the cross section per *unstretched* length, which is conjugate to the bending
//! moment (Gerstmayr and Irschik 2008, J. Sound Vib. 318, 461–487). Berzeri and Shabana (2000, J.
//! Sound Vib. 235, 539–565) list this beam's elastic forces in absolute nodal coordinates with the
//! geometric curvature (r' × r'')/|r'|³; the two differ by the factor 1 + γ, and with the latter a
//! uniformly stretched circle has bending forces along it.
//!
//! Damping as in [`super::ale`]: T = EA (γ + η Dγ/Dt).

use super::Ring;
use super::particle::{Particle, ParticleLoad};
use crate::scalar::{Real, turn_right};

/// Adds inertia as the force m_r Dv/Dt against δr.
#[inline(always)]
pub fn add_inertia<T: Real>(ring: &Ring, particle: &Particle<T>, load: &mut ParticleLoad<T>) {
    load.position += particle.acceleration * T::from(ring.mass_per_length);
}

/// Ring tension T at the strain γ and its rate, N.
#[inline(always)]
pub fn tension<T: Real>(ring: &Ring, strain: T, rate: T) -> T {
    (strain + rate * ring.damping) * ring.axial_stiffness
}

/// Adds the force of the ring tension `tension`: T δγ.
#[inline(always)]
pub fn add_tension<T: Real>(tension: T, particle: &Particle<T>, load: &mut ParticleLoad<T>) {
    load.slope += particle.slope * (tension * particle.inverse_stretch());
}

/// Adds the bending force EI κ δκ.
#[inline(always)]
pub fn add_bending<T: Real>(ring: &Ring, particle: &Particle<T>, load: &mut ParticleLoad<T>) {
    let (slope, bend, inverse) = (particle.slope, particle.bend, particle.inverse_stretch());
    let scale = inverse * inverse;
    let normal = turn_right(slope) * scale;
    let kappa = normal.dot(&bend);
    let moment = kappa * ring.bending_stiffness;
    load.slope -= (turn_right(bend) + slope * (kappa * 2.0)) * (moment * scale);
    load.bend += normal * moment;
}
