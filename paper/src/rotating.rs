//! `ALE` with the overlay along the directions of the reference curve.

use crate::belts::Rotated;
use crate::reference_curve::{Jet, ReferenceCurve, TangentAngle, TwoPulley};
use crate::ring::kinematics::{LineLoad, RingPoint};
use crate::ring::rotated::{RotatedElement, rotated_load, rotated_point};
use crate::scalar::Real;
use pushbelt::variator::ring_models::{
    CellRing, Deflecting, Extent, RingDensity, RingForces, RingInput, RingKind, StateComponent, StationLoad,
    nodes,
};

/// `ALE` with the deflection in directions that rotate with the reference curve.
#[derive(Debug)]
pub struct Rotating<'a, T: Real, const D: usize = 2> {
    ring: Deflecting<'a, T, D>,
    ends: RotatedElement<T>,
}

impl<'a, T: Real, const D: usize> Rotating<'a, T, D> {
    /// The ring between two nodes.
    #[inline(always)]
    fn new(given: RingInput<'a, T>, unknown: impl Fn(StateComponent, usize) -> T) -> Self {
        let mut nodes = nodes(unknown);
        let Extent { start, length } = given.geometry.extent;
        let curvature: [Jet<T>; 2] = [start, start + length].map(|fraction| angle(&given, fraction).kappa);
        let ends = RotatedElement::new(curvature, &given.motion.theta, &mut nodes);
        Self {
            ring: Deflecting::new(given, &nodes),
            ends,
        }
    }
}

/// Angle and curvature of the reference curve at a fraction of the segment.
#[inline(always)]
fn angle<T: Real>(given: &RingInput<'_, T>, fraction: T::Constant) -> TangentAngle<T> {
    TwoPulley::tangent_angle(given.frame, given.segment, fraction)
}

impl<T: Real, const D: usize> CellRing<T, D> for Rotating<'_, T, D> {
    type Forces = RingForces<T, D>;

    #[inline(always)]
    fn point(&self, at: usize) -> RingPoint<T, D> {
        let Deflecting { given, element, .. } = &self.ring;
        let RingInput { geometry, motion, .. } = given;
        let angle = angle(given, geometry.fraction(at));
        let shape = &geometry.point(at).shape;
        rotated_point(given.reference(at), &angle, shape, element, motion)
    }

    #[inline(always)]
    fn own_load(&self, at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T {
        self.ring.own_load(at, point, load)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>) {
        let Deflecting {
            given, element, sum, ..
        } = &mut self.ring;
        let shape = &given.geometry.point(at).shape;
        rotated_load(&station_load.load, point, shape, element, station_load.weight, sum);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        self.ring.density(point)
    }

    #[inline(always)]
    fn forces(&self) -> RingForces<T, D> {
        let mut forces = self.ring.forces();
        let [left, right] = &mut forces.nodes;
        self.ends.nodes([left, right], &mut forces.curve.theta);
        forces
    }
}

impl<const D: usize> RingKind<D> for Rotated<D> {
    type Ring<'a, T: Real> = Rotating<'a, T, D>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        given: RingInput<'a, T>,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Rotating<'a, T, D> {
        Rotating::new(given, unknown)
    }
}
