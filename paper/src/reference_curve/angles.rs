//! What the comparison needs of a reference curve beyond the variator: its tangent angle, its
//! points by ξ, and whether it changes with Θ.

use super::{Jet, ReferenceCurve, ReferencePoint, TwoPulley, TwoPulleyFrame};
use crate::scalar::Real;

/// The tangent angle of the reference curve and its rate along ξ, each with its derivatives with
/// respect to Θ.
#[derive(Clone, Copy, Debug)]
pub struct TangentAngle<T> {
    /// Tangent angle χ at fixed η, rad.
    pub chi: Jet<T>,
    /// Curvature κ at fixed η, 1/m.
    pub kappa: Jet<T>,
}

/// A reference curve with its tangent angle.
pub trait AngledCurve: ReferenceCurve {
    /// Whether the curve depends on Θ. If not, Θ is no degree of freedom.
    fn has_ratio(&self) -> bool {
        true
    }

    /// Tangent angle and curvature at fraction `fraction` of `segment`.
    fn tangent_angle<T: Real>(
        frame: &Self::Frame<T>,
        segment: usize,
        fraction: T::Constant,
    ) -> TangentAngle<T>;

    /// The curve at the place ξ, m, taken around the loop.
    fn at(&self, frame: &Self::Frame<f64>, xi: f64) -> ReferencePoint<f64> {
        let (segment, fraction) = self.locate(frame, xi);
        Self::point(frame, segment, fraction)
    }
}

impl AngledCurve for TwoPulley {
    fn tangent_angle<T: Real>(
        frame: &TwoPulleyFrame<T>,
        segment: usize,
        fraction: T::Constant,
    ) -> TangentAngle<T> {
        let (pulley, chi) = frame.angle(segment, fraction);
        let is_strand = segment % 2 == 1;
        let kappa = if is_strand {
            Jet::constant(0.0)
        } else {
            frame.radius[pulley].recip()
        };
        TangentAngle { chi, kappa }
    }
}
