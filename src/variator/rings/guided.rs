//! `ALE0`: the ring follows the reference curve, whose arcs have free centres.
//!
//! The curve has six coordinates p: Θ, spread, turn and shift of the centres, and growth δ
//! ([`TwoPulley`]). The virtual motion of a mesh point with p, ∂r/∂p|_η − ∂ξ/∂p|_η r', projects
//! loads on p. The curve holds derivatives along the motion in place of those with respect to Θ, so
//! its Θ̇ is one.
//!
//! The ring stretches as a whole, by γ = 2πδ/L with the energy ½ EA γ² L. The tension varies along
//! it by friction. Its mean over the arcs, by angle, is EA (γ + η γ̇); the balance of the forces
//! across, ∮(f·n − Tκ) dξ = 0, is the conjugate of δ, so the power of the stack on the growing loop
//! is balanced.
//!
//! [`TwoPulley`]: crate::reference_curve::TwoPulley

use crate::reference_curve::{COORDINATES, MeshCurve, PointDerivatives, ReferencePoint};
use crate::ring::Ring;
use crate::ring::ale::{self, RingDensity};
use crate::ring::kinematics::{LineLoad, Node, ReferenceMotion, RingPoint, RingVariation};
use crate::scalar::{Real, zero_vector};
use crate::solver::Factors;
use crate::variator::law::arguments::{CellGeometry, between, face_weight};
use crate::variator::rings::ring::{CellRing, EulerianRing, RingForces, StationLoad, VaryingRing};

/// Index of the growth among the coordinates of the curve. Its row is the mean of the tension.
const GROWTH: usize = COORDINATES - 1;

/// `ALE0`: the ring follows the reference curve; its tension is an unknown at the faces.
pub(crate) struct Guided<'a, T: Real, C: MeshCurve> {
    ring: &'a Ring,
    geometry: &'a CellGeometry<'a, T>,
    motion: &'a ReferenceMotion<T>,
    /// Frame and segment of the curve.
    curve: (&'a C::Frame<T>, usize),
    tension: [T; 2],
    sum: GuidedSum<T>,
}

/// Loads on a ring that follows the reference curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuidedSum<T: Real> {
    /// Conjugates of the coordinates of the curve.
    curve: [T; COORDINATES],
    /// Balance of the tension along the cell, and of normal forces around the loop, N.
    balance: T,
    across: T,
}

impl<T: Real> GuidedSum<T> {
    #[inline(always)]
    fn empty() -> Self {
        Self {
            curve: [T::zero(); COORDINATES],
            balance: T::zero(),
            across: T::zero(),
        }
    }

    #[inline(always)]
    fn forces<const D: usize>(&self) -> RingForces<T, D> {
        let still = Node {
            a: zero_vector(),
            b: zero_vector(),
        };
        let [theta, centres @ ..] = self.curve;
        RingForces {
            nodes: [still; 2],
            tension: self.balance,
            drift: self.across,
            theta,
            centres,
        }
    }
}

impl<'a, T: Real, C: MeshCurve> Guided<'a, T, C> {
    /// The ring `at` a place with this motion and the tensions at the two faces, N. `curve` is
    /// frame and segment.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        (geometry, motion): (&'a CellGeometry<'a, T>, &'a ReferenceMotion<T>),
        curve: (&'a C::Frame<T>, usize),
        tension: [T; 2],
    ) -> Self {
        Self {
            ring,
            geometry,
            motion,
            curve,
            tension,
            sum: GuidedSum {
                balance: tension[0] - tension[1],
                ..GuidedSum::empty()
            },
        }
    }

    /// EA (γ + η γ̇), N.
    #[inline(always)]
    fn mean_tension(&self) -> T {
        let strain = C::arcs(self.curve.0).strain;
        strain.v * self.ring.axial_stiffness + strain.d * self.ring.viscosity()
    }

    /// Adds the loads at a station; `own` is the derivative of the ring's own energy with respect
    /// to a coordinate of the shape, N.
    #[inline(always)]
    fn add(
        &self,
        sum: &mut GuidedSum<T>,
        at: usize,
        point: &RingPoint<T>,
        station_load: &StationLoad<T>,
        own: impl Fn(&PointDerivatives<T>) -> T,
    ) {
        let (frame, segment) = self.curve;
        let StationLoad { load, weight, .. } = station_load;
        let fraction = T::constant(self.geometry.fraction(at));
        let (shape, turn) = C::derivatives(frame, segment, fraction, &point.reference);
        let force = load.position;
        let [theta, spread] = shape.map(|by| force.dot(&by.r) - load.drift * by.xi + own(&by));
        let along = [theta, spread, force.dot(&turn), force.x, force.y];
        for (sum, along) in sum.curve.iter_mut().zip(along) {
            *sum += along * *weight;
        }
        let bearing = station_load.tension * point.reference.kappa * *weight;
        sum.curve[GROWTH] += bearing;
        sum.across += station_load.across * *weight - bearing;
        sum.balance += station_load.along * *weight;
    }
}

impl<T: Real, C: MeshCurve> EulerianRing<T> for Guided<'_, T, C> {
    #[inline(always)]
    fn forces(&self) -> RingForces<T> {
        self.sum.forces()
    }
}

impl<T: Real, C: MeshCurve> CellRing<T> for Guided<'_, T, C> {
    #[inline(always)]
    fn point(&self, _at: usize, reference: ReferencePoint<T>) -> RingPoint<T> {
        RingPoint::guided(reference, self.motion, &C::arcs(self.curve.0).growth)
    }

    #[inline(always)]
    fn own_load(&self, at: usize, point: &RingPoint<T>, load: &mut LineLoad<T>) -> T {
        ale::add_inertia(self.ring, point, load);
        between(&self.tension, self.geometry.point(at).right)
    }

    #[inline(always)]
    fn apply(&mut self, at: usize, point: &RingPoint<T>, station_load: &StationLoad<T>) {
        let kappa = point.reference.kappa;
        let moment = kappa * self.ring.bending_stiffness;
        let energy = moment * kappa * 0.5;
        let mut sum = self.sum;
        self.add(&mut sum, at, point, station_load, |by| {
            energy * by.dilation + moment * by.kappa
        });
        sum.curve[GROWTH] -= kappa * self.mean_tension() * station_load.weight;
        self.sum = sum;
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T>) -> RingDensity<T> {
        let strain = C::arcs(self.curve.0).strain;
        RingDensity {
            membrane: strain.v * strain.v * (0.5 * self.ring.axial_stiffness),
            viscous: strain.d * strain.d * self.ring.viscosity(),
            ..ale::density(self.ring, point)
        }
    }
}

/// The unknowns of the ring are the tensions at the faces.
impl<T: Real, C: MeshCurve> VaryingRing<T> for Guided<'_, T, C> {
    type Sum = GuidedSum<T>;

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
        ale::vary_inertia(self.ring, point, by, load);
        let right = self.geometry.point(at).right;
        own.map_or(T::zero(), |face| face_weight(face, right))
    }

    #[inline(always)]
    fn empty(&self) -> GuidedSum<T> {
        GuidedSum::empty()
    }

    #[inline(always)]
    fn apply_varied(
        &self,
        sum: &mut GuidedSum<T>,
        at: usize,
        (point, _): (&RingPoint<T>, &RingVariation<T>),
        _own_load: &LineLoad<T>,
        station_load: &StationLoad<T>,
    ) {
        self.add(sum, at, point, station_load, |_| T::zero());
    }

    #[inline(always)]
    fn varied_forces(&self, sum: &GuidedSum<T>, own: Option<usize>, _beta: f64) -> RingForces<T> {
        let mut forces = sum.forces();
        match own {
            Some(0) => forces.tension += T::one(),
            Some(_) => forces.tension -= T::one(),
            None => {}
        }
        forces
    }
}
