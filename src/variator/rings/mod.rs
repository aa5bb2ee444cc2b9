//! The ring inside a cell: traits that couple a ring model to stack and contact, rings that follow
//! the reference curve, and rings that deflect from it.

pub(crate) mod deflecting;
pub(crate) mod guided;

use crate::reference_curve::{COORDINATES, CurveCoordinates, ReferencePoint, TwoPulleyFrame};
use crate::ring::Ring;
use crate::ring::ale::RingDensity;
use crate::ring::kinematics::{LineLoad, Node, ReferenceMotion, RingPoint, RingVariation};
use crate::scalar::{Lanes, Real, zero_vector};
use crate::solver::Factors;
use crate::variator::law::arguments::{CellGeometry, StateComponent};
use deflecting::Deflecting;
use std::fmt::Debug;

/// Arguments of a ring inside a cell: parameters, place, and motion of the reference curve.
#[derive(Clone, Copy, Debug)]
pub struct RingInput<'a, T: Real> {
    /// Parameters of the beam.
    pub ring: &'a Ring,
    /// Geometry of the cell.
    pub geometry: &'a CellGeometry<'a, T>,
    /// Motion of the reference curve, and drift.
    pub motion: &'a ReferenceMotion<T>,
    /// Reference curve.
    pub frame: &'a TwoPulleyFrame<T>,
    /// Segment of the curve.
    pub segment: usize,
}

impl<T: Real> RingInput<'_, T> {
    /// The reference curve at a point of the cell.
    #[inline(always)]
    #[must_use]
    pub fn reference(&self, at: usize) -> ReferencePoint<T> {
        self.frame.point(self.segment, self.geometry.fraction(at))
    }
}

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
    /// Generalised forces: [`RingForces`] of a ring on an Eulerian mesh.
    type Forces;

    /// The ring at a point.
    fn point(&self, at: usize) -> RingPoint<T, D>;

    /// Adds the ring's own forces, inertia included; returns its tension, N. A ring that assembles
    /// these on elements of its own adds nothing.
    fn own_load(&self, at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T;

    /// Applies the loads at a station.
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>);

    /// Energies at a station; zero for a ring with elements of its own.
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T>;

    /// Generalised forces of the applied loads.
    fn forces(&self) -> Self::Forces;
}

/// Derivatives by hand of a ring on an Eulerian mesh, with its own unknowns: directions that change
/// neither the reference curve nor the drift.
pub trait VaryingRing<T: Real, const D: usize = 2>: CellRing<T, D, Forces = RingForces<T, D>> {
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
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own_load: &LineLoad<T, D>,
        station_load: &StationLoad<T, D>,
    );

    /// Variation of the generalised forces. If the ring moves, the loads of the cell must have been
    /// applied to it before.
    fn varied_forces(&self, sum: &Self::Sum, own: Option<usize>, beta: f64) -> RingForces<T, D>;
}

/// Largest number of degrees of freedom of a cell, those of a ring in space, and of its rows.
pub(crate) const MOST: usize = Degrees::deflecting(3).count;
pub(crate) const MOST_ROWS: usize = Degrees::deflecting(3).rows;

/// Numbers and first indices of the degrees of freedom of a cell. Motions of the nodes come first,
/// then V, V, N, in `ALE0` the tensions T, T, then s, Θ, in `ALE0` the other coordinates of the
/// curve, then z, ψ_x, ψ_y, ω.
#[derive(Clone, Copy, Debug)]
pub struct Degrees {
    pub(crate) nodes: usize,
    pub(crate) tensions: usize,
    /// Number of coordinates of the reference curve.
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
    /// Number of rows: one for each, then two of the resultant of the contact forces.
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

/// A ring on an Eulerian mesh in D components: its parameters beyond those of the beam.
pub trait RingKind<const D: usize>: Copy + Debug + Send + Sync + 'static {
    /// Degrees of freedom of a cell.
    const DEGREES: Degrees = Degrees::deflecting(D);

    /// The ring inside a cell.
    type Ring<'a, T: Real>: CellRing<T, D, Forces = RingForces<T, D>>;

    /// The ring inside a cell, from the `unknown` of a component and a degree of freedom.
    fn ring<'a, T: Real>(
        &self,
        given: RingInput<'a, T>,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Self::Ring<'a, T>;

    /// The ring itself, if it has derivatives by hand.
    fn by_hand<'r, 'a: 'r>(_ring: &'r Self::Ring<'a, Lanes>) -> Option<&'r impl VaryingRing<Lanes, D>> {
        None::<&Deflecting<'a, Lanes, D>>
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
    /// Conjugates of the coordinates of the curve, N·m and N: of Θ alone, except in `ALE0`.
    pub curve: CurveCoordinates<T>,
}

impl<T: Real, const D: usize> RingForces<T, D> {
    /// No forces.
    #[inline(always)]
    #[must_use]
    pub fn zero() -> Self {
        let still = Node {
            a: zero_vector(),
            b: zero_vector(),
        };
        Self {
            nodes: [still; 2],
            tension: T::zero(),
            drift: T::zero(),
            curve: CurveCoordinates::from_array([T::zero(); COORDINATES]),
        }
    }
}
