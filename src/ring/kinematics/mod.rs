//! Kinematics of the ALE ring on a mesh that moves with Θ (paper 3, eq. (10) to (12);
//! `docs/theory.md`, (3.1) to (3.3)), and its virtual power.
//!
//! Position r = R(ξ, Θ) + B q_f (10) with A_i = identity and cubic Hermite functions on elements
//! whose borders follow the arc borders. The deflection has D components: x and y, and in space w
//! along z = −b_ref. A dot is ∂/∂t at fixed η. The nodal degrees of freedom are the deflection `a`
//! and its slope `b` = ∂/∂ξ; the element uses d = (a₁, l b₁, a₂, l b₂), whose shape functions do
//! not depend on the element length l(Θ).

mod load;
mod motion;
mod point;

pub use load::{ElementLoad, LineLoad};
pub use motion::{ElementMotion, Hermite, Motion, Node, PointMotion, ReferenceMotion, WithRate, combine};
pub use point::{NodalUnknown, RingPoint, RingVariation};

use crate::scalar::{Real, turn_right};
use nalgebra::{SVector, Vector2};

/// Components in the plane of the drive.
#[inline(always)]
pub fn in_plane<T: Real, const D: usize>(v: &SVector<T, D>) -> Vector2<T> {
    Vector2::new(v[0], v[1])
}

/// A vector in the plane of the drive, extended to D components.
#[inline(always)]
pub fn embed<T: Real, const D: usize>(v: Vector2<T>) -> SVector<T, D> {
    SVector::from_fn(|i, _| if i < 2 { v[i] } else { T::zero() })
}

/// a × b in space.
#[inline(always)]
fn cross<T: Real, const D: usize>(a: &SVector<T, D>, b: &SVector<T, D>) -> SVector<T, D> {
    SVector::from_fn(|i, _| {
        let (j, k) = ((i + 1) % D, (i + 2) % D);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// Inward normal n̂ of a curve of D components in the plane of the drive, ⊥ to the unit tangent
/// `t`.
#[inline(always)]
pub fn inward_normal<T: Real, const D: usize>(t: &SVector<T, D>) -> SVector<T, D> {
    let n = turn_right(in_plane(t));
    embed(if D == 2 { n } else { n * n.dot(&n).sqrt().recip() })
}
