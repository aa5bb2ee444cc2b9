//! A pack of numbers that are computed alike: one cell of the belt in each lane.

use super::real::{EXP_CUTOFF, PositivePart, Real};
use super::soft_tail::{SoftTail, soft_tail, to_exponent};
use num_traits::{One, Zero};
use std::ops::{Add, Div, Mul, Neg, Sub};
#[cfg(not(target_feature = "avx"))]
use wide::f64x2 as Pack;
#[cfg(target_feature = "avx")]
use wide::f64x4 as Pack;

/// Numbers in a [`Lanes`]: as many as a register of the target processor holds.
pub const LANES: usize = if cfg!(target_feature = "avx") { 4 } else { 2 };

/// [`LANES`] numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lanes(Pack);

impl Lanes {
    /// A pack of the given numbers.
    #[inline(always)]
    #[must_use]
    pub fn new(values: [f64; LANES]) -> Self {
        Self(Pack::new(values))
    }

    /// The first numbers of a slice.
    #[inline(always)]
    #[must_use]
    pub fn read(from: &[f64]) -> Self {
        Self::new(*from.first_chunk().expect("as many numbers as lanes"))
    }

    /// Writes the numbers to the start of a slice.
    #[inline(always)]
    pub fn write(self, to: &mut [f64]) {
        *to.first_chunk_mut().expect("as many numbers as lanes") = self.to_array();
    }

    /// As many packs as lanes with rows and columns exchanged.
    #[inline(always)]
    #[must_use]
    pub fn transposed(rows: [Self; LANES]) -> [Self; LANES] {
        Pack::transpose(rows.map(|row| row.0)).map(Self)
    }

    /// The numbers.
    #[inline(always)]
    #[must_use]
    pub fn to_array(self) -> [f64; LANES] {
        self.0.to_array()
    }

    /// Writes the number in a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: f64) {
        self.0.as_mut_array()[lane] = value;
    }

    /// The sum over the lanes.
    #[inline(always)]
    #[must_use]
    pub fn sum(self) -> f64 {
        self.to_array().iter().sum()
    }

    /// Lane by lane the smaller number; NaN stays NaN.
    #[inline(always)]
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        Self(other.0.fast_min(self.0))
    }

    /// Lane by lane the larger number; NaN stays NaN.
    #[inline(always)]
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self(other.0.fast_max(self.0))
    }
}

impl From<f64> for Lanes {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self(Pack::splat(value))
    }
}

macro_rules! operators {
    ($($name:ident $method:ident),*) => {$(
        impl $name for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }

        impl $name<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::from(other))
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

super::in_place!([] Lanes);

impl Real for Lanes {
    type Constant = Self;

    #[inline(always)]
    fn constant(value: Self) -> Self {
        value
    }

    #[inline(always)]
    fn value(&self) -> Self {
        *self
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.0.as_array()[lane]
    }

    #[inline(always)]
    fn re(&self) -> f64 {
        self.to_array()[0]
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos();
        (Self(sin), Self(cos))
    }

    #[inline(always)]
    fn ln(self) -> Self {
        Self(self.0.ln())
    }

    #[inline(always)]
    fn soft_plus(self, delta: f64) -> PositivePart<Self> {
        let per = 1.0 / delta;
        let size = Self(self.0.abs()) * per;
        // Most cells in the strands are far from the sheaves.
        let tail = if size.0.simd_gt(Pack::splat(EXP_CUTOFF)).all() {
            SoftTail {
                exp: Self::from((-EXP_CUTOFF).exp()),
                inverse: Self::one(),
                log: Self::from((-EXP_CUTOFF).exp()),
            }
        } else {
            soft_tail(size.min(Self::from(EXP_CUTOFF)), |shifted| {
                Self::new(shifted.to_array().map(to_exponent))
            })
        };
        let value = self.max(Self::zero()) + tail.log * delta;
        let slope = self.if_positive(Self::one(), tail.exp) * tail.inverse;
        // 1 − slope without cancellation.
        let rest = self.if_positive(tail.exp, Self::one()) * tail.inverse;
        PositivePart {
            value,
            slope,
            curvature: slope * rest * per,
        }
    }

    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        Self(self.0.simd_gt(Pack::splat(0.0)).select(yes.0, no.0))
    }

    #[inline(always)]
    fn smooth_plus(self, delta: f64) -> PositivePart<Self> {
        let square = delta * delta;
        let root = (self * self + square).sqrt();
        let sum = root + Self(self.0.abs());
        let half = Self::from(0.5 * square);
        // One division for both quotients.
        let inverse = (sum * root).recip();
        let value = self.if_positive(sum * 0.5, half * root * inverse);
        PositivePart {
            value,
            slope: value * sum * inverse,
            curvature: half / (root * root * root),
        }
    }
}
