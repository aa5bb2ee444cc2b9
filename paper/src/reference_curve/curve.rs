//! The trait of a reference curve (paper 2, 3.1).

use super::{CurvePlace, Jet, ReferencePoint, TwoPulley, TwoPulleyFrame};
use crate::scalar::Real;
use std::fmt::Debug;

/// The tangent angle of the reference curve and its rate along ξ, each with its derivatives with
/// respect to Θ.
#[derive(Clone, Copy, Debug)]
pub struct TangentAngle<T> {
    /// Tangent angle χ at fixed η, rad.
    pub chi: Jet<T>,
    /// Curvature κ at fixed η, 1/m.
    pub kappa: Jet<T>,
}

/// A closed curve with one ratio coordinate Θ. For another belt system, implement this trait (paper
/// section 7).
pub trait ReferenceCurve: Clone + Debug + Send + 'static {
    /// Quantities that depend on Θ alone, computed once for all mesh points.
    type Frame<T: Real>: Clone;

    /// Length L of the curve, the same for every Θ, m.
    fn length(&self) -> f64;

    /// Number of segments.
    fn segments(&self) -> usize;

    /// Whether the curve depends on Θ. If not, Θ is no degree of freedom.
    fn has_ratio(&self) -> bool {
        true
    }

    /// Geometry at Θ. Outside the admissible range of Θ the frame holds NaN.
    fn frame<T: Real>(&self, theta: T) -> Self::Frame<T>;

    /// Length of a segment, m.
    fn segment_length<T: Real>(frame: &Self::Frame<T>, segment: usize) -> Jet<T>;

    /// The curve at fraction `fraction` of `segment`.
    fn point<T: Real>(frame: &Self::Frame<T>, segment: usize, fraction: T::Constant) -> ReferencePoint<T>;

    /// Tangent angle and curvature at fraction `fraction` of `segment`.
    fn tangent_angle<T: Real>(
        frame: &Self::Frame<T>,
        segment: usize,
        fraction: T::Constant,
    ) -> TangentAngle<T>;

    /// Segment and fraction at the place ξ, m, taken around the loop.
    fn locate(&self, frame: &Self::Frame<f64>, xi: f64) -> CurvePlace {
        let mut rest = xi.rem_euclid(self.length());
        let last = self.segments() - 1;
        for segment in 0..last {
            let length = Self::segment_length(frame, segment).v;
            if rest < length {
                let fraction = rest / length;
                return CurvePlace { segment, fraction };
            }
            rest -= length;
        }
        CurvePlace {
            segment: last,
            fraction: (rest / Self::segment_length(frame, last).v).min(1.0),
        }
    }

    /// The curve at the place ξ, m, taken around the loop.
    fn at(&self, frame: &Self::Frame<f64>, xi: f64) -> ReferencePoint<f64> {
        let CurvePlace { segment, fraction } = self.locate(frame, xi);
        Self::point(frame, segment, fraction)
    }
}

impl ReferenceCurve for TwoPulley {
    type Frame<T: Real> = TwoPulleyFrame<T>;

    fn length(&self) -> f64 {
        self.length()
    }

    fn segments(&self) -> usize {
        Self::SEGMENTS
    }

    fn frame<T: Real>(&self, theta: T) -> TwoPulleyFrame<T> {
        self.frame(theta)
    }

    #[inline(always)]
    fn segment_length<T: Real>(frame: &TwoPulleyFrame<T>, segment: usize) -> Jet<T> {
        frame.segment_length(segment)
    }

    #[inline(always)]
    fn point<T: Real>(frame: &TwoPulleyFrame<T>, segment: usize, fraction: T::Constant) -> ReferencePoint<T> {
        frame.point(segment, fraction)
    }

    fn tangent_angle<T: Real>(
        frame: &TwoPulleyFrame<T>,
        segment: usize,
        fraction: T::Constant,
    ) -> TangentAngle<T> {
        TangentAngle {
            chi: frame.angle(segment, fraction),
            kappa: frame.curvature(segment),
        }
    }
}
