//! A quantity with its derivatives with respect to Θ, or along a path.

use crate::scalar::Real;
use nalgebra::Vector2;
use std::ops::{Add, Mul};

/// A quantity and its first and second derivative at fixed η: with respect to Θ, or to the variable
/// of a [path](super::Path).
#[derive(Clone, Copy, Debug)]
pub struct Jet<T> {
    /// The quantity itself.
    pub v: T,
    /// ∂/∂Θ.
    pub d: T,
    /// ∂²/∂Θ².
    pub dd: T,
}

impl<V> Jet<V> {
    /// `f` of the quantity and of both derivatives, for a linear `f`.
    #[inline(always)]
    pub fn map<U>(self, f: impl Fn(V) -> U) -> Jet<U> {
        Jet {
            v: f(self.v),
            d: f(self.d),
            dd: f(self.dd),
        }
    }
}

impl<T: Real> Jet<T> {
    /// A constant.
    #[inline(always)]
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self {
            v: T::from(value),
            d: T::zero(),
            dd: T::zero(),
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
}

impl<V: Add<Output = V>> Jet<V> {
    /// `self` + `factor`·`other`.
    #[inline(always)]
    pub fn plus_scaled<F: Copy>(self, other: Self, factor: F) -> Self
    where
        V: Mul<F, Output = V>,
    {
        Self {
            v: self.v + other.v * factor,
            d: self.d + other.d * factor,
            dd: self.dd + other.dd * factor,
        }
    }
}

impl<T: Real> Jet<Vector2<T>> {
    /// O + ρ(−cos χ, sin χ) with χ(Θ), ρ(Θ).
    #[inline(always)]
    pub(super) fn polar(rho: Jet<T>, chi: Jet<T>) -> Self {
        let (sin, cos) = chi.v.sin_cos();
        let e = Vector2::new(-cos, sin);
        let t = Vector2::new(sin, cos);
        Self {
            v: e * rho.v,
            d: e * rho.d + t * (rho.v * chi.d),
            dd: e * (rho.dd - rho.v * chi.d * chi.d) + t * (rho.d * chi.d * 2.0 + rho.v * chi.dd),
        }
    }
}
