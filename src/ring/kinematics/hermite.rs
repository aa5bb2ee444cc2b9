//! Shape functions of an element.

use crate::scalar::Real;
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
