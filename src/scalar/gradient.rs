//! A number with N slopes: forward differentiation of what is computed one at a time.

use super::Real;
use num_traits::{One, Zero};
use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A number and its slopes in N directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient<const N: usize> {
    /// Value.
    pub re: f64,
    /// Slopes.
    pub eps: [f64; N],
}

impl<const N: usize> Gradient<N> {
    /// `value` with slope `slope` in `direction`; a constant if there is no such direction.
    #[inline(always)]
    #[must_use]
    pub fn seed(value: f64, direction: usize, slope: f64) -> Self {
        let mut eps = [0.0; N];
        if let Some(eps) = eps.get_mut(direction) {
            *eps = slope;
        }
        Self { re: value, eps }
    }

    /// The function with value `value` and derivative `slope` here.
    #[inline(always)]
    fn chain(&self, value: f64, slope: f64) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| self.eps[i] * slope),
        }
    }

    /// A function of two numbers with value `value` and derivatives `slope`, `other_slope` here.
    #[inline(always)]
    fn join(&self, other: &Self, value: f64, slope: f64, other_slope: f64) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| self.eps[i] * slope + other.eps[i] * other_slope),
        }
    }
}

impl<const N: usize> Real for Gradient<N> {
    type Constant = f64;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self {
            re: value,
            eps: [0.0; N],
        }
    }

    #[inline(always)]
    fn re(&self) -> f64 {
        self.re
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, 0.5 / root)
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
            self.chain(bend, -3.0 * self.re * bend / square),
        ]
    }
}

impl<const N: usize> From<f64> for Gradient<N> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl<const N: usize> Neg for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            re: -self.re,
            eps: self.eps.map(|a| -a),
        }
    }
}

impl<const N: usize> Add for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            re: self.re + other.re,
            eps: from_fn(|i| self.eps[i] + other.eps[i]),
        }
    }
}

impl<const N: usize> Sub for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            re: self.re - other.re,
            eps: from_fn(|i| self.eps[i] - other.eps[i]),
        }
    }
}

impl<const N: usize> Mul for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.join(&other, self.re * other.re, other.re, self.re)
    }
}

impl<const N: usize> Div for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let recip = other.re.recip();
        let value = self.re / other.re;
        self.join(&other, value, recip, -(value * recip))
    }
}

impl<const N: usize> Add<f64> for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: f64) -> Self {
        self.re += other;
        self
    }
}

impl<const N: usize> Sub<f64> for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: f64) -> Self {
        self.re -= other;
        self
    }
}

impl<const N: usize> Mul<f64> for Gradient<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.re * other, other)
    }
}

impl<const N: usize> AddAssign for Gradient<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> SubAssign for Gradient<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const N: usize> MulAssign for Gradient<N> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<const N: usize> Zero for Gradient<N> {
    #[inline(always)]
    fn zero() -> Self {
        Self::constant(0.0)
    }

    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl<const N: usize> One for Gradient<N> {
    #[inline(always)]
    fn one() -> Self {
        Self::constant(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Derivative;
    use num_dual::DualSVec64;

    /// Every operation against num-dual.
    #[test]
    fn agrees_with_num_dual() {
        fn law<T: Real>(a: T, b: T) -> T {
            let (sin, cos) = (a * 0.7 - b).sin_cos();
            let [plus, slope, bend] = (a * b - 0.3).smooth_plus(0.2);
            let mut sum = (sin + 2.0) * (cos + 3.0) / (a * a + 1.0) - plus * slope + bend;
            sum -= (b * b + 0.5).sqrt() + (a + 4.0).recip();
            sum *= -a;
            sum
        }
        let (x, y) = (0.9, 0.4);
        let found = law(Gradient::<2>::seed(x, 0, 1.0), Gradient::seed(y, 1, 1.0));
        let unit = |k: usize| Derivative::some(nalgebra::SVector::<f64, 2>::ith(k, 1.0));
        let expected = law(DualSVec64::new(x, unit(0)), DualSVec64::new(y, unit(1)));
        assert!((found.re - expected.re).abs() < 1e-14);
        for (found, expected) in found.eps.iter().zip(expected.eps.0.iter().flatten()) {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    }
}
