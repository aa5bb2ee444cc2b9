//! `ALE` with the overlay along the directions of the reference curve.

use crate::reference_curve::{AngledCurve, Jet, ReferencePoint, TangentAngle};
use crate::ring::Ring;
use crate::ring::kinematics::{LineLoad, Motion, Node, ReferenceMotion, RingPoint};
use crate::ring::rotated::{RotatedElement, rotated_load, rotated_point};
use crate::scalar::Real;
use pushbelt::variator::ring_models::{
    CELL_POINTS, CellGeometry, CellRing, Deflecting, Degrees, DegreesOfFreedom, EulerianRing, Extent,
    MeshCurve, RingDensity, RingForces, RingKind, StateComponent, StationLoad, nodes,
};

/// `ALE` with the deflection in directions that rotate with the reference curve.
pub(crate) struct Rotating<'a, T: Real, const D: usize = 2> {
    ring: Deflecting<'a, T, D>,
    ends: RotatedElement<T>,
    curve: [TangentAngle<T>; CELL_POINTS],
}

impl<'a, T: Real, const D: usize> Rotating<'a, T, D> {
    /// The ring between two nodes. `curve` returns angle and curvature of the reference curve at a
    /// fraction of the segment; `ends` are the fractions at the ends of the element.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        geometry: &'a CellGeometry<'a, T>,
        motion: &'a ReferenceMotion<T>,
        mut nodes: [Motion<Node<T, D>>; 2],
        ends: [T::Constant; 2],
        curve: impl Fn(T::Constant) -> TangentAngle<T>,
    ) -> Self {
        let curvature: [Jet<T>; 2] = ends.map(|fraction| curve(fraction).kappa);
        let ends = RotatedElement::new(curvature, &motion.theta, &mut nodes);
        Self {
            ring: Deflecting::new(ring, geometry, motion, &nodes),
            ends,
            curve: std::array::from_fn(|at| curve(geometry.fraction(at.min(geometry.stations.len())))),
        }
    }
}

impl<T: Real, const D: usize> EulerianRing<T, D> for Rotating<'_, T, D> {
    #[inline(always)]
    fn forces(&self) -> RingForces<T, D> {
        let mut forces = self.ring.forces();
        let [left, right] = &mut forces.nodes;
        self.ends.nodes([left, right], &mut forces.theta);
        forces
    }
}

impl<T: Real, const D: usize> CellRing<T, D> for Rotating<'_, T, D> {
    #[inline(always)]
    fn point(&self, at: usize, reference: ReferencePoint<T>) -> RingPoint<T, D> {
        let Deflecting {
            geometry,
            element,
            motion,
            ..
        } = &self.ring;
        rotated_point(reference, &self.curve[at], &geometry.point(at).shape, element, motion)
    }

    #[inline(always)]
    fn own_load(&self, at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T {
        self.ring.own_load(at, point, load)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>) {
        let Deflecting {
            geometry,
            element,
            sum,
            ..
        } = &mut self.ring;
        let shape = &geometry.point(at).shape;
        rotated_load(&station_load.load, point, shape, element, station_load.weight, sum);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        self.ring.density(point)
    }
}

/// The ring deflects in D components along the directions of the reference curve, A_i = [t, n,
/// b]_ref in (10).
#[derive(Clone, Copy, Debug)]
pub(crate) struct RotatingRing<const D: usize>;

impl<const D: usize> DegreesOfFreedom for RotatingRing<D> {
    const DEGREES: Degrees = Degrees::deflecting(D);
}

impl<const D: usize, C: MeshCurve + AngledCurve> RingKind<D, C> for RotatingRing<D> {
    type Ring<'a, T: Real> = Rotating<'a, T, D>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        (geometry, motion): (&'a CellGeometry<'a, T>, &'a ReferenceMotion<T>),
        (frame, segment): (&'a C::Frame<T>, usize),
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Rotating<'a, T, D> {
        let Extent { start, length } = geometry.extent;
        let curve = |fraction| C::tangent_angle(frame, segment, fraction);
        let nodes = nodes(unknown);
        Rotating::new(ring, geometry, motion, nodes, [start, start + length], curve)
    }
}
