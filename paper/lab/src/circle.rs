//! A fixed circle, the reference curve of a free or spinning ring. It does not depend on Θ.

use nalgebra::Vector2;
use pushbelt::scalar::Real;
use pushbelt_paper::reference_curve::{Jet, ReferenceCurve, ReferencePoint, TangentAngle};
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

    fn frame<T: Real>(&self, _theta: T) -> f64 {
        self.radius
    }

    fn segment_length<T: Real>(radius: &f64, _segment: usize) -> Jet<T> {
        Jet::constant(TAU * radius)
    }

    fn point<T: Real>(radius: &f64, _segment: usize, fraction: T::Constant) -> ReferencePoint<T> {
        let (sin, cos) = T::constant(fraction * TAU).sin_cos();
        let zero = Vector2::new(T::zero(), T::zero());
        ReferencePoint {
            r: Vector2::new(-cos * *radius, sin * *radius),
            r_theta: zero,
            r_theta2: zero,
            t: Vector2::new(sin, cos),
            n: Vector2::new(cos, -sin),
            chi_theta: T::zero(),
            kappa: T::from(1.0 / radius),
            kappa_theta: T::zero(),
            xi: Jet {
                v: T::constant(fraction * (TAU * radius)),
                ..Jet::constant(0.0)
            },
        }
    }

    fn has_ratio(&self) -> bool {
        false
    }

    fn tangent_angle<T: Real>(radius: &f64, _segment: usize, fraction: T::Constant) -> TangentAngle<T> {
        TangentAngle {
            chi: Jet {
                v: T::constant(fraction * TAU),
                ..Jet::constant(0.0)
            },
            kappa: Jet::constant(1.0 / radius),
        }
    }
}
