//! The ring at a mesh point.

use super::{ElementMotion, Hermite, Motion, ReferenceMotion, cross, embed, inward_normal};
use crate::reference_curve::{Jet, ReferencePoint};
use crate::scalar::{Real, zero_vector};
use nalgebra::SVector;

/// The ring at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct RingPoint<T: Real, const D: usize = 2> {
    /// Reference curve there.
    pub reference: ReferencePoint<T>,
    /// Position r, m.
    pub r: SVector<T, D>,
    /// ṙ at fixed η, m/s.
    pub r_dot: SVector<T, D>,
    /// r̈ at fixed η, m/s².
    pub r_ddot: SVector<T, D>,
    /// r' = ∂r/∂ξ.
    pub slope: SVector<T, D>,
    /// (r')˙ at fixed η, 1/s.
    pub slope_dot: SVector<T, D>,
    /// r'', 1/m.
    pub bend: SVector<T, D>,
    /// |r'|.
    pub stretch: T,
    /// 1/|r'|.
    pub inverse_stretch: T,
    /// Tangent t̂ = r'/|r'|.
    pub t: SVector<T, D>,
    /// Normals: n̂, inwards in the plane of the drive, and in space b̂ = t̂ × n̂.
    pub normals: [SVector<T, D>; 2],
    /// Material speed through the mesh w = ṡ − ξ̇_η, m/s.
    pub w: T,
    /// ẇ at fixed η, m/s².
    pub w_dot: T,
    /// γ' in the damping, 1/m: that of the point, until a mean replaces it (see `ale.rs`).
    pub strain_gradient: T,
}

impl<T: Real> RingPoint<T> {
    /// Kinematics of a ring that follows the reference curve, which has this growth δ.
    #[inline(always)]
    pub fn guided(reference: ReferencePoint<T>, motion: &ReferenceMotion<T>, growth: &Jet<T>) -> Self {
        let rate = motion.theta.rate;
        let [r, r_dot, r_ddot, ..] = Self::on_curve(&reference, &motion.theta);
        let (w, w_dot) = motion.material_speed(&reference.xi);
        let stretch = growth.v * reference.kappa + 1.0;
        let stretch_dot = (growth.d * reference.kappa + growth.v * reference.kappa_theta) * rate;
        Self {
            r,
            r_dot,
            r_ddot,
            slope: reference.t * stretch,
            slope_dot: reference.n * (reference.chi_theta * rate * stretch) + reference.t * stretch_dot,
            bend: reference.n * (reference.kappa * stretch),
            stretch,
            inverse_stretch: stretch.recip(),
            t: reference.t,
            normals: [reference.n, zero_vector()],
            w,
            w_dot,
            strain_gradient: T::zero(),
            reference,
        }
    }
}

impl<T: Real, const D: usize> RingPoint<T, D> {
    /// r, ṙ, r̈, r', (r')˙ and r'' of the reference curve (28).
    #[inline(always)]
    pub fn on_curve(reference: &ReferencePoint<T>, theta: &Motion<T>) -> [SVector<T, D>; 6] {
        let (rate, acceleration) = (theta.rate, theta.acceleration);
        [
            embed(reference.r),
            embed(reference.r_theta * rate),
            embed(reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration),
            embed(reference.t),
            embed(reference.n * (reference.chi_theta * rate)),
            embed(reference.n * reference.kappa),
        ]
    }

    /// The ring with these r, ṙ, r̈, r', (r')˙ and r''.
    #[inline(always)]
    pub fn of_motion(
        reference: ReferencePoint<T>,
        [r, r_dot, r_ddot, slope, slope_dot, bend]: [SVector<T, D>; 6],
        motion: &ReferenceMotion<T>,
    ) -> Self {
        let (stretch, inverse_stretch) = slope.dot(&slope).root_and_inverse();
        let t = slope * inverse_stretch;
        let n = inward_normal(&t);
        let (w, w_dot) = motion.material_speed(&reference.xi);
        Self {
            reference,
            r,
            r_dot,
            r_ddot,
            slope,
            slope_dot,
            bend,
            stretch,
            inverse_stretch,
            t,
            normals: [n, if D == 3 { cross(&t, &n) } else { zero_vector() }],
            w,
            w_dot,
            strain_gradient: t.dot(&bend),
        }
    }

    /// The ring in an element where its shape functions are `shape`: reference curve and overlay (10).
    #[inline(always)]
    pub fn new(
        reference: ReferencePoint<T>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        motion: &ReferenceMotion<T>,
    ) -> Self {
        let curve = Self::on_curve(&reference, &motion.theta);
        let overlay = element.overlay(shape);
        Self::of_motion(reference, std::array::from_fn(|k| curve[k] + overlay[k]), motion)
    }

    /// Ring velocity v (12), m/s.
    #[inline(always)]
    pub fn velocity(&self) -> SVector<T, D> {
        self.r_dot + self.slope * self.w
    }

    /// Ring acceleration Dv/Dt, m/s².
    #[inline(always)]
    pub fn acceleration(&self) -> SVector<T, D> {
        self.r_ddot + self.slope * self.w_dot + self.slope_dot * (self.w * 2.0) + self.bend * (self.w * self.w)
    }

    /// Axial strain γ = |r'| − 1 (20).
    #[inline(always)]
    pub fn strain(&self) -> T {
        self.stretch - 1.0
    }

    /// Material strain rate Dγ/Dt = γ̇|_η + w γ', 1/s.
    #[inline(always)]
    pub fn strain_rate(&self) -> T {
        self.t.dot(&self.slope_dot) + self.w * self.strain_gradient
    }
}
