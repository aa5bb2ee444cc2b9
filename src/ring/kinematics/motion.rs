//! Shape functions, and the motion of nodes, of elements and of the reference degrees of freedom.

use crate::reference_curve::Jet;
use crate::scalar::Real;
use nalgebra::SVector;
use std::ops::Mul;

/// Cubic Hermite functions of the element at a local coordinate x ∈ [−1, 1] (paper 5.2), and their
/// x derivatives.
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

/// Σ weights·d. The weights are mesh constants or, where the mesh moves past a fixed place, of the
/// type of d.
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
    /// First and second time derivative of a function `of` Θ, whose motion this is.
    #[inline(always)]
    pub fn rates(&self, of: &Jet<T>) -> [T; 2] {
        [
            of.d * self.rate,
            of.dd * self.rate * self.rate + of.d * self.acceleration,
        ]
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
    /// Speed w = ṡ − ξ_Θ Θ̇ of the material relative to a mesh point, m/s, and its rate, m/s².
    #[inline(always)]
    pub fn material_speed(&self, xi: &Jet<T>) -> (T, T) {
        let (rate, acceleration) = (self.theta.rate, self.theta.acceleration);
        (
            self.s_dot - xi.d * rate,
            self.s_ddot - xi.d * acceleration - xi.dd * rate * rate,
        )
    }
}

/// Motion of an element in the coordinates d = (a₁, l b₁, a₂, l b₂).
#[derive(Clone, Copy, Debug)]
pub struct ElementMotion<T: Real, const D: usize = 2> {
    /// Element length l(Θ), m.
    pub length: Jet<T>,
    /// l̇, m/s, and l̈, m/s².
    pub(super) length_rates: [T; 2],
    d: Motion<[SVector<T, D>; 4]>,
    /// Slopes b of the two nodes.
    pub(super) slopes: [SVector<T, D>; 2],
}

impl<T: Real, const D: usize> ElementMotion<T, D> {
    /// An element between two nodes.
    #[inline(always)]
    pub fn new(length: Jet<T>, theta: &Motion<T>, nodes: &[Motion<Node<T, D>>; 2]) -> Self {
        let (l, [l_dot, l_ddot]) = (length.v, theta.rates(&length));
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
            length_rates: [l_dot, l_ddot],
            d: Motion {
                value: [a_1[0], b_1[0], a_2[0], b_2[0]],
                rate: [a_1[1], b_1[1], a_2[1], b_2[1]],
                acceleration: [a_1[2], b_1[2], a_2[2], b_2[2]],
            },
            slopes: [nodes[0].value.b, nodes[1].value.b],
        }
    }

    /// Overlay u, u̇, ü, u', (u')˙ and u'' where the shape functions are `shape`.
    #[inline(always)]
    pub fn overlay(&self, shape: &Hermite<T::Constant>) -> [SVector<T, D>; 6] {
        let d = &self.d;
        let g = self.length.v.recip() * 2.0;
        let slope = combine(&shape.dn, &d.value) * g;
        [
            combine(&shape.n, &d.value),
            combine(&shape.n, &d.rate),
            combine(&shape.n, &d.acceleration),
            slope,
            combine(&shape.dn, &d.rate) * g - slope * (self.length_rates[0] * g * 0.5),
            combine(&shape.ddn, &d.value) * (g * g),
        ]
    }
}
