//! `ALE`: the ring deflects from the reference curve.

use crate::reference_curve::{COORDINATES, ReferencePoint};
use crate::ring::kinematics::{ElementLoad, ElementMotion, LineLoad, Motion, Node, ReferenceMotion, RingPoint};
use crate::ring::{Ring, ale};
use crate::scalar::Real;
use crate::variator::law::place::Place;
use crate::variator::rings::ring::{Action, CellRing, EulerianRing, RingDensity, RingForces};

/// `ALE`: the ring deflects from the reference curve, in D components.
#[derive(Clone, Debug)]
pub struct Deflecting<'a, T: Real, const D: usize = 2> {
    /// Parameters of the beam.
    pub ring: &'a Ring,
    /// Place of the cell.
    pub place: &'a Place<'a, T>,
    /// Motion of the element.
    pub element: ElementMotion<T, D>,
    /// Motion of the reference curve.
    pub motion: &'a ReferenceMotion<T>,
    /// (∂l/∂Θ)/l, l the length of the element.
    pub growth: T,
    /// Sum of the applied loads.
    pub sum: ElementLoad<T, D>,
}

impl<'a, T: Real, const D: usize> Deflecting<'a, T, D> {
    /// The ring between two nodes.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        place: &'a Place<'a, T>,
        motion: &'a ReferenceMotion<T>,
        nodes: &[Motion<Node<T, D>>; 2],
    ) -> Self {
        Self {
            ring,
            place,
            element: ElementMotion::flexible(place.length, &motion.theta, nodes),
            motion,
            growth: place.length.d / place.length.v,
            sum: ElementLoad::zero(),
        }
    }
}

impl<T: Real, const D: usize> EulerianRing<T, D> for Deflecting<'_, T, D> {
    #[inline(always)]
    fn forces(&self) -> RingForces<T, D> {
        let (nodes, theta) = self.sum.nodes(&self.element);
        RingForces {
            nodes,
            tension: T::zero(),
            drift: self.sum.s,
            theta,
            centres: [T::zero(); COORDINATES - 1],
        }
    }
}

impl<T: Real, const D: usize> CellRing<T, D> for Deflecting<'_, T, D> {
    #[inline(always)]
    fn point(&self, slot: usize, reference: ReferencePoint<T>) -> RingPoint<T, D> {
        RingPoint::new(reference, &self.place.slot(slot).shape, &self.element, self.motion)
    }

    #[inline(always)]
    fn own_load(&self, _slot: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T {
        ale::add_inertia(self.ring, point, load);
        ale::add_elasticity(self.ring, point, self.growth, load)
    }

    #[inline(always)]
    fn apply(&mut self, slot: usize, point: &RingPoint<T, D>, action: &Action<T, D>) {
        let shape = &self.place.slot(slot).shape;
        self.sum.add(&action.load, point, shape, &self.element, action.weight);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        RingDensity {
            kinetic: ale::kinetic_energy_density(self.ring, point),
            elastic: ale::energy_density(self.ring, point),
            viscous: ale::dissipation_density(self.ring, point),
        }
    }
}
