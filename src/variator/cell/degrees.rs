//! The degrees of freedom of a cell, which depend on its ring.
//!
//! Motions of the nodes come first, then V, V, N, in `ALE0` the tensions T, T, then s, Θ, in `ALE0`
//! the other coordinates of the curve, then z, ψ_x, ψ_y, ω.

use crate::reference_curve::COORDINATES;

/// Largest number of degrees of freedom of a cell, those of a ring in space, and of its rows.
pub(crate) const MOST: usize = Degrees::deflecting(3).count;
pub(crate) const MOST_ROWS: usize = Degrees::deflecting(3).rows;

/// Numbers and first indices of the degrees of freedom of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Degrees {
    /// Number of motions of the nodes, which the speeds V follow.
    pub(crate) nodes: usize,
    /// Number of tensions of the ring: at the faces, if it has no nodes.
    pub(crate) tensions: usize,
    /// Number of coordinates of the reference curve; Θ is the first, and the only one of a ring
    /// with nodes.
    pub(crate) coordinates: usize,
    /// The content. Its row is zero: the balance of the fluxes stands for it.
    pub(crate) content: usize,
    /// The drift s, first of those that several cells share.
    pub(crate) drift: usize,
    /// Θ, first of the coordinates of the curve.
    pub(crate) theta: usize,
    /// z, first of those of the pulley.
    pub(crate) sheave: usize,
    /// Number of all.
    pub(crate) count: usize,
    /// Number of rows: one for each, then the two components of the resultant of the contact
    /// forces.
    pub(crate) rows: usize,
}

impl Degrees {
    /// With a ring that deflects in 2 or 3 components, or follows the reference curve: 0.
    #[must_use]
    pub const fn deflecting(components: usize) -> Self {
        let [tensions, coordinates] = if components == 0 { [2, COORDINATES] } else { [0, 1] };
        // Deflection and slope of two nodes.
        let nodes = 4 * components;
        let content = nodes + 2;
        let drift = content + 1 + tensions;
        let theta = drift + 1;
        let sheave = theta + coordinates;
        let count = sheave + 4;
        Self {
            nodes,
            tensions,
            coordinates,
            content,
            drift,
            theta,
            sheave,
            count,
            rows: count + 2,
        }
    }
}

/// A kind of ring, by the degrees of freedom of a cell with it.
pub trait DegreesOfFreedom: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Those of a cell.
    const DEGREES: Degrees;
}

/// `ALE0`: the ring follows the reference curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuidedRing;

/// `ALE`: the ring deflects in D components of fixed directions, A_i = identity in (10).
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeflectingRing<const D: usize>;

impl DegreesOfFreedom for GuidedRing {
    const DEGREES: Degrees = Degrees::deflecting(0);
}

impl<const D: usize> DegreesOfFreedom for DeflectingRing<D> {
    const DEGREES: Degrees = Degrees::deflecting(D);
}
