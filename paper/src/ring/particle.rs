//! A ring particle: position of the ring at a place, and motion of its material there. Every ring
//! model computes its particles from its unknowns, and maps forces on them to forces on its
//! unknowns.
//!
//! A prime is the derivative along the unstretched ring, ∂/∂ξ at fixed time = ∂/∂x̄ (1), and
//! velocities are those of the material. The mesh of stack and contact is fixed in space. The stack
//! uses the ring at a mesh point η: [`Particle::at_station`] computes this [`RingPoint`] from the
//! particle that passes there,
//!
//! ṙ|_η = v − w r', (r')˙|_η = v' − w r'', r̈|_η = a − ẇ r' − 2w (r')˙|_η − w² r'', w = ṡ − ξ̇_η.

use super::kinematics::{LineLoad, PointMotion, ReferenceMotion, RingPoint};
use crate::reference_curve::ReferencePoint;
use crate::scalar::{Real, turn_right, zero_vector};
use nalgebra::SVector;

/// The ring at a place, and the motion of its material there.
#[derive(Clone, Copy, Debug)]
pub struct Particle<T: Real, const D: usize = 2> {
    /// Position r, m.
    pub r: SVector<T, D>,
    /// r'.
    pub slope: SVector<T, D>,
    /// r'', 1/m.
    pub bend: SVector<T, D>,
    /// Velocity v, m/s.
    pub velocity: SVector<T, D>,
    /// Velocity gradient v' = D(r')/Dt, 1/s.
    pub velocity_slope: SVector<T, D>,
    /// Acceleration Dv/Dt, m/s².
    pub acceleration: SVector<T, D>,
}

impl<T: Real, const D: usize> Particle<T, D> {
    /// |r'|.
    #[inline(always)]
    pub fn stretch(&self) -> T {
        self.slope.dot(&self.slope).root_and_inverse().0
    }

    /// 1/|r'|.
    #[inline(always)]
    pub fn inverse_stretch(&self) -> T {
        self.slope.dot(&self.slope).root_and_inverse().1
    }

    /// Axial strain γ = |r'| − 1 (20).
    #[inline(always)]
    pub fn strain(&self) -> T {
        self.stretch() - 1.0
    }

    /// Dγ/Dt, 1/s.
    #[inline(always)]
    pub fn strain_rate(&self) -> T {
        self.slope.dot(&self.velocity_slope) * self.inverse_stretch()
    }

    /// The ring at a mesh point of the reference curve, currently at `reference`.
    #[inline(always)]
    pub fn at_station(&self, reference: ReferencePoint<T>, motion: &ReferenceMotion<T>) -> RingPoint<T, D> {
        let speed = motion.material_speed(&reference.xi);
        let (w, w_dot) = (speed.value, speed.rate);
        let slope_dot = self.velocity_slope - self.bend * w;
        let r_dot = self.velocity - self.slope * w;
        let r_ddot = self.acceleration - self.slope * w_dot - slope_dot * (w * 2.0) - self.bend * (w * w);
        let place = PointMotion {
            r: self.r,
            r_dot,
            r_ddot,
            slope: self.slope,
            slope_dot,
            bend: self.bend,
            // Needs r''', and only damping on an Eulerian mesh uses it.
            bend_dot: zero_vector(),
        };
        RingPoint::from_motion(reference, place, motion)
    }
}

impl<T: Real> Particle<T> {
    /// Turning of the tangent per unstretched length, (r' × r'')/|r'|², 1/m; positive inwards.
    #[inline(always)]
    pub fn curvature(&self) -> T {
        let inverse = self.inverse_stretch();
        turn_right(self.slope).dot(&self.bend) * (inverse * inverse)
    }
}

impl<T: Real, const D: usize> From<&RingPoint<T, D>> for Particle<T, D> {
    #[inline(always)]
    fn from(point: &RingPoint<T, D>) -> Self {
        Self {
            r: point.r,
            slope: point.slope,
            bend: point.bend,
            velocity: point.velocity(),
            velocity_slope: point.slope_dot + point.bend * point.w,
            acceleration: point.acceleration(),
        }
    }
}

/// Forces per length on a particle, conjugate to its virtual displacement and the derivatives of
/// that along ξ.
#[derive(Clone, Copy, Debug)]
pub struct ParticleLoad<T: Real, const D: usize = 2> {
    /// Conjugate to δr, N/m.
    pub position: SVector<T, D>,
    /// Conjugate to δr', N.
    pub slope: SVector<T, D>,
    /// Conjugate to δr'', N·m.
    pub bend: SVector<T, D>,
}

impl<T: Real, const D: usize> ParticleLoad<T, D> {
    /// No force.
    #[inline(always)]
    pub fn zero() -> Self {
        Self {
            position: zero_vector(),
            slope: zero_vector(),
            bend: zero_vector(),
        }
    }
}

/// The load on a mesh point from one on the particle that passes it: virtual displacements at fixed
/// x̄ are δr|_η + r' δσ, δσ the drift through the mesh. The part in δσ of a load on r'' is
/// neglected, because it contains r'''.
#[inline(always)]
#[must_use]
pub fn load_of_particle<T: Real, const D: usize>(
    load: &ParticleLoad<T, D>,
    point: &RingPoint<T, D>,
) -> LineLoad<T, D> {
    LineLoad {
        position: load.position,
        slope: load.slope,
        bend: load.bend,
        drift: load.position.dot(&point.slope) + load.slope.dot(&point.bend),
        theta: T::zero(),
    }
}
