//! The smoothed positive part ⟨x⟩₊ of a number, and its integral.

use super::real::Real;

/// ⟨x⟩₊ = ½(x + √(x² + δ²)) and its slope; δ in the unit of x.
#[inline(always)]
pub fn smooth_plus<T: Real>(x: T, delta: f64) -> (T, T) {
    let [plus, slope, _] = x.smooth_plus(delta);
    (plus, slope)
}

/// ∫⟨x⟩₊ dx, zero at x = −`reach`.
#[inline(always)]
#[must_use]
pub fn smooth_plus_energy<T: Real>(x: T, delta: f64, reach: f64) -> T {
    let square = delta * delta;
    let plus = |x: f64| x.smooth_plus(delta)[0];
    let [here, ..] = x.smooth_plus(delta);
    // asinh(x/δ) + asinh(reach/δ), in one logarithm.
    let arsinh = (here * (4.0 * plus(reach) / square)).ln();
    (x * here + arsinh * (0.5 * square) + reach * plus(-reach)) * 0.5
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
