//! Numbers with N derivatives, packed or one at a time: forward differentiation.

use super::lanes::Lanes;
use super::real::{PositivePart, Real};
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The chain rule: the sum of derivatives times the variations of the arguments.
#[inline(always)]
pub fn along<const N: usize, L: Real>(slopes: &[L; N], by: &[L; N]) -> L {
    (1..N).fold(slopes[0] * by[0], |sum, k| sum + slopes[k] * by[k])
}

/// Numbers and their derivatives in N directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent<const N: usize, L = Lanes> {
    /// The numbers themselves.
    pub re: L,
    /// Their derivatives, one for each direction.
    pub eps: [L; N],
}

/// A number with one derivative.
pub type Dual = Tangent<1, f64>;

impl<const N: usize, L: Real> Tangent<N, L> {
    #[inline(always)]
    fn plain(value: L) -> Self {
        Self {
            re: value,
            eps: [L::zero(); N],
        }
    }

    /// `value` with the derivative `slope` in `direction`; a constant if there is no such
    /// direction.
    #[inline(always)]
    #[must_use]
    pub fn seed(value: L, direction: usize, slope: f64) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| L::from(if i == direction { slope } else { 0.0 })),
        }
    }

    /// The function with value `value` and derivative `slope` here.
    #[inline(always)]
    fn chain(&self, value: L, slope: L) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| self.eps[i] * slope),
        }
    }

    /// A positive part with these values and the third derivative `third` here.
    #[inline(always)]
    fn chain_part(&self, part: PositivePart<L>, third: L) -> PositivePart<Self> {
        PositivePart {
            value: self.chain(part.value, part.slope),
            slope: self.chain(part.slope, part.curvature),
            curvature: self.chain(part.curvature, third),
        }
    }

    /// A function of two numbers with value `value` and derivatives `slope`, `other_slope` here.
    #[inline(always)]
    fn join(&self, other: &Self, value: L, slope: L, other_slope: L) -> Self {
        Self {
            re: value,
            eps: from_fn(|i| self.eps[i] * slope + other.eps[i] * other_slope),
        }
    }
}

impl<const N: usize, L: Real<Constant = L>> Real for Tangent<N, L>
where
    Self: Mul<L, Output = Self>,
{
    type Constant = L;

    #[inline(always)]
    fn constant(value: L) -> Self {
        Self::plain(value)
    }

    #[inline(always)]
    fn value(&self) -> L {
        self.re
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.re.lane(lane)
    }

    #[inline(always)]
    fn re(&self) -> f64 {
        self.re.re()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, L::from(0.5) / root)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let recip = self.re.recip();
        self.chain(recip, -(recip * recip))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.re.ln(), self.re.recip())
    }

    #[inline(always)]
    fn soft_plus(self, delta: f64) -> PositivePart<Self> {
        let part = self.re.soft_plus(delta);
        let third = part.curvature * (part.slope * (-2.0) + 1.0) * (1.0 / delta);
        self.chain_part(part, third)
    }

    #[inline(always)]
    fn if_positive(self, yes: Self, no: Self) -> Self {
        Self {
            re: self.re.if_positive(yes.re, no.re),
            eps: from_fn(|k| self.re.if_positive(yes.eps[k], no.eps[k])),
        }
    }

    #[inline(always)]
    fn smooth_plus(self, delta: f64) -> PositivePart<Self> {
        let part = self.re.smooth_plus(delta);
        let square = self.re * self.re + delta * delta;
        self.chain_part(part, self.re * part.curvature * (-3.0) / square)
    }
}

impl<const N: usize, L: Real> From<f64> for Tangent<N, L> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::plain(L::from(value))
    }
}

impl<const N: usize, L: Real> Neg for Tangent<N, L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            re: -self.re,
            eps: self.eps.map(|a| -a),
        }
    }
}

macro_rules! entry_by_entry {
    ($($name:ident $method:ident),*) => {$(
        impl<const N: usize, L: Real> $name for Tangent<N, L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self {
                    re: self.re.$method(other.re),
                    eps: from_fn(|i| self.eps[i].$method(other.eps[i])),
                }
            }
        }
    )*};
}
entry_by_entry!(Add add, Sub sub);

impl<const N: usize, L: Real> Mul for Tangent<N, L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.join(&other, self.re * other.re, other.re, self.re)
    }
}

impl<const N: usize, L: Real> Div for Tangent<N, L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let recip = other.re.recip();
        let value = self.re / other.re;
        self.join(&other, value, recip, -(value * recip))
    }
}

macro_rules! with_constants {
    ([$($generic:tt)*] $constant:ty, $number:ty) => {
        impl<const N: usize $($generic)*> Add<$constant> for Tangent<N, $number> {
            type Output = Self;
            #[inline(always)]
            fn add(mut self, other: $constant) -> Self {
                self.re += <$number>::from(other);
                self
            }
        }

        impl<const N: usize $($generic)*> Sub<$constant> for Tangent<N, $number> {
            type Output = Self;
            #[inline(always)]
            fn sub(mut self, other: $constant) -> Self {
                self.re -= <$number>::from(other);
                self
            }
        }

        impl<const N: usize $($generic)*> Mul<$constant> for Tangent<N, $number> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: $constant) -> Self {
                self.chain(self.re * other, <$number>::from(other))
            }
        }
    };
}
with_constants!([, L: Real] f64, L);
with_constants!([] Lanes, Lanes);

super::in_place!([const N: usize, L: Real] Tangent<N, L>);

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation against central differences of fourth order.
    #[test]
    fn derivatives_are_those_of_differences() {
        fn law<T: Real>([a, b]: [T; 2]) -> T {
            let (sin, cos) = (a * 0.7 - b).sin_cos();
            let smooth = (a * b - 0.3).smooth_plus(0.2);
            let soft = (a * b - 0.3).soft_plus(0.2);
            let far = (a * b + 900.0).soft_plus(0.2).value;
            let mut sum =
                (sin + 2.0) * (cos + 3.0) / (a * a + 1.0) - smooth.value * smooth.slope + smooth.curvature;
            sum -= (b * b + 0.5).sqrt() + (a + 4.0).recip();
            sum += soft.value * soft.slope - soft.curvature * (a * 0.3) + far + (a * a + b).ln();
            sum *= -a;
            sum
        }
        let point = [0.9, 0.4];
        let found = law([0, 1].map(|i| Tangent::<2, f64>::seed(point[i], i, 1.0)));
        assert_eq!(found.re, law(point));
        for (i, slope) in found.eps.into_iter().enumerate() {
            let h = 3e-4;
            let [plus, minus, far, farther] = [h, -h, 2.0 * h, -2.0 * h].map(|h| {
                let mut moved = point;
                moved[i] += h;
                law(moved)
            });
            let difference = (8.0 * (plus - minus) - far + farther) / (12.0 * h);
            assert!((slope - difference).abs() < 1e-8, "{slope} {difference}");
        }
    }
}
