//! The scalar type that every law is generic over: a plain number, a pack of them, or either with derivatives.

#![forbid(unsafe_code)]

mod lanes;
mod tangent;

pub use lanes::{LANES, Lanes};
pub use tangent::Tangent;

use nalgebra::{SVector, Vector2};
use num_dual::{Dual3_64, Dual64, DualNum, DualSVec64};
use num_traits::{One, Zero};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number that may carry derivatives along.
pub trait Real:
    Copy
    + std::fmt::Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Zero
    + One
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Mul<<Self as Real>::Constant, Output = Self>
{
    /// The same without derivatives. Mesh constants have this type: they differ between the cells of a pack.
    type Constant: Real<Constant = Self::Constant>;

    /// A number without derivatives.
    fn constant(value: Self::Constant) -> Self;

    /// The number without its derivatives.
    fn value(&self) -> Self::Constant;

    /// The plain number; of a pack, its first.
    fn re(&self) -> f64;

    /// Numbers in a pack.
    const WIDTH: usize = 1;

    /// The plain number in a lane of a pack.
    fn lane(&self, _lane: usize) -> f64 {
        self.re()
    }

    /// The pack whose `lane` is that of `other`.
    #[must_use]
    fn with_lane(self, _lane: usize, other: Self) -> Self {
        other
    }

    /// √x.
    #[must_use]
    fn sqrt(self) -> Self;

    /// 1/x.
    #[must_use]
    fn recip(self) -> Self;

    /// √x and 1/√x. The division doesn't wait for the root.
    #[inline(always)]
    #[must_use]
    fn root_and_inverse(self) -> (Self, Self) {
        let root = self.sqrt();
        (root, root * self.recip())
    }

    /// (sin x, cos x).
    #[must_use]
    fn sin_cos(self) -> (Self, Self);

    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self;

    /// ⟨x⟩₊ = ½(x + √(x² + δ²)), its slope and its second derivative.
    #[must_use]
    fn smooth_plus(self, delta: f64) -> [Self; 3];
}

impl Real for f64 {
    type Constant = Self;

    #[inline(always)]
    fn constant(value: Self) -> Self {
        value
    }

    #[inline(always)]
    fn value(&self) -> Self {
        *self
    }

    #[inline(always)]
    fn re(&self) -> f64 {
        *self
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn recip(self) -> Self {
        self.recip()
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.ln()
    }

    #[inline(always)]
    fn smooth_plus(self, delta: f64) -> [Self; 3] {
        let square = delta * delta;
        let root = (self * self + square).sqrt();
        let sum = root + self.abs();
        // For x ≪ −δ the sum cancels; the quotient form keeps all digits.
        let plus = if self > 0.0 { sum * 0.5 } else { (0.5 * square) / sum };
        [plus, plus / root, (0.5 * square) / (root * root * root)]
    }
}

/// num-dual's numbers are [`Real`] too: they check [`Tangent`].
macro_rules! real_by_num_dual {
    ([$($generic:tt)*] $type:ty) => {
        impl<$($generic)*> Real for $type {
            type Constant = f64;

            fn constant(value: f64) -> Self {
                Self::from_re(value)
            }

            fn value(&self) -> f64 {
                self.re
            }

            fn re(&self) -> f64 {
                self.re
            }

            fn sqrt(self) -> Self {
                DualNum::sqrt(&self)
            }

            fn recip(self) -> Self {
                DualNum::recip(&self)
            }

            fn sin_cos(self) -> (Self, Self) {
                DualNum::sin_cos(&self)
            }

            fn ln(self) -> Self {
                DualNum::ln(&self)
            }

            fn smooth_plus(self, delta: f64) -> [Self; 3] {
                let square = delta * delta;
                let root = DualNum::sqrt(&(self * self + square));
                let plus = if self.re > 0.0 {
                    (self + root) * 0.5
                } else {
                    DualNum::recip(&(root - self)) * (0.5 * square)
                };
                [plus, plus / root, DualNum::recip(&(root * root * root)) * (0.5 * square)]
            }
        }
    };
}
real_by_num_dual!([] Dual64);
real_by_num_dual!([] Dual3_64);
real_by_num_dual!([const N: usize] DualSVec64<N>);

/// ⟨x⟩₊ = ½(x + √(x² + δ²)) and its slope; δ in the unit of x.
#[inline(always)]
pub fn smooth_plus<T: Real>(x: T, delta: f64) -> (T, T) {
    let [plus, slope, _] = x.smooth_plus(delta);
    (plus, slope)
}

/// ∫⟨x⟩₊ dx, zero at x = −`reach`.
#[inline(always)]
#[must_use]
pub fn smooth_plus_energy<T: Real>(x: T, delta: f64, reach: f64) -> T {
    let square = delta * delta;
    let plus = |x: f64| x.smooth_plus(delta)[0];
    let [here, ..] = x.smooth_plus(delta);
    // asinh(x/δ) + asinh(reach/δ), in one logarithm.
    let arsinh = (here * (4.0 * plus(reach) / square)).ln();
    (x * here + arsinh * (0.5 * square) + reach * plus(-reach)) * 0.5
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    #[test]
    fn smooth_plus_has_the_slope_that_differentiation_finds() {
        for x in [-30.0, -1.0, -1e-3, 0.0, 1e-3, 1.0, 30.0] {
            let (value, slope) = smooth_plus(Dual64::new(x, 1.0), 0.5);
            assert!((value.eps - slope.re).abs() < 1e-14, "x = {x}");
            assert!(value.re > 0.0);
        }
    }

    #[test]
    fn energy_is_the_integral() {
        let (delta, h) = (0.3, 1e-4);
        for x in [-2.0, -0.1, 0.0, 0.2, 3.0] {
            let slope = (smooth_plus_energy(x + h, delta, 5.0) - smooth_plus_energy(x - h, delta, 5.0)) / (2.0 * h);
            assert!((slope - smooth_plus(x, delta).0).abs() < 1e-8);
        }
    }
}
