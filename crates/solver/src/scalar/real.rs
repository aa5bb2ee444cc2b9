//! What a scalar can do, and plain numbers as scalars.

use num_traits::{One, Zero};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// Largest x whose e^−x is evaluated; larger ones have the same value, which is nothing beside 1.
pub(super) const EXP_CUTOFF: f64 = 40.0;

/// A smoothed positive part with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositivePart<T> {
    /// ⟨x⟩₊.
    pub value: T,
    /// First derivative.
    pub slope: T,
    /// Second derivative.
    pub curvature: T,
}

/// A real number that may have derivatives.
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
    /// The same without derivatives. Mesh constants have this type: they differ between the cells
    /// of a pack.
    type Constant: Real<Constant = Self::Constant>;

    /// A number without derivatives.
    fn constant(value: Self::Constant) -> Self;

    /// The number without its derivatives.
    fn value(&self) -> Self::Constant;

    /// The plain number; of a pack, its first.
    fn re(&self) -> f64;

    /// The plain number in a lane of a pack.
    fn lane(&self, _lane: usize) -> f64 {
        self.re()
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

    /// ⟨x⟩₊ = ½(x + √(x² + δ²)); δ in the unit of x.
    #[must_use]
    fn smooth_plus(self, delta: f64) -> PositivePart<Self>;

    /// δ ln(1 + e^{x/δ}): a positive part whose tail falls off exponentially.
    #[must_use]
    fn soft_plus(self, delta: f64) -> PositivePart<Self>;

    /// `yes` where this is positive, else `no`, lane by lane.
    #[must_use]
    fn if_positive(self, yes: Self, no: Self) -> Self;
}

/// Functions that the standard library has.
macro_rules! standard {
    ($($function:ident)*) => {$(
        #[inline(always)]
        fn $function(self) -> Self {
            self.$function()
        }
    )*};
}

impl Real for f64 {
    type Constant = Self;

    standard!(sqrt recip ln);

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
    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }

    #[inline(always)]
    fn soft_plus(self, delta: f64) -> PositivePart<Self> {
        let tail = (-(self.abs() / delta).min(EXP_CUTOFF)).exp();
        let slope = (if self > 0.0 { 1.0 } else { tail }) / (1.0 + tail);
        PositivePart {
            value: self.max(0.0) + delta * tail.ln_1p(),
            slope,
            curvature: slope * (1.0 - slope) / delta,
        }
    }

    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        if self > 0.0 { yes } else { no }
    }

    #[inline(always)]
    fn smooth_plus(self, delta: f64) -> PositivePart<Self> {
        let square = delta * delta;
        let root = (self * self + square).sqrt();
        let sum = root + self.abs();
        // For x ≪ −δ the sum cancels; the quotient form keeps all digits.
        let value = if self > 0.0 { sum * 0.5 } else { (0.5 * square) / sum };
        PositivePart {
            value,
            slope: value / root,
            curvature: (0.5 * square) / (root * root * root),
        }
    }
}
