//! The directions in which a cell can vary, by the ring that it has.
//!
//! Motions of the nodes come first, then V, V, N, in `ALE0` the tensions T, T, then s, Θ, z, ψ_x, ψ_y, ω.

/// Most directions of a cell: 12 node motions in space, V, V, N, and six globals.
pub(crate) const MOST: usize = 21;

/// Most rows of a cell: one for each direction, and two for the resultant of the contact forces.
pub(crate) const MOST_ROWS: usize = MOST + RESULTANT;

/// Components of the resultant, whose rows come after those of the directions.
pub(crate) const RESULTANT: usize = 2;

/// Directions of the globals: s, Θ, z, ψ_x, ψ_y, ω.
const GLOBALS: usize = 6;

/// Directions of a cell with a certain ring.
pub(crate) trait Directions: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Number of those that are motions of the nodes.
    const NODES: usize;
    /// Number of those that are tensions of the ring.
    const TENSIONS: usize;
    /// Direction of the amount, whose row the fluxes fill.
    const AMOUNT: usize = Self::NODES + 2;
    /// The drift s, first of the globals.
    const DRIFT: usize = Self::NODES + 3 + Self::TENSIONS;
    /// Direction of Θ.
    const THETA: usize = Self::DRIFT + 1;
    /// Number of all directions.
    const COUNT: usize = Self::DRIFT + GLOBALS;

    /// Unknown that varies in direction `k`; none for Θ, whose derivatives [`variation`](crate::variator::cell::variation)
    /// does not have.
    fn direction(k: usize) -> Option<Direction> {
        if k < Self::NODES {
            return Some(Direction::Ring(k));
        }
        if k < Self::DRIFT {
            return Some(match k - Self::NODES {
                face @ (0 | 1) => Direction::Speed(face),
                2 => Direction::Amount,
                tension => Direction::Ring(tension - 3),
            });
        }
        match k - Self::DRIFT {
            0 => Some(Direction::Drift),
            1 => None,
            2 => Some(Direction::Sheave),
            axis @ (3 | 4) => Some(Direction::Tilt(axis - 3)),
            _ => Some(Direction::Shaft),
        }
    }
}

/// `ALE0`: the ring keeps to the reference curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuidedRing;

/// `ALE`: the ring deflects in D components, counted in fixed directions, A_i = identity in (10).
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeflectingRing<const D: usize>;

/// `ALE`: the ring deflects in D components, counted along the reference curve and across it, A_i = [t, n, b]_ref in (10).
#[derive(Clone, Copy, Debug)]
pub(crate) struct RotatingRing<const D: usize>;

impl Directions for GuidedRing {
    const NODES: usize = 0;
    const TENSIONS: usize = 2;
}

impl<const D: usize> Directions for DeflectingRing<D> {
    const NODES: usize = 4 * D;
    const TENSIONS: usize = 0;
}

impl<const D: usize> Directions for RotatingRing<D> {
    const NODES: usize = 4 * D;
    const TENSIONS: usize = 0;
}

/// An unknown of a cell that varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// An unknown of the ring's own: of a node, or (`ALE0`) the tension at a face.
    Ring(usize),
    /// The speed V at a face.
    Speed(usize),
    /// The amount N of elements in the cell.
    Amount,
    /// The drift rate ṡ.
    Drift,
    /// The axial speed ż of the movable sheave.
    Sheave,
    /// The tilt ψ_x (0) or ψ_y (1) of the sheaves.
    Tilt(usize),
    /// The angular speed ω of the pulley.
    Shaft,
}
