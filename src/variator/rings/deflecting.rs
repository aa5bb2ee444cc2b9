//! `ALE`: the ring deflects from the reference curve.

use super::{CellRing, RingForces, RingInput, RingKind, StationLoad, VaryingRing};
use crate::ring::ale::{self, RingDensity};
use crate::ring::kinematics::{
    ElementLoad, ElementMotion, LineLoad, Motion, NodalUnknown, Node, RingPoint, RingVariation,
};
use crate::scalar::{Lanes, Real};
use crate::solver::Factors;
use crate::variator::law::arguments::StateComponent;
use nalgebra::SVector;

/// [`Ale`] inside a cell.
#[derive(Debug)]
pub struct Deflecting<'a, T: Real, const D: usize = 2> {
    /// Parameters, place and motion of the curve.
    pub given: RingInput<'a, T>,
    /// Motion of the element.
    pub element: ElementMotion<T, D>,
    /// (∂l/∂Θ)/l, l the length of the element.
    pub dilation: T,
    /// Sum of the applied loads.
    pub sum: ElementLoad<T, D>,
}

impl<'a, T: Real, const D: usize> Deflecting<'a, T, D> {
    /// The ring between two nodes.
    #[inline(always)]
    pub fn new(given: RingInput<'a, T>, nodes: &[Motion<Node<T, D>>; 2]) -> Self {
        let length = given.geometry.length;
        Self {
            given,
            element: ElementMotion::new(length, &given.motion.theta, nodes),
            dilation: length.d / length.v,
            sum: ElementLoad::zero(),
        }
    }

    #[inline(always)]
    fn forces_of(&self, sum: &ElementLoad<T, D>) -> RingForces<T, D> {
        let mut forces = RingForces::zero();
        (forces.nodes, forces.curve.theta) = sum.nodes(&self.element);
        forces.drift = sum.s;
        forces
    }
}

impl<T: Real, const D: usize> CellRing<T, D> for Deflecting<'_, T, D> {
    type Forces = RingForces<T, D>;

    #[inline(always)]
    fn point(&self, at: usize) -> RingPoint<T, D> {
        let RingInput { geometry, motion, .. } = self.given;
        let shape = &geometry.point(at).shape;
        RingPoint::new(self.given.reference(at), shape, &self.element, motion)
    }

    #[inline(always)]
    fn own_load(&self, _at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T {
        ale::add_inertia(self.given.ring, point, load);
        ale::add_elasticity(self.given.ring, point, self.dilation, load)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>) {
        let shape = &self.given.geometry.point(at).shape;
        self.sum
            .add(&station_load.load, point, shape, &self.element, station_load.weight);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        ale::density(self.given.ring, point)
    }

    #[inline(always)]
    fn forces(&self) -> RingForces<T, D> {
        self.forces_of(&self.sum)
    }
}

impl<T: Real, const D: usize> VaryingRing<T, D> for Deflecting<'_, T, D> {
    type Sum = ElementLoad<T, D>;

    const MOVES: bool = true;

    #[inline(always)]
    fn vary(&self, at: usize, point: &RingPoint<T, D>, own: usize, factors: Factors) -> RingVariation<T, D> {
        let shape = &self.given.geometry.point(at).shape;
        RingVariation::new(point, shape, &self.element, nodal_unknown::<D>(own), factors)
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
        ale::vary_inertia(self.given.ring, point, by, load);
        ale::vary_elasticity(self.given.ring, point, by, self.dilation, load)
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
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own_load: &LineLoad<T, D>,
        station_load: &StationLoad<T, D>,
    ) {
        let shape = &self.given.geometry.point(at).shape;
        sum.add(&station_load.load, point, shape, &self.element, station_load.weight);
        sum.theta += own_load.on_length(&by.slope, &by.bend, &self.element) * station_load.weight;
    }

    #[inline(always)]
    fn varied_forces(&self, sum: &ElementLoad<T, D>, own: Option<usize>, beta: f64) -> RingForces<T, D> {
        let mut forces = self.forces_of(sum);
        if let Some(NodalUnknown { function, component }) = own.map(nodal_unknown::<D>)
            && function % 2 == 1
        {
            forces.curve.theta += self.sum.slope_varied(function / 2, component, beta, &self.element);
        }
        forces
    }
}

/// `ALE`: the ring deflects in D components, 2 or 3, of fixed directions, A_i = identity in (10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ale<const D: usize = 2>;

impl<const D: usize> RingKind<D> for Ale<D> {
    type Ring<'a, T: Real> = Deflecting<'a, T, D>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        given: RingInput<'a, T>,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Deflecting<'a, T, D> {
        Deflecting::new(given, &nodes(unknown))
    }

    #[inline(always)]
    fn by_hand<'r, 'a: 'r>(ring: &'r Deflecting<'a, Lanes, D>) -> Option<&'r impl VaryingRing<Lanes, D>> {
        Some(ring)
    }
}

/// Motion of the nodes of a ring that deflects, from the `unknown` of a component and a degree of
/// freedom.
#[inline(always)]
pub fn nodes<T: Real, const D: usize>(
    unknown: impl Fn(StateComponent, usize) -> T,
) -> [Motion<Node<T, D>>; 2] {
    [0, 2 * D].map(|first| {
        let node = |component: StateComponent| Node {
            a: SVector::from_fn(|k, _| unknown(component, first + 2 * k)),
            b: SVector::from_fn(|k, _| unknown(component, first + 2 * k + 1)),
        };
        Motion {
            value: node(StateComponent::Position),
            rate: node(StateComponent::Value),
            acceleration: node(StateComponent::Rate),
        }
    })
}

/// Unknown `own` of the ring in a cell: shape functions 0 and 2 are deflections, 1 and 3 slopes.
#[inline(always)]
fn nodal_unknown<const D: usize>(own: usize) -> NodalUnknown {
    NodalUnknown {
        function: own / (2 * D) * 2 + own % 2,
        component: own / 2 % D,
    }
}
