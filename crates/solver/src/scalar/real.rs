//! What a scalar can do, and plain numbers as scalars.

use num_dual::{Dual64, DualNum, DualSVec64};
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

    /// Angle of the point (`x`, `self`) against the first axis, −π to π. At the origin it has no derivatives.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self;

    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;

    /// ⟨x⟩₊ = ½(x + √(x² + δ²)), its slope and its second derivative.
    #[must_use]
    fn smooth_plus(self, delta: f64) -> [Self; 3];

    /// δ ln(1 + e^{x/δ}), its slope and its second derivative: a positive part whose tail falls off exponentially.
    #[must_use]
    fn soft_plus(self, delta: f64) -> [Self; 3];

    /// `yes` where this is positive, else `no`, lane by lane.
    #[must_use]
    fn if_positive(self, yes: Self, no: Self) -> Self;
}

/// Largest x/δ of which the exponential is taken: e^−x is nothing beside 1 long before, and not yet zero.
pub(super) const MOST: f64 = 600.0;

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
    fn atan2(self, x: Self) -> Self {
        self.atan2(x)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.ln()
    }

    #[inline(always)]
    fn exp(self) -> Self {
        self.exp()
    }

    #[inline(always)]
    fn soft_plus(self, delta: f64) -> [Self; 3] {
        let tail = (-(self.abs() / delta).min(MOST)).exp();
        let slope = (if self > 0.0 { 1.0 } else { tail }) / (1.0 + tail);
        let plus = self.max(0.0) + delta * tail.ln_1p();
        [plus, slope, slope * (1.0 - slope) / delta]
    }

    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        if self > 0.0 { yes } else { no }
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

/// num-dual's numbers are [`Real`] too: they check derivatives.
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

            fn atan2(self, x: Self) -> Self {
                DualNum::atan2(&self, x)
            }

            fn ln(self) -> Self {
                DualNum::ln(&self)
            }

            fn exp(self) -> Self {
                DualNum::exp(&self)
            }

            fn soft_plus(self, delta: f64) -> [Self; 3] {
                let above = self.re > 0.0;
                let size = if above { -self } else { self };
                let tail = if size.re < -MOST * delta {
                    Self::from_re((-MOST).exp())
                } else {
                    DualNum::exp(&(size * delta.recip()))
                };
                let whole = DualNum::recip(&(tail + 1.0));
                let slope = if above { whole } else { tail * whole };
                let plus = DualNum::ln_1p(&tail) * delta + if above { self } else { Self::from_re(0.0) };
                [plus, slope, slope * (-slope + 1.0) * delta.recip()]
            }

            fn if_positive(self, yes: Self, no: Self) -> Self {
                if self.re > 0.0 { yes } else { no }
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
real_by_num_dual!([const N: usize] DualSVec64<N>);
