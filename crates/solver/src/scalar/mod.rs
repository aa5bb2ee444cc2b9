//! The scalar type that every law is generic over: a plain number, a pack of them, or either with
//! derivatives.

/// Zero, one and the operators that change a scalar in place, all by its conversion and its other
/// operators.
macro_rules! in_place {
    ([$($generic:tt)*] $type:ty) => {
        super::in_place!([$($generic)*] $type, AddAssign add_assign +);
        super::in_place!([$($generic)*] $type, SubAssign sub_assign -);
        super::in_place!([$($generic)*] $type, MulAssign mul_assign *);

        impl<$($generic)*> num_traits::Zero for $type {
            #[inline(always)]
            fn zero() -> Self {
                Self::from(0.0)
            }

            fn is_zero(&self) -> bool {
                *self == Self::zero()
            }
        }

        impl<$($generic)*> num_traits::One for $type {
            #[inline(always)]
            fn one() -> Self {
                Self::from(1.0)
            }
        }
    };
    ([$($generic:tt)*] $type:ty, $name:ident $method:ident $operator:tt) => {
        impl<$($generic)*> std::ops::$name for $type {
            #[inline(always)]
            fn $method(&mut self, other: Self) {
                *self = *self $operator other;
            }
        }
    };
}
use in_place;

mod lanes;
mod real;
mod smooth;
mod soft_tail;
mod tangent;

pub use lanes::{LANES, Lanes};
pub use real::{PositivePart, Real};
pub use smooth::{smooth_plus_energy, soft_plus_energy, soft_plus_energy_at};
pub use tangent::{Dual, Tangent, along};

use nalgebra::{SVector, Vector2};

/// The zero vector. nalgebra's `zeros` goes through an iterator and the stack, which costs a tenth
/// of a residual.
#[inline(always)]
#[must_use]
pub fn zero_vector<T: Real, const D: usize>() -> SVector<T, D> {
    SVector::from([T::zero(); D])
}

/// Inward normal of a clockwise curve: the tangent turned right.
#[inline(always)]
pub fn turn_right<T: Real>(t: Vector2<T>) -> Vector2<T> {
    Vector2::new(t.y, -t.x)
}
