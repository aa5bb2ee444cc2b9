//! `ALE0`: the ring keeps to the reference curve.

use crate::reference_curve::ReferencePoint;
use crate::ring::kinematics::{
    ElementLoad, ElementMotion, Hermite, Load, Node, ReferenceMotion, RingPoint, RingVariation,
};
use crate::ring::{Ring, ale};
use crate::scalar::{Real, zero_vector};
use crate::variator::law::place::{Place, between, share};
use crate::variator::rings::ring::{Action, CellRing, EulerianRing, RingDensity, RingForces, VaryingRing};

/// `ALE0`: the ring keeps to the reference curve; its tension is an unknown at the faces.
#[derive(Debug)]
pub(crate) struct Guided<'a, T: Real> {
    ring: &'a Ring,
    place: &'a Place<'a, T>,
    element: ElementMotion<T>,
    motion: &'a ReferenceMotion<T>,
    growth: T,
    tension: [T; 2],
    sum: GuidedSum<T>,
}

/// Loads on a ring that keeps to the reference curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuidedSum<T: Real> {
    element: ElementLoad<T>,
    /// Balance of the tension along the cell, and of normal forces around the loop, N.
    balance: T,
    across: T,
}

impl<T: Real> GuidedSum<T> {
    #[inline(always)]
    fn empty() -> Self {
        Self {
            element: ElementLoad::zero(),
            balance: T::zero(),
            across: T::zero(),
        }
    }

    #[inline(always)]
    fn apply(
        &mut self,
        shape: &Hermite<T::Constant>,
        point: &RingPoint<T>,
        element: &ElementMotion<T>,
        action: &Action<T>,
    ) {
        self.element.add(&action.load, point, shape, element, action.weight);
        self.across += (action.across - action.tension * point.reference.kappa) * action.weight;
        self.balance += action.along * action.weight;
    }

    #[inline(always)]
    fn forces<const D: usize>(&self) -> RingForces<T, D> {
        let still = Node {
            a: zero_vector(),
            b: zero_vector(),
        };
        RingForces {
            nodes: [still; 2],
            tension: self.balance,
            drift: self.across,
            theta: self.element.theta,
        }
    }
}

impl<'a, T: Real> Guided<'a, T> {
    /// The ring under the tensions at the two faces, N.
    #[inline(always)]
    pub fn new(ring: &'a Ring, place: &'a Place<'a, T>, motion: &'a ReferenceMotion<T>, tension: [T; 2]) -> Self {
        let element = ElementMotion::rigid(place.length);
        Self {
            ring,
            place,
            element,
            motion,
            growth: place.length.d / place.length.v,
            tension,
            sum: GuidedSum {
                balance: tension[0] - tension[1],
                ..GuidedSum::empty()
            },
        }
    }
}

impl<T: Real> EulerianRing<T> for Guided<'_, T> {
    #[inline(always)]
    fn forces(&self) -> RingForces<T> {
        self.sum.forces()
    }
}

impl<T: Real> CellRing<T> for Guided<'_, T> {
    #[inline(always)]
    fn point(&self, _slot: usize, reference: ReferencePoint<T>) -> RingPoint<T> {
        RingPoint::guided(reference, self.motion)
    }

    #[inline(always)]
    fn own_load(&self, slot: usize, point: &RingPoint<T>, load: &mut Load<T>) -> T {
        ale::add_inertia(self.ring, point, load);
        load.theta += ale::energy_density(self.ring, point) * self.growth
            + point.reference.kappa * point.reference.kappa_theta * self.ring.bending_stiffness;
        between(&self.tension, self.place.slot(slot).right)
    }

    #[inline(always)]
    fn apply(&mut self, slot: usize, point: &RingPoint<T>, action: &Action<T>) {
        self.sum
            .apply(&self.place.slot(slot).shape, point, &self.element, action);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T>) -> RingDensity<T> {
        RingDensity {
            kinetic: ale::kinetic_energy_density(self.ring, point),
            elastic: ale::energy_density(self.ring, point),
            viscous: T::zero(),
        }
    }
}

/// The ring's own unknowns are the tensions at the faces.
impl<T: Real> VaryingRing<T> for Guided<'_, T> {
    type Sum = GuidedSum<T>;

    const MOVES: bool = false;

    #[inline(always)]
    fn vary(&self, _slot: usize, _point: &RingPoint<T>, _own: usize, _slopes: [f64; 2]) -> RingVariation<T> {
        RingVariation::none()
    }

    #[inline(always)]
    fn vary_own_load(
        &self,
        slot: usize,
        point: &RingPoint<T>,
        by: &RingVariation<T>,
        own: Option<usize>,
        load: &mut Load<T>,
    ) -> T {
        ale::vary_inertia(self.ring, point, by, load);
        let right = self.place.slot(slot).right;
        own.map_or(T::zero(), |face| share(face, right))
    }

    #[inline(always)]
    fn empty(&self) -> GuidedSum<T> {
        GuidedSum::empty()
    }

    #[inline(always)]
    fn apply_varied(
        &self,
        sum: &mut GuidedSum<T>,
        slot: usize,
        (point, _): (&RingPoint<T>, &RingVariation<T>),
        _own_load: &Load<T>,
        action: &Action<T>,
    ) {
        sum.apply(&self.place.slot(slot).shape, point, &self.element, action);
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
