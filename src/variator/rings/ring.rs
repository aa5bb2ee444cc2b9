//! The ring inside a cell: traits that couple a ring model to chain and contact.
//!
//! [`balance`](crate::variator::cell::balance) calls the four functions of [`CellRing`].

use crate::reference_curve::{COORDINATES, ReferencePoint};
use crate::ring::kinematics::{LineLoad, Node, RingPoint};
use crate::scalar::Real;

/// Loads at a station, per dξ.
#[derive(Clone, Copy, Debug)]
pub struct Action<T: Real, const D: usize = 2> {
    /// Loads on the ring: its own and those of chain and contact.
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

/// Energies and damping of the ring at a station.
#[derive(Clone, Copy, Debug)]
pub struct RingDensity<T> {
    /// Kinetic energy per dξ, J/m.
    pub kinetic: T,
    /// Elastic energy per dξ, J/m.
    pub elastic: T,
    /// Power of damping per dξ, W/m.
    pub viscous: T,
}

/// A ring inside a cell. Slot 0 is the left face of the cell, slots 1 and up are its stations.
pub trait CellRing<T: Real, const D: usize = 2> {
    /// The ring at a slot where the reference curve is `reference`.
    fn point(&self, slot: usize, reference: ReferencePoint<T>) -> RingPoint<T, D>;

    /// Adds the ring's own forces, inertia included; returns its tension, N. A ring that assembles these on elements of
    /// its own adds nothing.
    fn own_load(&self, slot: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T;

    /// Applies the loads at a station.
    fn apply(&mut self, slot: usize, point: &RingPoint<T, D>, action: &Action<T, D>);

    /// Energies at a station; zero for a ring with elements of its own.
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T>;
}

/// A ring on an Eulerian mesh, inside a cell.
pub trait EulerianRing<T: Real, const D: usize = 2>: CellRing<T, D> + Clone {
    /// Generalised forces of the applied loads.
    fn forces(&self) -> RingForces<T, D>;

    /// Of a ring without loads: the same, whose forces are linear in the loads. A ring that adds forces of its own in
    /// [`CellRing::apply`] leaves them out.
    #[inline(always)]
    #[must_use]
    fn under_loads_alone(&self) -> Self {
        self.clone()
    }
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
    /// Rows of the other coordinates of the curve (`ALE0`): spread, N, turn, N·m, shift, N, growth, N.
    pub centres: [T; COORDINATES - 1],
}
