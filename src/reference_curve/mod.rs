//! The reference curve (paper 2, 3.1, 5.1): a closed planar curve r(ξ, Θ) of fixed length L that
//! changes with one ratio coordinate Θ, divided into segments on which it is smooth.
//!
//! A mesh point η is a segment and a fraction f ∈ [0, 1] of it, at which derivatives with respect
//! to Θ are taken. The curve runs clockwise: tangent t = (sin χ, cos χ), inward normal n = (cos χ,
//! −sin χ), tangent angle χ growing, t' = κ n, n' = −κ t.

mod frame;
mod jet;
mod two_pulley;

pub use frame::{
    COORDINATES, CoordinateDerivatives, CurveCoordinates, CurvePlace, Path, PointDerivatives, TwoPulleyFrame,
};
pub use jet::Jet;
pub use two_pulley::{GeometryError, TwoPulley, ratio_of_theta};

use crate::scalar::Real;
use nalgebra::Vector2;

/// The reference curve at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct ReferencePoint<T: Real> {
    /// Position, m.
    pub r: Vector2<T>,
    /// ∂r/∂Θ at fixed η, m.
    pub r_theta: Vector2<T>,
    /// ∂²r/∂Θ² at fixed η, m.
    pub r_theta2: Vector2<T>,
    /// Unit tangent, = r'.
    pub t: Vector2<T>,
    /// Unit inward normal.
    pub n: Vector2<T>,
    /// ∂χ/∂Θ at fixed η, rad.
    pub chi_theta: T,
    /// Curvature κ, 1/m.
    pub kappa: T,
    /// ∂κ/∂Θ at fixed η, 1/m.
    pub kappa_theta: T,
    /// Place ξ(η, Θ) on the curve, m.
    pub xi: Jet<T>,
}

impl<T: Real> ReferencePoint<T> {
    /// ∂(κ n)/∂Θ at fixed η, 1/m.
    #[inline(always)]
    pub fn bend_theta(&self) -> Vector2<T> {
        self.n * self.kappa_theta - self.t * (self.kappa * self.chi_theta)
    }
}
