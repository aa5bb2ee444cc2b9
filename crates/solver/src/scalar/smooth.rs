//! Smoothed positive parts ⟨x⟩₊ of a number, and their integrals.

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

/// ∫ δ ln(1 + e^{x/δ}) dx from −∞, a dilogarithm.
#[inline(always)]
#[must_use]
pub fn soft_plus_energy<T: Real>(x: T, delta: f64) -> T {
    let [plus, ..] = x.soft_plus(delta);
    soft_plus_energy_at(x, plus, delta)
}

/// The same where the positive part `plus` = δ ln(1 + e^{x/δ}) is known.
#[inline(always)]
pub fn soft_plus_energy_at<T: Real>(x: T, plus: T, delta: f64) -> T {
    // −Li₂(−z) in powers of l = ln(1 + z) ≤ ln 2; the coefficients are B_n/(n + 1)!. The next term is below 1e-14.
    let of_log = |l: T| {
        let square = l * l;
        let odd = [
            -4.064_761_645_144_226e-11,
            1.0 / 526_901_760.0,
            -1.0 / 10_886_400.0,
            1.0 / 211_680.0,
            -1.0 / 3600.0,
        ]
        .into_iter()
        .fold(T::zero(), |sum, coefficient| sum * square + T::from(coefficient))
            * square
            + 1.0 / 36.0;
        l + square * 0.25 + odd * square * l
    };
    // δ ln(1 + e^{−|x|/δ}).
    let tail = x.if_positive(plus - x, plus);
    let scaled = 1.0 / delta;
    let part = of_log(tail * scaled);
    let above = -part + x * x * (0.5 * scaled * scaled) + std::f64::consts::PI.powi(2) / 6.0;
    x.if_positive(above, part) * (delta * delta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::{LANES, Lanes};
    use num_dual::Dual64;

    #[test]
    fn soft_plus_is_the_slope_of_its_energy_and_has_its_own() {
        let (delta, h) = (0.3, 1e-4);
        for x in [-9.0, -2.0, -0.1, 0.0, 0.2, 3.0, 40.0] {
            let slope = (soft_plus_energy(x + h, delta) - soft_plus_energy(x - h, delta)) / (2.0 * h);
            let [plus, ..] = x.soft_plus(delta);
            assert!((slope - plus).abs() < 1e-8 * (1.0 + x.abs()), "{x}: {slope} {plus}");
            let [value, slope, bend] = Dual64::new(x, 1.0).soft_plus(delta);
            assert!((value.eps - slope.re).abs() < 1e-14);
            assert!((slope.eps - bend.re).abs() < 1e-13);
            for (found, expected) in x.soft_plus(delta).into_iter().zip([value, slope, bend]) {
                assert!((found - expected.re).abs() < 1e-14 * (1.0 + x.abs()));
            }
        }
    }

    #[test]
    fn packs_agree_with_numbers() {
        for x in [-1e4, -50.0, -3.0, -0.2, 0.0, 1e-3, 0.4, 7.0, 1e4] {
            let pack = Lanes::new([x; LANES]).soft_plus(0.3);
            for (pack, number) in pack.into_iter().zip(x.soft_plus(0.3)) {
                assert!((pack.lane(0) - number).abs() < 1e-14 * (1.0 + number.abs()), "{x}");
            }
            let energy = soft_plus_energy(Lanes::from(x), 0.3).lane(0);
            let number = soft_plus_energy(x, 0.3);
            assert!(
                (energy - number).abs() < 1e-13 * (1.0 + number.abs()),
                "{x}: {energy} {number}"
            );
        }
    }

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
