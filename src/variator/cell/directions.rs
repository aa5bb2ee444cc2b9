//! The directions in which a cell can vary, which depend on its ring.
//!
//! Motions of the nodes come first, then V, V, N, in `ALE0` the tensions T, T, then s, Θ, in `ALE0` the other coordinates
//! of the curve, then z, ψ_x, ψ_y, ω.

use crate::reference_curve::COORDINATES;

/// Largest number of directions of a cell, that of a ring in space.
pub(crate) const MOST: usize = DeflectingRing::<3>::COUNT;

/// Largest number of rows of a cell: one for each direction, and two for the resultant of the contact forces.
pub(crate) const MOST_ROWS: usize = MOST + RESULTANT;

/// Components of the resultant; their rows follow those of the directions.
pub(crate) const RESULTANT: usize = 2;

/// Directions of the pulley: z, ψ_x, ψ_y, ω.
const OF_PULLEY: usize = 4;

/// Directions of a cell with a given ring.
pub trait Directions: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Number of motions of the nodes.
    const NODES: usize;
    /// Number of tensions of the ring: at the faces, if it has no nodes.
    const TENSIONS: usize = if Self::NODES == 0 { 2 } else { 0 };
    /// Number of coordinates of the reference curve; Θ is the first, and the only one of a ring with nodes.
    const COORDINATES: usize = if Self::NODES == 0 { COORDINATES } else { 1 };
    /// Direction of the content. Its row is the balance of the fluxes.
    const CONTENT: usize = Self::NODES + 2;
    /// The drift s, first of the globals.
    const DRIFT: usize = Self::NODES + 3 + Self::TENSIONS;
    /// Direction of Θ.
    const THETA: usize = Self::DRIFT + 1;
    /// Direction of z, first of those of the pulley.
    const SHEAVE: usize = Self::THETA + Self::COORDINATES;
    /// Number of all directions.
    const COUNT: usize = Self::SHEAVE + OF_PULLEY;
}

/// `ALE0`: the ring follows the reference curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuidedRing;

/// `ALE`: the ring deflects in D components of fixed directions, A_i = identity in (10).
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeflectingRing<const D: usize>;

impl Directions for GuidedRing {
    const NODES: usize = 0;
}

impl<const D: usize> Directions for DeflectingRing<D> {
    const NODES: usize = 4 * D;
}
