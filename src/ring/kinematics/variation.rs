//! The derivatives of a point in one direction.

use super::{ElementMotion, Hermite, RingPoint, cross, embed, in_plane};
use crate::scalar::{Real, turn_right, zero_vector};
use nalgebra::SVector;

/// Derivatives of a [`RingPoint`] in a direction that changes neither the reference curve nor the drift.
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
    pub fn none() -> Self {
        let zero = zero_vector();
        Self {
            r: zero,
            r_dot: zero,
            r_ddot: zero,
            slope: zero,
            slope_dot: zero,
            bend: zero,
            stretch: T::zero(),
            t: zero,
            normals: [zero; 2],
            strain_gradient: T::zero(),
        }
    }

    /// The variation with component `k` of the nodal unknown of shape function `m`. `alpha` and `beta` are the
    /// derivatives of its acceleration and its position with respect to its rate.
    #[inline(always)]
    pub fn of_node(
        point: &RingPoint<T, D>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        [m, k]: [usize; 2],
        [alpha, beta]: [f64; 2],
    ) -> Self {
        let (l, [l_dot, l_ddot]) = (element.length.v, element.length_rates);
        // d = b l for the slope of a node, d = a for its deflection.
        let (d, d_dot, d_ddot) = if m % 2 == 1 {
            (l * beta, l + l_dot * beta, l * alpha + l_dot * 2.0 + l_ddot * beta)
        } else {
            (T::from(beta), T::one(), T::from(alpha))
        };
        let g = l.recip() * 2.0;
        let (n, dn, ddn) = (shape.n[m], shape.dn[m], shape.ddn[m]);
        let mut v = Self::none();
        let slope = d * dn * g;
        v.r[k] = d * n;
        v.r_dot[k] = d_dot * n;
        v.r_ddot[k] = d_ddot * n;
        v.slope[k] = slope;
        v.slope_dot[k] = d_dot * dn * g - slope * (l_dot * g * 0.5);
        v.bend[k] = d * ddn * (g * g);
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
