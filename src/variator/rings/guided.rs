//! `ALE0`: the ring follows the reference curve, whose arcs have free centres (`docs/theory.md`,
//! (3.8) and (3.9)).
//!
//! The virtual motion of a mesh point with a coordinate p of the curve, ∂r/∂p|_η − ∂ξ/∂p|_η r',
//! projects loads on p. The curve holds derivatives along the motion in place of those with respect
//! to Θ, so its Θ̇ is one. The ring stretches as a whole, by γ = 2πδ/L with the growth δ.

use super::{CellRing, Degrees, RingForces, RingInput, RingKind, StationLoad, VaryingRing};
use crate::reference_curve::{CoordinateDerivatives, PointDerivatives};
use crate::ring::ale::{self, RingDensity};
use crate::ring::kinematics::{LineLoad, RingPoint, RingVariation};
use crate::scalar::{Lanes, Real};
use crate::solver::Factors;
use crate::variator::law::arguments::{StateComponent, between, face_weight};

/// [`Ale0`] inside a cell; its tension is an unknown at the faces.
#[derive(Debug)]
pub struct Guided<'a, T: Real> {
    /// Parameters, place and motion of the curve.
    pub given: RingInput<'a, T>,
    /// At the two faces, N.
    tension: [T; 2],
    sum: RingForces<T>,
}

/// `ALE0`: the ring follows the reference curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ale0;

impl RingKind<2> for Ale0 {
    const DEGREES: Degrees = Degrees::deflecting(0);

    type Ring<'a, T: Real> = Guided<'a, T>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        given: RingInput<'a, T>,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Guided<'a, T> {
        Guided::new(given, unknown)
    }

    #[inline(always)]
    fn by_hand<'r, 'a: 'r>(ring: &'r Guided<'a, Lanes>) -> Option<&'r impl VaryingRing<Lanes, 2>> {
        Some(ring)
    }
}

impl<'a, T: Real> Guided<'a, T> {
    /// The ring inside a cell, from the `unknown` of a component and a degree of freedom.
    #[inline(always)]
    pub fn new(given: RingInput<'a, T>, unknown: impl Fn(StateComponent, usize) -> T) -> Self {
        let tension = [1, 2].map(|k| unknown(StateComponent::Value, Ale0::DEGREES.content + k));
        let mut sum = RingForces::zero();
        sum.tension = tension[0] - tension[1];
        Self { given, tension, sum }
    }

    /// EA (γ + η γ̇), N.
    #[inline(always)]
    fn mean_tension(&self) -> T {
        let RingInput { ring, frame, .. } = self.given;
        frame.strain.v * ring.axial_stiffness + frame.strain.d * ring.viscosity()
    }

    #[inline(always)]
    fn derivatives(&self, at: usize, point: &RingPoint<T>) -> CoordinateDerivatives<T> {
        let fraction = T::constant(self.given.geometry.fraction(at));
        self.given
            .frame
            .derivatives(self.given.segment, fraction, &point.reference)
    }

    /// Applies the loads at a station where the curve has the derivatives `by`.
    #[inline(always)]
    pub fn apply_along(
        &mut self,
        by: &CoordinateDerivatives<T>,
        point: &RingPoint<T>,
        station_load: &StationLoad<T>,
    ) {
        let kappa = point.reference.kappa;
        let moment = kappa * self.given.ring.bending_stiffness;
        let energy = moment * kappa * 0.5;
        self.sum
            .add_along(by, point, station_load, |by| energy * by.dilation + moment * by.kappa);
        self.sum.curve.growth -= kappa * self.mean_tension() * station_load.weight;
    }
}

impl<T: Real> RingForces<T> {
    /// Adds the loads at a station where the curve has the derivatives `by`; `own` is the
    /// derivative of the ring's own energy with respect to a coordinate of the shape, N. The row of
    /// the growth is the mean of the tension.
    #[inline(always)]
    pub fn add_along(
        &mut self,
        by: &CoordinateDerivatives<T>,
        point: &RingPoint<T>,
        station_load: &StationLoad<T>,
        own: impl Fn(&PointDerivatives<T>) -> T,
    ) {
        let StationLoad { load, weight, .. } = station_load;
        let force = load.position;
        let along = |by: &PointDerivatives<T>| (force.dot(&by.r) - load.drift * by.xi + own(by)) * *weight;
        let bearing = station_load.tension * point.reference.kappa * *weight;
        self.curve.theta += along(&by.theta);
        self.curve.spread += along(&by.spread);
        self.curve.turn += force.dot(&by.turn) * *weight;
        self.curve.shift[0] += force.x * *weight;
        self.curve.shift[1] += force.y * *weight;
        self.curve.growth += bearing;
        self.drift += station_load.across * *weight - bearing;
        self.tension += station_load.along * *weight;
    }
}

impl<T: Real> CellRing<T> for Guided<'_, T> {
    type Forces = RingForces<T>;

    #[inline(always)]
    fn point(&self, at: usize) -> RingPoint<T> {
        RingPoint::guided(self.given.reference(at), self.given.motion, &self.given.frame.growth)
    }

    #[inline(always)]
    fn own_load(&self, at: usize, point: &RingPoint<T>, load: &mut LineLoad<T>) -> T {
        ale::add_inertia(self.given.ring, point, load);
        between(&self.tension, self.given.geometry.point(at).right)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T>, station_load: &StationLoad<T>) {
        self.apply_along(&self.derivatives(at, point), point, station_load);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T>) -> RingDensity<T> {
        let RingInput { ring, frame, .. } = self.given;
        let strain = frame.strain;
        RingDensity {
            membrane: strain.v * strain.v * (0.5 * ring.axial_stiffness),
            viscous: strain.d * strain.d * ring.viscosity(),
            ..ale::density(ring, point)
        }
    }

    #[inline(always)]
    fn forces(&self) -> RingForces<T> {
        self.sum
    }
}

/// Its own unknowns are the tensions.
impl<T: Real> VaryingRing<T> for Guided<'_, T> {
    type Sum = RingForces<T>;

    const MOVES: bool = false;

    #[inline(always)]
    fn vary(&self, _at: usize, _point: &RingPoint<T>, _own: usize, _factors: Factors) -> RingVariation<T> {
        RingVariation::none()
    }

    #[inline(always)]
    fn vary_own_load(
        &self,
        at: usize,
        point: &RingPoint<T>,
        by: &RingVariation<T>,
        own: Option<usize>,
        load: &mut LineLoad<T>,
    ) -> T {
        ale::vary_inertia(self.given.ring, point, by, load);
        let right = self.given.geometry.point(at).right;
        own.map_or(T::zero(), |face| face_weight(face, right))
    }

    #[inline(always)]
    fn empty(&self) -> RingForces<T> {
        RingForces::zero()
    }

    #[inline(always)]
    fn apply_varied(
        &self,
        sum: &mut RingForces<T>,
        at: usize,
        point: &RingPoint<T>,
        _by: &RingVariation<T>,
        _own_load: &LineLoad<T>,
        station_load: &StationLoad<T>,
    ) {
        sum.add_along(&self.derivatives(at, point), point, station_load, |_| T::zero());
    }

    #[inline(always)]
    fn varied_forces(&self, sum: &RingForces<T>, own: Option<usize>, _beta: f64) -> RingForces<T> {
        let mut forces = *sum;
        match own {
            Some(0) => forces.tension += T::one(),
            Some(_) => forces.tension -= T::one(),
            None => {}
        }
        forces
    }
}
