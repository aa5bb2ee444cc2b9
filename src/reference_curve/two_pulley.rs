//! The reference curve of a variator (paper 5.1): two arcs and two strands, eq. (27) and (28);
//! `docs/theory.md`, section 2.
//!
//! The closure (27) gives r_P(Θ). The printed (28) has misprints: ξ_P = ξ − r_Sφ − b and φ_P = φ +
//! ξ_P/r_P; (29) mirrors at L − ξ. Written with the tangent angle χ the whole loop is one formula:
//! arc points O + r(−cos χ, sin χ) with χ from 0 to φ on S, φ to 2π−φ on P, 2π−φ to 2π on S.

use crate::pulley::PerPulley;
use crate::scalar::Real;
use std::f64::consts::PI;

/// Most Newton steps for a radius. The default variator takes one or two at every ratio; a curve
/// that does not close may take all.
const NEWTON_STEPS: usize = 50;
/// Newton's last step, and the length error up to which a curve counts as closed, as fractions of
/// L. The error after that step is of the order of its square, below rounding.
const CLOSED: f64 = 1e-8;
/// Largest r_P of the search, as a fraction of that with r_P − r_S = d_A, the end of the range of
/// φ.
const MAX_SINE: f64 = 0.9999;

/// The curve around two pulleys: S at the origin, P at (d_A, 0).
#[derive(Clone, Debug)]
pub struct TwoPulley {
    pub(super) center_distance: f64,
    pub(super) length: f64,
}

/// Length of the curve less L, m, and its derivative with respect to r_P, α_P + i_g α_S.
struct Closure {
    excess: f64,
    slope: f64,
}

/// The belt does not fit the pulleys.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "no belt of length {length} m closes around pulleys {center_distance} m apart at a geometric ratio of {ratio}"
)]
pub struct GeometryError {
    /// Belt length L, m.
    pub length: f64,
    /// Distance of the axes d_A, m.
    pub center_distance: f64,
    /// Geometric ratio i_g.
    pub ratio: f64,
}

/// i_g = (1−Θ)/(1+Θ); the map is its own inverse.
pub fn ratio_of_theta<T: Real>(theta: T) -> T {
    (-theta + 1.0) / (theta + 1.0)
}

impl TwoPulley {
    /// Curve of length `length` around pulleys `center_distance` apart, both in m.
    #[must_use]
    pub fn new(center_distance: f64, length: f64) -> Self {
        Self {
            center_distance,
            length,
        }
    }

    /// Length L of the curve, m, the same for every Θ.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    fn closure(&self, r_p: f64, ratio: f64) -> Closure {
        let (d, difference) = (self.center_distance, r_p - ratio * r_p);
        let phi = (difference / d).acos();
        let slope = 2.0 * (PI - phi) + 2.0 * phi * ratio;
        let strand = (d * d - difference * difference).sqrt();
        Closure {
            excess: 2.0 * strand + slope * r_p - self.length,
            slope,
        }
    }

    /// r_P at ratio `ratio`, m; NaN where there is none.
    pub(super) fn primary_radius(&self, ratio: f64) -> f64 {
        // L = 2d_A + π(r_P + r_S) + d_A (x² + x⁴/12 + x⁶/40 + …) with x = (r_P − r_S)/d_A. The
        // start value solves the quadratic equation, corrected by the next two terms.
        let d = self.center_distance;
        let (square, linear) = ((1.0 - ratio) * (1.0 - ratio) / d, PI * (1.0 + ratio));
        let rest = self.length - 2.0 * d;
        let mut r_p = 2.0 * rest / (linear + (linear * linear + 4.0 * square * rest).max(0.0).sqrt());
        let x2 = square * r_p * r_p / d;
        r_p -= d * x2 * x2 * (1.0 / 12.0 + x2 / 40.0) / (linear + 2.0 * square * r_p);
        // The derivative of the closure is positive and bounded away from zero, so Newton converges
        // from every start inside the range of φ.
        let limit = MAX_SINE * d / (1.0 - ratio).abs();
        r_p = r_p.max(0.0).min(limit);
        for _ in 0..NEWTON_STEPS {
            let Closure { excess, slope } = self.closure(r_p, ratio);
            let step = excess / slope;
            r_p = (r_p - step).min(limit);
            if step.abs() < CLOSED * self.length {
                break;
            }
        }
        r_p
    }

    /// Reference radii at a geometric ratio, m.
    ///
    /// # Errors
    /// The belt is too short or too long for the distance of the axes.
    pub fn radii(&self, ratio: f64) -> Result<PerPulley<f64>, GeometryError> {
        let primary = self.primary_radius(ratio);
        let secondary = ratio * primary;
        let closes = self.closure(primary, ratio).excess.abs() < CLOSED * self.length;
        if ratio > 0.0 && closes && primary > 0.0 && secondary > 0.0 {
            Ok(PerPulley { secondary, primary })
        } else {
            Err(GeometryError {
                length: self.length,
                center_distance: self.center_distance,
                ratio,
            })
        }
    }
}
