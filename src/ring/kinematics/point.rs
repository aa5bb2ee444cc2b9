//! The ring at a mesh point.

use super::{ElementMotion, Hermite, ReferenceMotion, combine, cross, embed, inward_normal};
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
    /// Inward normal n̂, in the plane of the drive.
    pub n: SVector<T, D>,
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
        let (rate, acceleration) = (motion.theta.rate, motion.theta.acceleration);
        let (w, w_dot) = motion.material_speed(&reference.xi);
        let stretch = growth.v * reference.kappa + 1.0;
        let stretch_dot = (growth.d * reference.kappa + growth.v * reference.kappa_theta) * rate;
        Self {
            reference,
            r: reference.r,
            r_dot: reference.r_theta * rate,
            r_ddot: reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration,
            slope: reference.t * stretch,
            slope_dot: reference.n * (reference.chi_theta * rate * stretch) + reference.t * stretch_dot,
            bend: reference.n * (reference.kappa * stretch),
            stretch,
            inverse_stretch: stretch.recip(),
            t: reference.t,
            n: reference.n,
            w,
            w_dot,
            strain_gradient: T::zero(),
        }
    }
}

impl<T: Real, const D: usize> RingPoint<T, D> {
    /// Kinematics of an element where its shape functions are `shape`.
    #[inline(always)]
    pub fn new(
        reference: ReferencePoint<T>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        motion: &ReferenceMotion<T>,
    ) -> Self {
        let (rate, acceleration) = (motion.theta.rate, motion.theta.acceleration);
        let mut r: SVector<T, D> = embed(reference.r);
        let mut r_dot: SVector<T, D> = embed(reference.r_theta * rate);
        let mut r_ddot: SVector<T, D> = embed(reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration);
        let mut slope: SVector<T, D> = embed(reference.t);
        let mut slope_dot: SVector<T, D> = embed(reference.n * (reference.chi_theta * rate));
        let mut bend: SVector<T, D> = embed(reference.n * reference.kappa);
        if let Some(overlay) = &element.overlay {
            let g = element.length.v.recip() * 2.0;
            let u_slope = combine(&shape.dn, &overlay.d) * g;
            r += combine(&shape.n, &overlay.d);
            r_dot += combine(&shape.n, &overlay.rate);
            r_ddot += combine(&shape.n, &overlay.acceleration);
            slope += u_slope;
            slope_dot += combine(&shape.dn, &overlay.rate) * g - u_slope * (element.length.d * rate * g * 0.5);
            bend += combine(&shape.ddn, &overlay.d) * (g * g);
        }
        let (stretch, inverse_stretch) = slope.dot(&slope).root_and_inverse();
        let t = slope * inverse_stretch;
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
            n: inward_normal(&t),
            w,
            w_dot,
            strain_gradient: t.dot(&bend),
        }
    }

    /// Normals of the ring: n̂, and in space b̂ = t̂ × n̂.
    #[inline(always)]
    pub fn normals(&self) -> [SVector<T, D>; 2] {
        let binormal = if D == 3 { cross(&self.t, &self.n) } else { zero_vector() };
        [self.n, binormal]
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
