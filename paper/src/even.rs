//! `ALE0` and `ALE` inside a cell on elements spaced evenly along the belt.

use crate::belts::EvenMesh;
use crate::reference_curve::{ReferenceCurve, ReferencePoint, Unaligned};
use crate::ring::kinematics::{LineLoad, RingPoint, RingVariation};
use crate::scalar::{Lanes, Real};
use crate::solver::Factors;
use pushbelt::variator::ring_models::{
    Ale, Ale0, CellRing, Deflecting, Degrees, Guided, RingDensity, RingForces, RingInput, RingKind,
    StateComponent, StationLoad, VaryingRing, nodes,
};

/// A ring of the variator with what differs on even elements.
pub trait EvenRing<T: Real, const D: usize>: VaryingRing<T, D> {
    /// [`CellRing::point`].
    fn even_point(&self, at: usize) -> RingPoint<T, D>;

    /// [`CellRing::apply`].
    fn apply_even(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>);

    /// [`VaryingRing::apply_varied`].
    fn apply_even_varied(
        &self,
        sum: &mut Self::Sum,
        at: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own_load: &LineLoad<T, D>,
        station_load: &StationLoad<T, D>,
    );
}

/// The unaligned curve at a point of a cell.
#[inline(always)]
fn reference<T: Real>(given: &RingInput<'_, T>, at: usize) -> ReferencePoint<T> {
    Unaligned::point(given.frame, given.segment, given.geometry.fraction(at))
}

impl<T: Real> EvenRing<T, 2> for Guided<'_, T> {
    #[inline(always)]
    fn even_point(&self, at: usize) -> RingPoint<T> {
        let RingInput { motion, frame, .. } = self.given;
        RingPoint::guided(reference(&self.given, at), motion, &frame.growth)
    }

    #[inline(always)]
    fn apply_even(&mut self, at: usize, point: &RingPoint<T>, station_load: &StationLoad<T>) {
        let RingInput { frame, geometry, .. } = self.given;
        let by = Unaligned::derivatives(frame, geometry.fraction(at), &point.reference);
        self.apply_along(&by, point, station_load);
    }

    #[inline(always)]
    fn apply_even_varied(
        &self,
        sum: &mut Self::Sum,
        at: usize,
        point: &RingPoint<T>,
        _by: &RingVariation<T>,
        _own_load: &LineLoad<T>,
        station_load: &StationLoad<T>,
    ) {
        let RingInput { frame, geometry, .. } = self.given;
        let by = Unaligned::derivatives(frame, geometry.fraction(at), &point.reference);
        sum.add_along(&by, point, station_load, |_| T::zero());
    }
}

impl<T: Real, const D: usize> EvenRing<T, D> for Deflecting<'_, T, D> {
    #[inline(always)]
    fn even_point(&self, at: usize) -> RingPoint<T, D> {
        let RingInput { geometry, motion, .. } = self.given;
        let shape = &geometry.point(at).shape;
        RingPoint::new(reference(&self.given, at), shape, &self.element, motion)
    }

    #[inline(always)]
    fn apply_even(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>) {
        self.apply(at, point, station_load);
    }

    #[inline(always)]
    fn apply_even_varied(
        &self,
        sum: &mut Self::Sum,
        at: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own_load: &LineLoad<T, D>,
        station_load: &StationLoad<T, D>,
    ) {
        self.apply_varied(sum, at, point, by, own_load, station_load);
    }
}

/// A ring of the variator on even elements.
#[derive(Debug)]
pub struct OnEven<R>(R);

impl<T: Real, R: EvenRing<T, D>, const D: usize> CellRing<T, D> for OnEven<R> {
    type Forces = RingForces<T, D>;

    #[inline(always)]
    fn point(&self, at: usize) -> RingPoint<T, D> {
        self.0.even_point(at)
    }

    #[inline(always)]
    fn own_load(&self, at: usize, point: &RingPoint<T, D>, load: &mut LineLoad<T, D>) -> T {
        self.0.own_load(at, point, load)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T, D>, station_load: &StationLoad<T, D>) {
        self.0.apply_even(at, point, station_load);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        self.0.density(point)
    }

    #[inline(always)]
    fn forces(&self) -> RingForces<T, D> {
        self.0.forces()
    }
}

impl<T: Real, R: EvenRing<T, D>, const D: usize> VaryingRing<T, D> for OnEven<R> {
    type Sum = R::Sum;

    const MOVES: bool = R::MOVES;

    #[inline(always)]
    fn vary(&self, at: usize, point: &RingPoint<T, D>, own: usize, factors: Factors) -> RingVariation<T, D> {
        self.0.vary(at, point, own, factors)
    }

    #[inline(always)]
    fn vary_own_load(
        &self,
        at: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own: Option<usize>,
        load: &mut LineLoad<T, D>,
    ) -> T {
        self.0.vary_own_load(at, point, by, own, load)
    }

    #[inline(always)]
    fn empty(&self) -> R::Sum {
        self.0.empty()
    }

    #[inline(always)]
    fn apply_varied(
        &self,
        sum: &mut R::Sum,
        at: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own_load: &LineLoad<T, D>,
        station_load: &StationLoad<T, D>,
    ) {
        self.0.apply_even_varied(sum, at, point, by, own_load, station_load);
    }

    #[inline(always)]
    fn varied_forces(&self, sum: &R::Sum, own: Option<usize>, beta: f64) -> RingForces<T, D> {
        self.0.varied_forces(sum, own, beta)
    }
}

impl RingKind<2> for EvenMesh<Ale0> {
    const DEGREES: Degrees = Ale0::DEGREES;

    type Ring<'a, T: Real> = OnEven<Guided<'a, T>>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        given: RingInput<'a, T>,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> OnEven<Guided<'a, T>> {
        OnEven(Guided::new(given, unknown))
    }

    #[inline(always)]
    fn by_hand<'r, 'a: 'r>(ring: &'r OnEven<Guided<'a, Lanes>>) -> Option<&'r impl VaryingRing<Lanes, 2>> {
        Some(ring)
    }
}

impl<const D: usize> RingKind<D> for EvenMesh<Ale<D>> {
    type Ring<'a, T: Real> = OnEven<Deflecting<'a, T, D>>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        given: RingInput<'a, T>,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> OnEven<Deflecting<'a, T, D>> {
        OnEven(Deflecting::new(given, &nodes(unknown)))
    }

    #[inline(always)]
    fn by_hand<'r, 'a: 'r>(
        ring: &'r OnEven<Deflecting<'a, Lanes, D>>,
    ) -> Option<&'r impl VaryingRing<Lanes, D>> {
        Some(ring)
    }
}
