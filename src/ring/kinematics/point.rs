//! The ring at a mesh point, and its derivatives in one direction.

use super::{
    ElementMotion, Hermite, Motion, PointMotion, ReferenceMotion, WithRate, cross, embed, in_plane,
    inward_normal,
};
use crate::reference_curve::{Jet, ReferencePoint};
use crate::scalar::{Real, turn_right, zero_vector};
use crate::solver::Factors;
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
    /// (r'')˙ at fixed η, 1/(m s).
    pub bend_dot: SVector<T, D>,
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
    /// The ring on the reference curve, which has this growth δ.
    #[inline(always)]
    pub fn guided(reference: ReferencePoint<T>, motion: &ReferenceMotion<T>, growth: &Jet<T>) -> Self {
        let rate = motion.theta.rate;
        let stretch = growth.v * reference.kappa + 1.0;
        let stretch_dot = (growth.d * reference.kappa + growth.v * reference.kappa_theta) * rate;
        let place = PointMotion {
            slope: reference.t * stretch,
            slope_dot: reference.n * (reference.chi_theta * rate * stretch) + reference.t * stretch_dot,
            bend: reference.n * (reference.kappa * stretch),
            bend_dot: reference.bend_theta() * (rate * stretch)
                + reference.n * (reference.kappa * stretch_dot),
            ..Self::on_curve(&reference, &motion.theta)
        };
        Self {
            stretch,
            inverse_stretch: stretch.recip(),
            t: reference.t,
            normals: [reference.n, zero_vector()],
            strain_gradient: T::zero(),
            ..Self::from_motion(reference, place, motion)
        }
    }
}

impl<T: Real, const D: usize> RingPoint<T, D> {
    /// A mesh point on the reference curve.
    #[inline(always)]
    pub fn on_curve(reference: &ReferencePoint<T>, theta: &Motion<T>) -> PointMotion<SVector<T, D>> {
        let (rate, acceleration) = (theta.rate, theta.acceleration);
        PointMotion {
            r: embed(reference.r),
            r_dot: embed(reference.r_theta * rate),
            r_ddot: embed(reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration),
            slope: embed(reference.t),
            slope_dot: embed(reference.n * (reference.chi_theta * rate)),
            bend: embed(reference.n * reference.kappa),
            bend_dot: embed(reference.bend_theta() * rate),
        }
    }

    /// The ring at a mesh point that moves so, where the curve has this `motion`.
    #[inline(always)]
    pub fn from_motion(
        reference: ReferencePoint<T>,
        PointMotion {
            r,
            r_dot,
            r_ddot,
            slope,
            slope_dot,
            bend,
            bend_dot,
        }: PointMotion<SVector<T, D>>,
        motion: &ReferenceMotion<T>,
    ) -> Self {
        let (stretch, inverse_stretch) = slope.dot(&slope).root_and_inverse();
        let t = slope * inverse_stretch;
        let n = inward_normal(&t);
        let WithRate { value: w, rate: w_dot } = motion.material_speed(&reference.xi);
        Self {
            reference,
            r,
            r_dot,
            r_ddot,
            slope,
            slope_dot,
            bend,
            bend_dot,
            stretch,
            inverse_stretch,
            t,
            normals: [n, if D == 3 { cross(&t, &n) } else { zero_vector() }],
            w,
            w_dot,
            strain_gradient: t.dot(&bend),
        }
    }

    /// The ring where its shape functions are `shape`: reference curve and overlay (10).
    #[inline(always)]
    pub fn new(
        reference: ReferencePoint<T>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        motion: &ReferenceMotion<T>,
    ) -> Self {
        let curve = Self::on_curve(&reference, &motion.theta);
        let overlay = element.overlay(shape);
        Self::from_motion(reference, curve.zip(overlay, |curve, overlay| curve + overlay), motion)
    }

    /// Ring velocity v (12), m/s.
    #[inline(always)]
    pub fn velocity(&self) -> SVector<T, D> {
        self.r_dot + self.slope * self.w
    }

    /// Ring acceleration Dv/Dt, m/s².
    #[inline(always)]
    pub fn acceleration(&self) -> SVector<T, D> {
        self.r_ddot
            + self.slope * self.w_dot
            + self.slope_dot * (self.w * 2.0)
            + self.bend * (self.w * self.w)
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

/// An unknown of a node of an element.
#[derive(Clone, Copy, Debug)]
pub struct NodalUnknown {
    /// Its shape function, 0 to 3.
    pub function: usize,
    /// Its component.
    pub component: usize,
}

/// Derivatives of a [`RingPoint`] in a direction that changes neither the reference curve nor the
/// drift.
#[derive(Clone, Copy, Debug)]
pub struct RingVariation<T: Real, const D: usize = 2> {
    /// δr.
    pub r: SVector<T, D>,
    /// δṙ.
    pub r_dot: SVector<T, D>,
    /// δr̈.
    pub r_ddot: SVector<T, D>,
    /// δr'.
    pub slope: SVector<T, D>,
    /// δ(r')˙.
    pub slope_dot: SVector<T, D>,
    /// δr''.
    pub bend: SVector<T, D>,
    /// δ(r'')˙.
    pub bend_dot: SVector<T, D>,
    /// δ|r'|.
    pub stretch: T,
    /// δt̂.
    pub t: SVector<T, D>,
    /// δn̂ and δb̂.
    pub normals: [SVector<T, D>; 2],
    /// δγ'.
    pub strain_gradient: T,
}

impl<T: Real, const D: usize> RingVariation<T, D> {
    /// No variation.
    #[inline(always)]
    #[must_use]
    pub fn none() -> Self {
        let zero = zero_vector();
        Self {
            r: zero,
            r_dot: zero,
            r_ddot: zero,
            slope: zero,
            slope_dot: zero,
            bend: zero,
            bend_dot: zero,
            stretch: T::zero(),
            t: zero,
            normals: [zero; 2],
            strain_gradient: T::zero(),
        }
    }

    /// The variation with an unknown of a node.
    #[inline(always)]
    pub fn new(
        point: &RingPoint<T, D>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        NodalUnknown {
            function,
            component: k,
        }: NodalUnknown,
        Factors { alpha, beta }: Factors,
    ) -> Self {
        let Motion {
            value: l,
            rate: l_dot,
            acceleration: l_ddot,
        } = element.length_motion;
        // d = b l for the slope of a node, d = a for its deflection.
        let (d, d_dot, d_ddot) = if function % 2 == 1 {
            (l * beta, l + l_dot * beta, l * alpha + l_dot * 2.0 + l_ddot * beta)
        } else {
            (T::from(beta), T::one(), T::from(alpha))
        };
        let g = l.recip() * 2.0;
        let (n, dn, ddn) = (shape.n[function], shape.dn[function], shape.ddn[function]);
        let mut v = Self::none();
        let slope = d * dn * g;
        v.r[k] = d * n;
        v.r_dot[k] = d_dot * n;
        v.r_ddot[k] = d_ddot * n;
        v.slope[k] = slope;
        v.slope_dot[k] = d_dot * dn * g - slope * (l_dot * g * 0.5);
        v.bend[k] = d * ddn * (g * g);
        v.bend_dot[k] = d_dot * ddn * (g * g) - v.bend[k] * (l_dot * g);
        v.stretch = point.t[k] * slope;
        v.t = (v.slope - point.t * v.stretch) * point.inverse_stretch;
        v.strain_gradient = v.t.dot(&point.bend) + point.t.dot(&v.bend);
        let turned = turn_right(in_plane(&v.t));
        if D == 2 {
            v.normals[0] = embed(turned);
        } else {
            let (t, n) = (&point.t, in_plane(&point.normals[0]));
            let inverse = in_plane(t).dot(&in_plane(t)).sqrt().recip();
            v.normals[0] = embed((turned - n * n.dot(&turned)) * inverse);
            v.normals[1] = cross(&v.t, &point.normals[0]) + cross(t, &v.normals[0]);
        }
        v
    }
}
