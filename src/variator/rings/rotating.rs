//! `ALE` whose overlay is counted along the directions of the reference curve.

use crate::reference_curve::{self, Jet, ReferencePoint};
use crate::ring::Ring;
use crate::ring::kinematics::{Load, Motion, Node, ReferenceMotion, RingPoint};
use crate::ring::rotated::{RotatedElement, rotated_load, rotated_point};
use crate::scalar::Real;
use crate::variator::law::place::Place;
use crate::variator::mesh::belt_mesh::SLOTS;
use crate::variator::rings::deflecting::Deflecting;
use crate::variator::rings::ring::{Action, CellRing, EulerianRing, RingDensity, RingForces};

/// `ALE` whose deflection is counted in directions that turn with the reference curve.
pub(crate) struct Rotating<'a, T: Real, const D: usize = 2> {
    ring: Deflecting<'a, T, D>,
    ends: RotatedElement<T>,
    curve: [reference_curve::TangentAngle<T>; SLOTS],
}

impl<'a, T: Real, const D: usize> Rotating<'a, T, D> {
    /// The ring between two nodes. `curve` gives angle and curvature of the reference curve at a fraction of the segment;
    /// `ends` are the fractions at which the element begins and ends.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        place: &'a Place<'a, T>,
        motion: &'a ReferenceMotion<T>,
        mut nodes: [Motion<Node<T, D>>; 2],
        ends: [T::Constant; 2],
        curve: impl Fn(T::Constant) -> reference_curve::TangentAngle<T>,
    ) -> Self {
        let curvature: [Jet<T>; 2] = ends.map(|fraction| curve(fraction).kappa);
        let ends = RotatedElement::new(curvature, &motion.theta, &mut nodes);
        Self {
            ring: Deflecting::new(ring, place, motion, &nodes),
            ends,
            curve: std::array::from_fn(|slot| curve(place.fraction(slot.min(place.stations.len())))),
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
    fn point(&self, slot: usize, reference: ReferencePoint<T>) -> RingPoint<T, D> {
        let Deflecting {
            place, element, motion, ..
        } = &self.ring;
        rotated_point(reference, &self.curve[slot], &place.slot(slot).shape, element, motion)
    }

    #[inline(always)]
    fn own_load(&self, slot: usize, point: &RingPoint<T, D>, load: &mut Load<T, D>) -> T {
        self.ring.own_load(slot, point, load)
    }

    #[inline(always)]
    fn apply(&mut self, slot: usize, point: &RingPoint<T, D>, action: &Action<T, D>) {
        let Deflecting {
            place,
            element,
            motion,
            sum,
            ..
        } = &mut self.ring;
        let shape = &place.slot(slot).shape;
        rotated_load(&action.load, point, shape, element, motion, action.weight, sum);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        self.ring.density(point)
    }
}
