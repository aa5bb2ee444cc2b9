//! Reference curves (paper 2, 3.1, 5.1): a closed planar curve r(ξ, Θ) of fixed length L that changes with one ratio
//! coordinate Θ, divided into segments on which it is smooth.
//!
//! A mesh point η is a segment and a fraction f ∈ [0, 1] of it; ξ(η, Θ) moves with Θ while the point stays on its own
//! arc or strand. Derivatives with respect to Θ are taken at fixed η. The curve runs clockwise: tangent
//! t = (sin χ, cos χ), inward normal n = (cos χ, −sin χ), tangent angle χ growing, t' = κ n, n' = −κ t.

mod curve;
mod frame;
mod jet;
mod two_pulley;

pub use curve::{ReferenceCurve, ReferencePoint};
pub use frame::{COORDINATES, CoordinateDerivatives, MeshCurve, Path, PointDerivatives, TwoPulleyFrame};
pub use jet::Jet;
pub use two_pulley::{GeometryError, TwoPulley, ratio_of_theta};
