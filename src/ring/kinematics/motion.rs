//! Shape functions, and the motion of nodes, of elements and of the reference degrees of freedom.

use crate::reference_curve::Jet;
use crate::scalar::{Real, zero_vector};
use nalgebra::SVector;
use std::ops::Mul;

/// Cubic Hermite functions of the element at a local coordinate x ∈ [−1, 1] (paper 5.2), and their x derivatives.
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
    pub fn at(x: L) -> Self {
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

/// Σ weights·d. The weights are mesh constants or, where the mesh moves past a fixed place, of the type of d.
#[inline(always)]
pub fn combine<T: Real + Mul<W, Output = T>, W: Copy, const D: usize>(
    weights: &[W; 4],
    d: &[SVector<T, D>; 4],
) -> SVector<T, D> {
    SVector::from_fn(|i, _| d[0][i] * weights[0] + d[1][i] * weights[1] + d[2][i] * weights[2] + d[3][i] * weights[3])
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

/// Motion of an element: its length, and its overlay in the length-free coordinates d. `ALE0` has no overlay.
#[derive(Clone, Copy, Debug)]
pub struct ElementMotion<T: Real, const D: usize = 2> {
    /// Element length l(Θ), m.
    pub length: Jet<T>,
    /// Deflection from the reference curve; none where the ring follows it.
    pub(super) overlay: Option<Overlay<T, D>>,
}

/// The overlay of an element in the coordinates d.
#[derive(Clone, Copy, Debug)]
pub(super) struct Overlay<T: Real, const D: usize> {
    pub(super) d: [SVector<T, D>; 4],
    pub(super) rate: [SVector<T, D>; 4],
    pub(super) acceleration: [SVector<T, D>; 4],
    /// Slopes b of the two nodes.
    pub(super) slope: [SVector<T, D>; 2],
}

impl<T: Real, const D: usize> ElementMotion<T, D> {
    /// An element without deflection.
    #[inline(always)]
    pub fn rigid(length: Jet<T>) -> Self {
        Self { length, overlay: None }
    }

    /// An element between two nodes.
    #[inline(always)]
    pub fn flexible(length: Jet<T>, theta: &Motion<T>, nodes: &[Motion<Node<T, D>>; 2]) -> Self {
        let l = length.v;
        let l_dot = length.d * theta.rate;
        let l_ddot = length.dd * theta.rate * theta.rate + length.d * theta.acceleration;
        let mut overlay = Overlay {
            d: [zero_vector(); 4],
            rate: [zero_vector(); 4],
            acceleration: [zero_vector(); 4],
            slope: [nodes[0].value.b, nodes[1].value.b],
        };
        for (i, node) in nodes.iter().enumerate() {
            let (b, b_dot) = (node.value.b, node.rate.b);
            overlay.d[2 * i] = node.value.a;
            overlay.d[2 * i + 1] = b * l;
            overlay.rate[2 * i] = node.rate.a;
            overlay.rate[2 * i + 1] = b_dot * l + b * l_dot;
            overlay.acceleration[2 * i] = node.acceleration.a;
            overlay.acceleration[2 * i + 1] = node.acceleration.b * l + b_dot * (l_dot * 2.0) + b * l_ddot;
        }
        Self {
            length,
            overlay: Some(overlay),
        }
    }
}
