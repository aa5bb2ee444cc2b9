//! A fixed circle: the reference curve of a free or spinning ring. Θ has no effect.

use super::{Jet, ReferenceCurve, ReferencePoint};
use crate::scalar::Real;
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// Circle about the origin, starting at its leftmost point.
#[derive(Clone, Debug)]
pub struct Circle {
    /// Radius, m.
    pub radius: f64,
}

impl ReferenceCurve for Circle {
    type Frame<T: Real> = f64;

    fn length(&self) -> f64 {
        TAU * self.radius
    }

    fn segments(&self) -> usize {
        1
    }

    fn has_ratio(&self) -> bool {
        false
    }

    fn frame<T: Real>(&self, _theta: T) -> f64 {
        self.radius
    }

    fn segment_length<T: Real>(radius: &f64, _segment: usize) -> Jet<T> {
        Jet::constant(TAU * radius)
    }

    fn point<T: Real>(radius: &f64, _segment: usize, fraction: f64) -> ReferencePoint<T> {
        let (sin, cos) = (TAU * fraction).sin_cos();
        let vector = |x: f64, y: f64| Vector2::new(T::from(x), T::from(y));
        ReferencePoint {
            r: vector(-radius * cos, radius * sin),
            r_theta: vector(0.0, 0.0),
            r_theta2: vector(0.0, 0.0),
            t: vector(sin, cos),
            n: vector(cos, -sin),
            chi_theta: T::zero(),
            kappa: T::from(1.0 / radius),
            kappa_theta: T::zero(),
            xi: Jet::constant(TAU * radius * fraction),
        }
    }
}
