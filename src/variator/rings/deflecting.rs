//! `ALE`: the ring deflects from the reference curve.

use crate::reference_curve::{COORDINATES, ReferencePoint};
use crate::ring::Ring;
use crate::ring::ale::{self, RingDensity};
use crate::ring::kinematics::{
    ElementLoad, ElementMotion, LineLoad, Motion, NodalUnknown, Node, ReferenceMotion, RingPoint,
    RingVariation,
};
use crate::scalar::Real;
use crate::solver::Factors;
use crate::variator::law::arguments::CellGeometry;
use crate::variator::rings::ring::{CellRing, EulerianRing, RingForces, StationLoad, VaryingRing};

/// `ALE`: the ring deflects from the reference curve, in D components.
#[derive(Debug)]
pub struct Deflecting<'a, T: Real, const D: usize = 2> {
    /// Parameters of the beam.
    pub ring: &'a Ring,
    /// Geometry of the cell.
    pub geometry: &'a CellGeometry<'a, T>,
    /// Motion of the element.
    pub element: ElementMotion<T, D>,
    /// Motion of the reference curve.
    pub motion: &'a ReferenceMotion<T>,
    /// (∂l/∂Θ)/l, l the length of the element.
    pub dilation: T,
    /// Sum of the applied loads.
    pub sum: ElementLoad<T, D>,
}

impl<'a, T: Real, const D: usize> Deflecting<'a, T, D> {
    /// The ring between two nodes.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        geometry: &'a CellGeometry<'a, T>,
        motion: &'a ReferenceMotion<T>,
        nodes: &[Motion<Node<T, D>>; 2],
    ) -> Self {
        Self {
            ring,
            geometry,
            element: ElementMotion::new(geometry.length, &motion.theta, nodes),
            motion,
            dilation: geometry.length.d / geometry.length.v,
            sum: ElementLoad::zero(),
        }
    }

    #[inline(always)]
    fn forces_of(&self, sum: &ElementLoad<T, D>) -> RingForces<T, D> {
        let (nodes, theta) = sum.nodes(&self.element);
        RingForces {
            nodes,
            tension: T::zero(),
            drift: sum.s,
            theta,
            centres: [T::zero(); COORDINATES - 1],
        }
    }
}

impl<T: Real, const D: usize> EulerianRing<T, D> for Deflecting<'_, T, D> {
    #[inline(always)]
    fn forces(&self) -> RingForces<T, D> {
        self.forces_of(&self.sum)
    }
}

impl<T: Real, const D: usize> CellRing<T, D> for Deflecting<'_, T, D> {
    #[inline(always)]
    fn point(&self, at: usize, reference: ReferencePoint<T>) -> RingPoint<T, D> {
        RingPoint::new(reference, &self.geometry.point(at).shape, &self.element, self.motion)
    }

    #[inline(always)]
    fn own_load(&self, _at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T {
        ale::add_inertia(self.ring, point, load);
        ale::add_elasticity(self.ring, point, self.dilation, load)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>) {
        let shape = &self.geometry.point(at).shape;
        self.sum
            .add(&station_load.load, point, shape, &self.element, station_load.weight);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        ale::density(self.ring, point)
    }
}

impl<T: Real, const D: usize> VaryingRing<T, D> for Deflecting<'_, T, D> {
    type Sum = ElementLoad<T, D>;

    const MOVES: bool = true;

    #[inline(always)]
    fn vary(&self, at: usize, point: &RingPoint<T, D>, own: usize, factors: Factors) -> RingVariation<T, D> {
        let shape = &self.geometry.point(at).shape;
        let (node, component, is_slope) = node_direction::<D>(own);
        let function = 2 * node + usize::from(is_slope);
        let unknown = NodalUnknown { function, component };
        RingVariation::new(point, shape, &self.element, unknown, factors)
    }

    #[inline(always)]
    fn vary_own_load(
        &self,
        _at: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        _own: Option<usize>,
        load: &mut LineLoad<T, D>,
    ) -> T {
        ale::vary_inertia(self.ring, point, by, load);
        ale::vary_elasticity(self.ring, point, by, self.dilation, load)
    }

    #[inline(always)]
    fn empty(&self) -> ElementLoad<T, D> {
        ElementLoad::zero()
    }

    #[inline(always)]
    fn apply_varied(
        &self,
        sum: &mut ElementLoad<T, D>,
        at: usize,
        (point, by): (&RingPoint<T, D>, &RingVariation<T, D>),
        own_load: &LineLoad<T, D>,
        station_load: &StationLoad<T, D>,
    ) {
        let shape = &self.geometry.point(at).shape;
        sum.add(&station_load.load, point, shape, &self.element, station_load.weight);
        sum.theta += own_load.on_length(&by.slope, &by.bend, &self.element) * station_load.weight;
    }

    #[inline(always)]
    fn varied_forces(&self, sum: &ElementLoad<T, D>, own: Option<usize>, beta: f64) -> RingForces<T, D> {
        let mut forces = self.forces_of(sum);
        if let Some((node, k, true)) = own.map(node_direction::<D>) {
            forces.theta += self.sum.slope_varied(node, k, beta, &self.element);
        }
        forces
    }
}

/// Node and component of a direction of a ring that deflects, and whether it is the slope.
#[inline(always)]
fn node_direction<const D: usize>(own: usize) -> (usize, usize, bool) {
    (own / (2 * D), own / 2 % D, own % 2 == 1)
}
