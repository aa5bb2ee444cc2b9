//! `ALE` with the overlay along the directions of the reference curve.

use crate::reference_curve::{AngledCurve, Jet, ReferencePoint, TangentAngle};
use crate::ring::Ring;
use crate::ring::kinematics::{LineLoad, Motion, Node, ReferenceMotion, RingPoint};
use crate::ring::rotated::{RotatedElement, rotated_load, rotated_point};
use crate::scalar::Real;
use pushbelt::variator::belt_ring::{
    Action, CELL_POINTS, CellRing, Deflecting, Degrees, DegreesOfFreedom, EulerianRing, MeshCurve, Part, Place,
    RingDensity, RingForces, RingKind, nodes,
};

/// `ALE` with the deflection in directions that rotate with the reference curve.
pub(crate) struct Rotating<'a, T: Real, const D: usize = 2> {
    ring: Deflecting<'a, T, D>,
    ends: RotatedElement<T>,
    curve: [TangentAngle<T>; CELL_POINTS],
}

impl<'a, T: Real, const D: usize> Rotating<'a, T, D> {
    /// The ring between two nodes. `curve` returns angle and curvature of the reference curve at a fraction of the segment;
    /// `ends` are the fractions at the ends of the element.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        place: &'a Place<'a, T>,
        motion: &'a ReferenceMotion<T>,
        mut nodes: [Motion<Node<T, D>>; 2],
        ends: [T::Constant; 2],
        curve: impl Fn(T::Constant) -> TangentAngle<T>,
    ) -> Self {
        let curvature: [Jet<T>; 2] = ends.map(|fraction| curve(fraction).kappa);
        let ends = RotatedElement::new(curvature, &motion.theta, &mut nodes);
        Self {
            ring: Deflecting::new(ring, place, motion, &nodes),
            ends,
            curve: std::array::from_fn(|at| curve(place.fraction(at.min(place.stations.len())))),
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
            place, element, motion, ..
        } = &self.ring;
        rotated_point(reference, &self.curve[at], &place.point(at).shape, element, motion)
    }

    #[inline(always)]
    fn own_load(&self, at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T {
        self.ring.own_load(at, point, load)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, action: &Action<T, D>) {
        let Deflecting {
            place, element, sum, ..
        } = &mut self.ring;
        let shape = &place.point(at).shape;
        rotated_load(&action.load, point, shape, element, action.weight, sum);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        self.ring.density(point)
    }
}

/// The ring deflects in D components along the directions of the reference curve, A_i = [t, n, b]_ref in (10).
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
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        (frame, segment): (&'a C::Frame<T>, usize),
        unknown: impl Fn(Part, usize) -> T,
    ) -> Rotating<'a, T, D> {
        let [start, share] = place.of_segment;
        let curve = |fraction| C::tangent_angle(frame, segment, fraction);
        let nodes = nodes(unknown);
        Rotating::new(ring, place, motion, nodes, [start, start + share], curve)
    }
}
