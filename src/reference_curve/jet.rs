//! A quantity with its derivatives with respect to Θ.

use crate::scalar::Real;
use num_dual::Dual3_64;
use std::ops::Mul;

/// A quantity and its first and second derivative with respect to Θ at fixed η.
#[derive(Clone, Copy, Debug)]
pub struct Jet<T> {
    /// The quantity itself.
    pub v: T,
    /// ∂/∂Θ.
    pub d: T,
    /// ∂²/∂Θ².
    pub dd: T,
}

impl<T: Real> Jet<T> {
    /// A constant.
    #[inline(always)]
    pub fn constant(value: f64) -> Self {
        Self {
            v: T::from(value),
            d: T::zero(),
            dd: T::zero(),
        }
    }

    /// Applies `f` to each.
    #[inline(always)]
    pub fn map<U>(self, f: impl Fn(T) -> U) -> Jet<U> {
        Jet {
            v: f(self.v),
            d: f(self.d),
            dd: f(self.dd),
        }
    }

    /// Lifts a third-order jet in Θ to the scalar `T` of Θ; `dtheta` = Θ − Re Θ carries the derivatives of Θ.
    #[inline(always)]
    pub fn lift(x: Dual3_64, dtheta: T) -> Self {
        Self {
            v: dtheta * x.v1 + x.re,
            d: dtheta * x.v2 + x.v1,
            dd: dtheta * x.v3 + x.v2,
        }
    }

    /// 1/x.
    #[inline(always)]
    pub fn recip(self) -> Self {
        let v = self.v.recip();
        let d = -(self.d * v * v);
        Self {
            v,
            d,
            dd: -(self.dd * v * v) - self.d * d * v * 2.0,
        }
    }

    /// `self`·`other`.
    #[inline(always)]
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self {
            v: self.v * other.v,
            d: self.d * other.v + self.v * other.d,
            dd: self.dd * other.v + self.d * other.d * 2.0 + self.v * other.dd,
        }
    }

    /// `factor`·`self`.
    #[inline(always)]
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            v: self.v * factor,
            d: self.d * factor,
            dd: self.dd * factor,
        }
    }

    /// `self` + `constant`.
    #[inline(always)]
    #[must_use]
    pub fn raised(self, constant: f64) -> Self {
        Self {
            v: self.v + constant,
            ..self
        }
    }

    /// `self` + `factor`·`other`.
    #[inline(always)]
    pub fn plus_scaled<F: Copy>(self, other: Self, factor: F) -> Self
    where
        T: Mul<F, Output = T>,
    {
        Self {
            v: self.v + other.v * factor,
            d: self.d + other.d * factor,
            dd: self.dd + other.dd * factor,
        }
    }

    /// `self` with `lane` replaced by that of `other`.
    #[must_use]
    pub fn with_lane(self, lane: usize, other: Self) -> Self {
        Self {
            v: self.v.with_lane(lane, other.v),
            d: self.d.with_lane(lane, other.d),
            dd: self.dd.with_lane(lane, other.dd),
        }
    }
}
