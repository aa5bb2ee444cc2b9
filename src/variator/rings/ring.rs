//! The ring inside a cell: traits that couple a ring model to stack and contact.
//!
//! [`balance`](crate::variator::cell::balance) calls the four functions of [`CellRing`].

use crate::reference_curve::{COORDINATES, ReferencePoint};
use crate::ring::ale::RingDensity;
use crate::ring::kinematics::{LineLoad, Node, RingPoint, RingVariation};
use crate::scalar::Real;
use crate::solver::Factors;

/// Loads at a station, per dξ.
#[derive(Clone, Copy, Debug)]
pub struct StationLoad<T: Real, const D: usize = 2> {
    /// Loads on the ring: its own and those of stack and contact.
    pub load: LineLoad<T, D>,
    /// Ring tension T, N.
    pub tension: T,
    /// All forces across the ring, inwards, N/m.
    pub across: T,
    /// The ring's own forces and the ring friction along it, N/m.
    pub along: T,
    /// Quadrature weight dξ, m.
    pub weight: T,
}

/// A ring inside a cell. Point 0 of a cell is its left face, points 1 and up are its stations.
pub trait CellRing<T: Real, const D: usize = 2> {
    /// The ring at a point where the reference curve is `reference`.
    fn point(&self, at: usize, reference: ReferencePoint<T>) -> RingPoint<T, D>;

    /// Adds the ring's own forces, inertia included; returns its tension, N. A ring that assembles
    /// these on elements of its own adds nothing.
    fn own_load(&self, at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T;

    /// Applies the loads at a station.
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>);

    /// Energies at a station; zero for a ring with elements of its own.
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T>;
}

/// A ring on an Eulerian mesh, inside a cell.
pub trait EulerianRing<T: Real, const D: usize = 2>: CellRing<T, D> {
    /// Generalised forces of the applied loads.
    fn forces(&self) -> RingForces<T, D>;
}

/// A ring with analytic derivatives in the directions that do not change the reference curve: its
/// own unknowns and the drift.
pub trait VaryingRing<T: Real, const D: usize = 2>: EulerianRing<T, D> {
    /// Sums of varied loads.
    type Sum;

    /// Whether the ring moves with its own unknowns.
    const MOVES: bool;

    /// Variation of the ring at a point with its own unknown `own`; `factors` are those of
    /// acceleration and position.
    fn vary(&self, at: usize, point: &RingPoint<T, D>, own: usize, factors: Factors) -> RingVariation<T, D>;

    /// Adds the variation of [`CellRing::own_load`]; returns that of the tension. `own` is the
    /// ring's unknown that varies, if any.
    fn vary_own_load(
        &self,
        at: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own: Option<usize>,
        load: &mut LineLoad<T, D>,
    ) -> T;

    /// The empty sum.
    fn empty(&self) -> Self::Sum;

    /// Applies the variation of the loads at a station with the ring's own load `own_load`.
    fn apply_varied(
        &self,
        sum: &mut Self::Sum,
        at: usize,
        varied: (&RingPoint<T, D>, &RingVariation<T, D>),
        own_load: &LineLoad<T, D>,
        station_load: &StationLoad<T, D>,
    );

    /// Variation of the generalised forces. If the ring moves, the loads of the cell must have been
    /// applied to it before.
    fn varied_forces(&self, sum: &Self::Sum, own: Option<usize>, beta: f64) -> RingForces<T, D>;
}

/// Generalised forces of a cell on an Eulerian ring (inertia − forces).
#[derive(Clone, Copy, Debug)]
pub struct RingForces<T: Real, const D: usize = 2> {
    /// Conjugates of the node motions (`ALE`).
    pub nodes: [Node<T, D>; 2],
    /// Tension balance along the cell (`ALE0`), N.
    pub tension: T,
    /// Conjugate of s; in `ALE0` the normal balance around the loop, N.
    pub drift: T,
    /// Conjugate of Θ, N·m.
    pub theta: T,
    /// Rows of the other coordinates of the curve (`ALE0`): spread, N, turn, N·m, shift, N, growth,
    /// N.
    pub centres: [T; COORDINATES - 1],
}
