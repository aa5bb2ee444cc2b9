//! `ALE0`: the ring follows the reference curve, whose arcs have free centres.
//!
//! The curve has six coordinates p: Θ, spread, turn and shift of the centres, and growth δ ([`Displaced`]). The virtual motion of a
//! mesh point with p, ∂r/∂p|_η − ∂ξ/∂p|_η r', projects loads on p. The curve holds derivatives along the motion in place of
//! those with respect to Θ, so its Θ̇ is one.
//!
//! The ring stretches as a whole, by γ = 2πδ/L with the energy ½ EA γ² L. The tension varies along it by friction. Its mean over the
//! arcs, by angle, is EA (γ + η γ̇); the balance of the forces across, ∮(f·n − Tκ) dξ = 0, is the conjugate of δ, so the power of the
//! stack on the growing loop is balanced.
//!
//! [`Displaced`]: crate::reference_curve::Displaced

use crate::reference_curve::{COORDINATES, DisplacedCurve, ReferencePoint};
use crate::ring::kinematics::{LineLoad, Node, ReferenceMotion, RingPoint};
use crate::ring::{Ring, ale};
use crate::scalar::{Real, zero_vector};
use crate::variator::law::place::{Place, between};
use crate::variator::rings::ring::{Action, CellRing, EulerianRing, RingDensity, RingForces};

/// Place of the growth among the coordinates of the curve. Its row is the mean of the tension.
const GROWTH: usize = COORDINATES - 1;

/// `ALE0`: the ring follows the reference curve; its tension is an unknown at the faces.
pub(crate) struct Guided<'a, T: Real, C: DisplacedCurve> {
    ring: &'a Ring,
    place: &'a Place<'a, T>,
    motion: &'a ReferenceMotion<T>,
    /// Frame and segment of the curve.
    curve: (&'a C::Frame<T>, usize),
    tension: [T; 2],
    /// Whether its own energy acts.
    has_energy: bool,
    sum: GuidedSum<T>,
}

impl<T: Real, C: DisplacedCurve> Clone for Guided<'_, T, C> {
    #[inline(always)]
    fn clone(&self) -> Self {
        Self { ..*self }
    }
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
}

impl<'a, T: Real, C: DisplacedCurve> Guided<'a, T, C> {
    /// The ring `at` a place with this motion and the tensions at the two faces, N. `curve` is frame and segment.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        curve: (&'a C::Frame<T>, usize),
        tension: [T; 2],
    ) -> Self {
        Self {
            ring,
            place,
            motion,
            curve,
            tension,
            has_energy: true,
            sum: GuidedSum {
                balance: tension[0] - tension[1],
                ..GuidedSum::empty()
            },
        }
    }

    /// EA (γ + η γ̇), N.
    #[inline(always)]
    fn mean_tension(&self) -> T {
        let [_, strain] = C::growth(self.curve.0);
        strain.v * self.ring.axial_stiffness + strain.d * self.ring.viscosity()
    }
}

impl<T: Real, C: DisplacedCurve> EulerianRing<T> for Guided<'_, T, C> {
    #[inline(always)]
    fn forces(&self) -> RingForces<T> {
        let still = Node {
            a: zero_vector(),
            b: zero_vector(),
        };
        let [theta, centres @ ..] = self.sum.curve;
        RingForces {
            nodes: [still; 2],
            tension: self.sum.balance,
            drift: self.sum.across,
            theta,
            centres,
        }
    }

    #[inline(always)]
    fn under_loads_alone(&self) -> Self {
        Self {
            has_energy: false,
            sum: GuidedSum::empty(),
            ..*self
        }
    }
}

impl<T: Real, C: DisplacedCurve> CellRing<T> for Guided<'_, T, C> {
    #[inline(always)]
    fn point(&self, _slot: usize, reference: ReferencePoint<T>) -> RingPoint<T> {
        RingPoint::guided(reference, self.motion, &C::growth(self.curve.0)[0])
    }

    #[inline(always)]
    fn own_load(&self, slot: usize, point: &RingPoint<T>, load: &mut LineLoad<T>) -> T {
        ale::add_inertia(self.ring, point, load);
        between(&self.tension, self.place.slot(slot).right)
    }

    #[inline(always)]
    fn apply(&mut self, slot: usize, point: &RingPoint<T>, action: &Action<T>) {
        let (frame, segment) = self.curve;
        let Action { load, weight, .. } = action;
        let by = C::slopes(frame, segment, self.place.fraction(slot), &point.reference);
        let (force, kappa) = (load.position, point.reference.kappa);
        let (moment, mean_tension) = if self.has_energy {
            (kappa * self.ring.bending_stiffness, self.mean_tension())
        } else {
            (T::zero(), T::zero())
        };
        let energy = moment * kappa * 0.5;
        let [theta, spread] = (by.shape.each_ref())
            .map(|by| force.dot(&by.r) - load.drift * by.xi + (energy * by.growth + moment * by.kappa));
        let sum = &mut self.sum;
        for (sum, along) in sum
            .curve
            .iter_mut()
            .zip([theta, spread, force.dot(&by.turn), force.x, force.y])
        {
            *sum += along * *weight;
        }
        let bearing = action.tension * kappa * *weight;
        sum.curve[GROWTH] += bearing;
        sum.across += action.across * *weight - bearing;
        sum.balance += action.along * *weight;
        sum.curve[GROWTH] -= kappa * mean_tension * *weight;
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T>) -> RingDensity<T> {
        let [_, strain] = C::growth(self.curve.0);
        RingDensity {
            kinetic: ale::kinetic_energy_density(self.ring, point),
            elastic: strain.v * strain.v * (0.5 * self.ring.axial_stiffness)
                + ale::bending_energy_density(self.ring, point),
            viscous: strain.d * strain.d * self.ring.viscosity(),
        }
    }
}
