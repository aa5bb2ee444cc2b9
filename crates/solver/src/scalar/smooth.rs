//! Smoothed positive parts ⟨x⟩₊ of a number, and their integrals.

use super::real::Real;

/// ∫⟨x⟩₊ dx, zero at x = −`reach`.
#[inline(always)]
#[must_use]
pub fn smooth_plus_energy<T: Real>(x: T, delta: f64, reach: f64) -> T {
    let square = delta * delta;
    let plus = |x: f64| x.smooth_plus(delta).value;
    let here = x.smooth_plus(delta).value;
    // asinh(x/δ) + asinh(reach/δ), in one logarithm.
    let arsinh = (here * (4.0 * plus(reach) / square)).ln();
    (x * here + arsinh * (0.5 * square) + reach * plus(-reach)) * 0.5
}

/// ∫ δ ln(1 + e^{x/δ}) dx from −∞, a dilogarithm.
#[inline(always)]
#[must_use]
pub fn soft_plus_energy<T: Real>(x: T, delta: f64) -> T {
    soft_plus_energy_at(x, x.soft_plus(delta).value, delta)
}

/// The same where the positive part `plus` = δ ln(1 + e^{x/δ}) is known.
#[inline(always)]
pub fn soft_plus_energy_at<T: Real>(x: T, plus: T, delta: f64) -> T {
    // Its slope is the positive part, which need not be differentiated.
    let (at, slope) = (x.value(), plus.value());
    T::constant(plain_energy(at, slope, delta)) + (x - T::constant(at)) * slope
}

#[inline(always)]
fn plain_energy<T: Real>(x: T, plus: T, delta: f64) -> T {
    // −Li₂(−z) in powers of l = ln(1 + z) ≤ ln 2; the coefficients are B_n/(n + 1)!. The next term
    // is below 1e-14.
    let series = |l: T| {
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
    let part = series(tail * scaled);
    let above = -part + x * x * (0.5 * scaled * scaled) + std::f64::consts::PI.powi(2) / 6.0;
    x.if_positive(above, part) * (delta * delta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::{Dual, LANES, Lanes, PositivePart};

    /// A positive part is the slope of its energy, and has its own slopes.
    #[test]
    fn slopes_are_those_of_differences() {
        let h = 1e-5;
        type Law = (fn(f64) -> f64, fn(Dual) -> PositivePart<Dual>);
        let laws: [Law; 2] = [
            (|x| soft_plus_energy(x, 0.3), |x| x.soft_plus(0.3)),
            (|x| smooth_plus_energy(x, 0.3, 5.0), |x| x.smooth_plus(0.3)),
        ];
        for (energy, law) in laws {
            for x in [-9.0, -2.0, -0.1, 0.0, 0.2, 3.0, 40.0] {
                let PositivePart {
                    value,
                    slope,
                    curvature,
                } = law(Dual::seed(x, 0, 1.0));
                let [before, after] = [x - h, x + h].map(|x| law(x.into()));
                let differences = [
                    energy(x + h) - energy(x - h),
                    after.value.re - before.value.re,
                    after.slope.re - before.slope.re,
                    after.curvature.re - before.curvature.re,
                ]
                .map(|difference| difference / (2.0 * h));
                let slopes = [value.re, value.eps[0], slope.eps[0], curvature.eps[0]];
                for ((slope, difference), error) in
                    slopes.into_iter().zip(differences).zip([1e-8, 1e-8, 1e-8, 1e-7])
                {
                    let off = (slope - difference).abs();
                    assert!(off < error * (1.0 + x.abs()), "{x}: {slope} {difference}");
                }
                assert!(value.re > 0.0);
            }
        }
    }

    #[test]
    fn packs_agree_with_numbers() {
        for x in [-1e4, -50.0, -3.0, -0.2, 0.0, 1e-3, 0.4, 7.0, 1e4] {
            let pack = Lanes::new([x; LANES]);
            let soft = (pack.soft_plus(0.3), x.soft_plus(0.3));
            let smooth = (pack.smooth_plus(0.3), x.smooth_plus(0.3));
            let energies = (soft_plus_energy(pack, 0.3), soft_plus_energy(x, 0.3));
            let values = [soft, smooth].map(|(pack, number)| {
                [
                    (pack.value, number.value),
                    (pack.slope, number.slope),
                    (pack.curvature, number.curvature),
                ]
            });
            for (pack, number) in values.into_iter().flatten().chain([energies]) {
                let pack = pack.lane(0);
                assert!(
                    (pack - number).abs() < 1e-13 * (1.0 + number.abs()),
                    "{x}: {pack} {number}"
                );
            }
        }
    }

    /// Where the tail counts, its relative error is a few roundings.
    #[test]
    fn tails_of_packs_are_those_of_the_library() {
        for k in 0..400 {
            let x = f64::from(k) / 10.0;
            let part = Lanes::from(-x).soft_plus(1.0);
            let tail = (-x).exp();
            for (found, exact) in [(part.value, tail.ln_1p()), (part.slope, tail / (1.0 + tail))] {
                let found = found.lane(0);
                assert!((found / exact - 1.0).abs() < 2e-15, "{x}: {found} {exact}");
            }
        }
    }
}
