//! Packed numbers with N slopes: forward differentiation.

use super::{Lanes, Real};
use num_traits::{One, Zero};
use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// Numbers and their slopes in N directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent<const N: usize> {
    /// Value.
    pub re: Lanes,
    /// Slopes.
    pub eps: [Lanes; N],
}

impl<const N: usize> Tangent<N> {
    /// `value` with slope `slope` in `direction`; a constant if there is no such direction.
    #[inline(always)]
    #[must_use]
    pub fn seed(value: Lanes, direction: usize, slope: f64) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| Lanes::from(if i == direction { slope } else { 0.0 })),
        }
    }

    /// The function with value `value` and derivative `slope` here.
    #[inline(always)]
    fn chain(&self, value: Lanes, slope: Lanes) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| self.eps[i] * slope),
        }
    }

    /// A function of two numbers with value `value` and derivatives `slope`, `other_slope` here.
    #[inline(always)]
    fn join(&self, other: &Self, value: Lanes, slope: Lanes, other_slope: Lanes) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| self.eps[i] * slope + other.eps[i] * other_slope),
        }
    }
}

impl<const N: usize> Real for Tangent<N> {
    type Constant = Lanes;

    #[inline(always)]
    fn constant(value: Lanes) -> Self {
        Self {
            re: value,
            eps: [Lanes::zero(); N],
        }
    }

    #[inline(always)]
    fn re(&self) -> f64 {
        self.re.re()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, Lanes::from(0.5) / root)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let recip = self.re.recip();
        self.chain(recip, -(recip * recip))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    #[inline(always)]
    fn smooth_plus(self, delta: f64) -> [Self; 3] {
        let [plus, slope, bend] = self.re.smooth_plus(delta);
        let square = self.re * self.re + delta * delta;
        [
            self.chain(plus, slope),
            self.chain(slope, bend),
            self.chain(bend, self.re * bend * (-3.0) / square),
        ]
    }
}

impl<const N: usize> From<f64> for Tangent<N> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::constant(Lanes::from(value))
    }
}

impl<const N: usize> Neg for Tangent<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            re: -self.re,
            eps: self.eps.map(|a| -a),
        }
    }
}

impl<const N: usize> Add for Tangent<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            eps: from_fn(|i| self.eps[i] + other.eps[i]),
        }
    }
}

impl<const N: usize> Sub for Tangent<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            eps: from_fn(|i| self.eps[i] - other.eps[i]),
        }
    }
}

impl<const N: usize> Mul for Tangent<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.join(&other, self.re * other.re, other.re, self.re)
    }
}

impl<const N: usize> Div for Tangent<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let recip = other.re.recip();
        let value = self.re / other.re;
        self.join(&other, value, recip, -(value * recip))
    }
}

macro_rules! with_constants {
    ($constant:ty) => {
        impl<const N: usize> Add<$constant> for Tangent<N> {
            type Output = Self;
            #[inline(always)]
            fn add(mut self, other: $constant) -> Self {
                self.re += Lanes::from(other);
                self
            }
        }

        impl<const N: usize> Sub<$constant> for Tangent<N> {
            type Output = Self;
            #[inline(always)]
            fn sub(mut self, other: $constant) -> Self {
                self.re -= Lanes::from(other);
                self
            }
        }

        impl<const N: usize> Mul<$constant> for Tangent<N> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: $constant) -> Self {
                self.chain(self.re * other, Lanes::from(other))
            }
        }
    };
}
with_constants!(f64);
with_constants!(Lanes);

impl<const N: usize> AddAssign for Tangent<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> SubAssign for Tangent<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const N: usize> MulAssign for Tangent<N> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<const N: usize> Zero for Tangent<N> {
    #[inline(always)]
    fn zero() -> Self {
        Self::constant(Lanes::zero())
    }

    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl<const N: usize> One for Tangent<N> {
    #[inline(always)]
    fn one() -> Self {
        Self::constant(Lanes::one())
    }
}
