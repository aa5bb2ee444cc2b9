//! Shape functions, and the motion of nodes, of elements and of the reference degrees of freedom.

use crate::reference_curve::Jet;
use crate::scalar::Real;
use nalgebra::SVector;
use std::ops::Mul;

/// Cubic Hermite functions at a local coordinate x ∈ [−1, 1] (paper 5.2), and their x derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Hermite<L = f64> {
    /// Values N_k.
    pub n: [L; 4],
    /// First derivatives with respect to x.
    pub dn: [L; 4],
    /// Second derivatives with respect to x.
    pub ddn: [L; 4],
}

impl<L: Real> Hermite<L> {
    /// Functions N₁, N₂/l, N₃, N₄/l at `x`. The paper prints N₄ with the opposite sign.
    #[must_use]
    pub fn new(x: L) -> Self {
        Self {
            n: [
                (-(x * 3.0) + 2.0 + x * x * x) * 0.25,
                (-x + 1.0 - x * x + x * x * x) * 0.125,
                (x * 3.0 + 2.0 - x * x * x) * 0.25,
                (-x - 1.0 + x * x + x * x * x) * 0.125,
            ],
            dn: [
                (x * x - 1.0) * 0.75,
                (-(x * 2.0) - 1.0 + x * 3.0 * x) * 0.125,
                (-(x * x) + 1.0) * 0.75,
                (x * 2.0 - 1.0 + x * 3.0 * x) * 0.125,
            ],
            ddn: [x * 1.5, (x * 3.0 - 1.0) * 0.25, -(x * 1.5), (x * 3.0 + 1.0) * 0.25],
        }
    }
}

/// Σ weights·d.
#[inline(always)]
pub fn combine<T: Real + Mul<W, Output = T>, W: Copy, const D: usize>(
    weights: &[W; 4],
    d: &[SVector<T, D>; 4],
) -> SVector<T, D> {
    SVector::from_fn(|i, _| {
        d[0][i] * weights[0] + d[1][i] * weights[1] + d[2][i] * weights[2] + d[3][i] * weights[3]
    })
}

/// Deflection and slope of a node, or a time derivative of them.
#[derive(Clone, Copy, Debug)]
pub struct Node<T: Real, const D: usize = 2> {
    /// Deflection, m.
    pub a: SVector<T, D>,
    /// Slope ∂/∂ξ of the deflection.
    pub b: SVector<T, D>,
}

/// A quantity and its rate.
#[derive(Clone, Copy, Debug)]
pub struct WithRate<T> {
    /// The quantity itself.
    pub value: T,
    /// Its rate.
    pub rate: T,
}

/// A quantity with its first and second time derivative at fixed η.
#[derive(Clone, Copy, Debug)]
pub struct Motion<T> {
    /// The quantity itself.
    pub value: T,
    /// Its first time derivative.
    pub rate: T,
    /// Its second time derivative.
    pub acceleration: T,
}

impl<T: Real> Motion<T> {
    /// Motion of a function of Θ, whose motion this is.
    #[inline(always)]
    #[must_use]
    pub fn chain_rule(&self, function: &Jet<T>) -> Self {
        Self {
            value: function.v,
            rate: function.d * self.rate,
            acceleration: function.dd * self.rate * self.rate + function.d * self.acceleration,
        }
    }
}

/// Motion of the reference degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceMotion<T> {
    /// Θ, Θ̇, Θ̈.
    pub theta: Motion<T>,
    /// Drift rate ṡ, m/s.
    pub s_dot: T,
    /// s̈, m/s².
    pub s_ddot: T,
}

impl<T: Real> ReferenceMotion<T> {
    /// Speed w = ṡ − ξ_Θ Θ̇ of the material relative to a mesh point, m/s.
    #[inline(always)]
    pub fn material_speed(&self, xi: &Jet<T>) -> WithRate<T> {
        let (rate, acceleration) = (self.theta.rate, self.theta.acceleration);
        WithRate {
            value: self.s_dot - xi.d * rate,
            rate: self.s_ddot - xi.d * acceleration - xi.dd * rate * rate,
        }
    }
}

/// Place and motion of a mesh point, or parts of them.
#[derive(Clone, Copy, Debug)]
pub struct PointMotion<V> {
    /// r, m.
    pub r: V,
    /// ṙ, m/s.
    pub r_dot: V,
    /// r̈, m/s².
    pub r_ddot: V,
    /// r'.
    pub slope: V,
    /// (r')˙, 1/s.
    pub slope_dot: V,
    /// r'', 1/m.
    pub bend: V,
    /// (r'')˙, 1/(m s).
    pub bend_dot: V,
}

impl<V> PointMotion<V> {
    /// `f` of each vector and of that of `other`.
    #[inline(always)]
    pub fn zip<U, W>(self, other: PointMotion<U>, f: impl Fn(V, U) -> W) -> PointMotion<W> {
        PointMotion {
            r: f(self.r, other.r),
            r_dot: f(self.r_dot, other.r_dot),
            r_ddot: f(self.r_ddot, other.r_ddot),
            slope: f(self.slope, other.slope),
            slope_dot: f(self.slope_dot, other.slope_dot),
            bend: f(self.bend, other.bend),
            bend_dot: f(self.bend_dot, other.bend_dot),
        }
    }
}

/// Motion of an element in the coordinates d = (a₁, l b₁, a₂, l b₂).
#[derive(Clone, Copy, Debug)]
pub struct ElementMotion<T: Real, const D: usize = 2> {
    /// Element length l(Θ), m.
    pub length: Jet<T>,
    pub(super) length_motion: Motion<T>,
    d: Motion<[SVector<T, D>; 4]>,
    /// Slopes b of the two nodes.
    pub(super) slopes: [SVector<T, D>; 2],
}

impl<T: Real, const D: usize> ElementMotion<T, D> {
    /// An element between two nodes.
    #[inline(always)]
    pub fn new(length: Jet<T>, theta: &Motion<T>, nodes: &[Motion<Node<T, D>>; 2]) -> Self {
        let length_motion = theta.chain_rule(&length);
        let Motion {
            value: l,
            rate: l_dot,
            acceleration: l_ddot,
        } = length_motion;
        let [[a_1, b_1], [a_2, b_2]] = nodes.each_ref().map(|node| {
            let (b, b_dot, b_ddot) = (node.value.b, node.rate.b, node.acceleration.b);
            let slope = [
                b * l,
                b_dot * l + b * l_dot,
                b_ddot * l + b_dot * (l_dot * 2.0) + b * l_ddot,
            ];
            [[node.value.a, node.rate.a, node.acceleration.a], slope]
        });
        Self {
            length,
            length_motion,
            d: Motion {
                value: [a_1[0], b_1[0], a_2[0], b_2[0]],
                rate: [a_1[1], b_1[1], a_2[1], b_2[1]],
                acceleration: [a_1[2], b_1[2], a_2[2], b_2[2]],
            },
            slopes: [nodes[0].value.b, nodes[1].value.b],
        }
    }

    /// Overlay u where the shape functions are `shape`.
    #[inline(always)]
    pub fn overlay(&self, shape: &Hermite<T::Constant>) -> PointMotion<SVector<T, D>> {
        let d = &self.d;
        let g = self.length.v.recip() * 2.0;
        let slope = combine(&shape.dn, &d.value) * g;
        let bend = combine(&shape.ddn, &d.value) * (g * g);
        PointMotion {
            r: combine(&shape.n, &d.value),
            r_dot: combine(&shape.n, &d.rate),
            r_ddot: combine(&shape.n, &d.acceleration),
            slope,
            slope_dot: combine(&shape.dn, &d.rate) * g - slope * (self.length_motion.rate * g * 0.5),
            bend,
            bend_dot: combine(&shape.ddn, &d.rate) * (g * g) - bend * (self.length_motion.rate * g),
        }
    }
}
