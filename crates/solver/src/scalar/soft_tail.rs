//! e^−x and ln(1 + e^−x) of packs. Half the work of the library's exponential and logarithm is for
//! numbers that don't occur here, and the soft positive part was a fifth of a run.

use super::real::Real;

/// ln 2 in two parts; the first has so few digits that its product with a small whole number is
/// exact.
const LN2: [f64; 2] = [0.693_145_751_953_125, 1.428_606_820_309_417_2e-6];

/// Adding it rounds a small number to a whole one, with an exponent's bias in the last bits.
const ROUND: f64 = 6_755_399_441_055_744.0 + 1023.0;

/// e^r on |r| ≤ ½ ln 2, highest power first: the polynomial of least error, 2.2e-16.
const EXP: [f64; 11] = [
    2.762_635_724_144_722_3e-7,
    2.764_018_079_620_985e-6,
    2.480_150_434_699_768_7e-5,
    1.984_117_027_027_044e-4,
    1.388_888_893_248_859_8e-3,
    8.333_333_385_667_782e-3,
    4.166_666_666_657_314e-2,
    1.666_666_666_655_444_7e-1,
    5.000_000_000_000_006e-1,
    1.000_000_000_000_006_7,
    1.0,
];

/// artanh(√u)/√u on 0 ≤ u ≤ 1/9, highest power first: the polynomial of least error, 5e-17.
const ARTANH: [f64; 10] = [
    8.890_381_913_056_651e-2,
    4.940_394_524_382_393e-2,
    6.795_652_742_789_947e-2,
    7.681_838_124_445_817e-2,
    9.091_429_900_236_956e-2,
    1.111_109_543_067_314_2e-1,
    1.428_571_455_582_858e-1,
    1.999_999_999_764_38e-1,
    3.333_333_333_334_129e-1,
    1.0,
];

/// e^−x, 1/(1 + e^−x) and ln(1 + e^−x).
pub(super) struct SoftTail<T> {
    pub exp: T,
    pub inverse: T,
    pub log: T,
}

/// For 0 ≤ x ≤ [`EXP_CUTOFF`](super::real::EXP_CUTOFF). `to_exponents` moves the last bits of each
/// number to its exponent.
#[inline(always)]
pub(super) fn soft_tail<T: Real>(x: T, to_exponents: impl Fn(T) -> T) -> SoftTail<T> {
    let shifted = x * -std::f64::consts::LOG2_E + ROUND;
    let whole = shifted - ROUND;
    let rest = -x - whole * LN2[0] - whole * LN2[1];
    let tail = polynomial(&EXP, rest) * to_exponents(shifted);
    // One division for both quotients.
    let (one, two) = (tail + 1.0, tail + 2.0);
    let inverse = (one * two).recip();
    let part = tail * one * inverse;
    SoftTail {
        exp: tail,
        inverse: two * inverse,
        log: polynomial(&ARTANH, part * part) * part * 2.0,
    }
}

/// Pairs of terms first, then pairs of pairs: fewer dependent operations than in Horner's order.
#[inline(always)]
fn polynomial<T: Real, const N: usize>(coefficients: &[f64; N], x: T) -> T {
    let term = |power: usize| coefficients[N - 1 - power];
    let pair = |low: usize| {
        if low + 1 < N {
            x * term(low + 1) + term(low)
        } else {
            T::from(term(low))
        }
    };
    let square = x * x;
    let fourth = square * square;
    let four = |low: usize| {
        if low + 2 < N {
            pair(low + 2) * square + pair(low)
        } else {
            pair(low)
        }
    };
    let mut sum = four(8);
    for low in [4, 0] {
        sum = sum * fourth + four(low);
    }
    sum
}

/// Moves the last bits of a number to its exponent.
#[inline(always)]
pub(super) fn to_exponent(shifted: f64) -> f64 {
    f64::from_bits(shifted.to_bits() << (f64::MANTISSA_DIGITS - 1))
}
