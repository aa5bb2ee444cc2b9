//! Reference curves (paper 2, 3.1, 5.1): a closed planar curve r(ξ, Θ) of fixed length L that changes with one ratio
//! coordinate Θ, cut into segments on which it is smooth.
//!
//! A mesh point η is a segment and a fraction f ∈ [0, 1] of it; ξ(η, Θ) moves with Θ while the point stays on its own
//! arc or strand. Derivatives with respect to Θ are taken at fixed η. The curve runs clockwise: tangent
//! t = (sin χ, cos χ), inward normal n = (cos χ, −sin χ), turning angle χ growing, t' = κ n, n' = −κ t.

#![forbid(unsafe_code)]

mod circle;
mod drive;
mod two_pulley;
mod unaligned;

pub use circle::Circle;
pub use drive::{Drive, DriveError, DriveFrame, Pulley, Tensioner};
pub use two_pulley::{GeometryError, TwoPulley, TwoPulleyFrame, TwoPulleyShape, ratio_of_theta};
pub use unaligned::{Unaligned, UnalignedFrame};

use crate::scalar::Real;
use nalgebra::Vector2;
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
}

/// The reference curve at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct ReferencePoint<T: Real> {
    /// Position, m.
    pub r: Vector2<T>,
    /// ∂r/∂Θ at fixed η, m.
    pub r_theta: Vector2<T>,
    /// ∂²r/∂Θ² at fixed η, m.
    pub r_theta2: Vector2<T>,
    /// Unit tangent, = r'.
    pub t: Vector2<T>,
    /// Unit inward normal.
    pub n: Vector2<T>,
    /// ∂χ/∂Θ at fixed η, rad.
    pub chi_theta: T,
    /// Curvature κ, 1/m.
    pub kappa: T,
    /// ∂κ/∂Θ at fixed η, 1/m.
    pub kappa_theta: T,
    /// Place ξ(η, Θ) on the curve, m.
    pub xi: Jet<T>,
}

impl<T: Real> Jet<T> {
    /// The pack whose `lane` is that of `other`.
    fn with_lane(self, lane: usize, other: Self) -> Self {
        Self {
            v: self.v.with_lane(lane, other.v),
            d: self.d.with_lane(lane, other.d),
            dd: self.dd.with_lane(lane, other.dd),
        }
    }
}

impl<T: Real> ReferencePoint<T> {
    /// The pack whose `lane` is that of `other`.
    fn with_lane(self, lane: usize, other: Self) -> Self {
        let vector = |a: Vector2<T>, b: Vector2<T>| a.zip_map(&b, |a, b| a.with_lane(lane, b));
        Self {
            r: vector(self.r, other.r),
            r_theta: vector(self.r_theta, other.r_theta),
            r_theta2: vector(self.r_theta2, other.r_theta2),
            t: vector(self.t, other.t),
            n: vector(self.n, other.n),
            chi_theta: self.chi_theta.with_lane(lane, other.chi_theta),
            kappa: self.kappa.with_lane(lane, other.kappa),
            kappa_theta: self.kappa_theta.with_lane(lane, other.kappa_theta),
            xi: self.xi.with_lane(lane, other.xi),
        }
    }
}

/// How the tangent of the reference curve turns with Θ.
#[derive(Clone, Copy, Debug)]
pub struct Turning<T> {
    /// Turning angle χ at fixed η, rad.
    pub chi: Jet<T>,
    /// Curvature κ at fixed η, 1/m.
    pub kappa: Jet<T>,
}

impl<T: Real> Turning<T> {
    /// The pack whose `lane` is that of `other`.
    fn with_lane(self, lane: usize, other: Self) -> Self {
        Self {
            chi: self.chi.with_lane(lane, other.chi),
            kappa: self.kappa.with_lane(lane, other.kappa),
        }
    }
}

/// A closed curve with one ratio coordinate. Another belt system is another implementation (paper section 7).
pub trait ReferenceCurve: Clone + Send + 'static {
    /// Everything that depends on Θ alone, computed once for all mesh points.
    type Frame<T: Real>: Clone;

    /// Length L of the curve, the same for every Θ, m.
    fn length(&self) -> f64;

    /// How many segments the curve has.
    fn segments(&self) -> usize;

    /// Whether Θ changes the curve at all. If not, it is no degree of freedom.
    fn has_ratio(&self) -> bool {
        true
    }

    /// Geometry at Θ. Outside the admissible range of Θ the frame holds NaN.
    fn frame<T: Real>(&self, theta: T) -> Self::Frame<T>;

    /// Length of a segment, m.
    fn segment_length<T: Real>(frame: &Self::Frame<T>, segment: usize) -> Jet<T>;

    /// The curve at fraction `fraction` of `segment`.
    fn point<T: Real>(frame: &Self::Frame<T>, segment: usize, fraction: T::Constant) -> ReferencePoint<T>;

    /// Turning angle and curvature there with two derivatives.
    fn turning<T: Real>(frame: &Self::Frame<T>, segment: usize, fraction: T::Constant) -> Turning<T>;

    /// Segment and fraction at the place ξ, m, taken around the loop.
    fn locate(&self, frame: &Self::Frame<f64>, xi: f64) -> (usize, f64) {
        let mut rest = xi.rem_euclid(self.length());
        let last = self.segments() - 1;
        for segment in 0..last {
            let length = Self::segment_length(frame, segment).v;
            if rest < length {
                return (segment, rest / length);
            }
            rest -= length;
        }
        (last, (rest / Self::segment_length(frame, last).v).min(1.0))
    }

    /// The curve at the place ξ, m, taken around the loop.
    fn at(&self, frame: &Self::Frame<f64>, xi: f64) -> ReferencePoint<f64> {
        let (segment, fraction) = self.locate(frame, xi);
        Self::point(frame, segment, fraction)
    }
}
