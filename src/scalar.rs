//! The scalar type that every law is generic over: `f64` for values, a dual number for exact derivatives.

use nalgebra::Vector2;
use num_dual::DualNum;

/// A real number that may carry derivatives along.
pub trait Real: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Real for T {}

/// Constant without derivatives.
#[inline]
pub fn real<T: Real>(value: f64) -> T {
    T::from(value)
}

/// ⟨x⟩₊ = ½(x + √(x² + δ²)) and its slope; δ in the unit of x.
#[inline]
pub fn smooth_plus<T: Real>(x: T, delta: f64) -> (T, T) {
    let root = (x * x + delta * delta).sqrt();
    // For x ≪ −δ the sum cancels; the quotient form keeps all digits.
    let plus = if x.re() > 0.0 {
        (x + root) * 0.5
    } else {
        (root - x).recip() * (0.5 * delta * delta)
    };
    (plus, plus / root)
}

/// ∫⟨x⟩₊ dx, zero at x = −`reach`.
#[must_use]
pub fn smooth_plus_energy(x: f64, delta: f64, reach: f64) -> f64 {
    let primitive = |x: f64| {
        let root = x.hypot(delta);
        let product = if x > 0.0 {
            x * (x + root)
        } else {
            x * delta * delta / (root - x)
        };
        0.25 * (product + delta * delta * (x / delta).asinh())
    };
    primitive(x) - primitive(-reach)
}

/// Inward normal of a clockwise curve: the tangent turned right.
#[inline]
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
