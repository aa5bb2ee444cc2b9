//! Vectors of scalars.

use super::real::Real;
use nalgebra::{SVector, Vector2};

/// The zero vector. nalgebra's `zeros` goes through an iterator and the stack, which costs a tenth of a residual.
#[inline(always)]
pub fn zero_vector<T: Real, const D: usize>() -> SVector<T, D> {
    SVector::from([T::zero(); D])
}

/// Inward normal of a clockwise curve: the tangent turned right.
#[inline(always)]
pub fn turn_right<T: Real>(t: Vector2<T>) -> Vector2<T> {
    Vector2::new(t.y, -t.x)
}
