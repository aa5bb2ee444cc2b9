//! The ring inside a cell: what chain and contact see of a ring model, and where their loads on it go.
//!
//! [`balance`](super::cell::balance) asks any ring the same four questions and doesn't know which one it has.

use super::cell::{Place, SLOTS};
use crate::reference_curve::{self, Jet, ReferencePoint};
use crate::ring::kinematics::{
    ElementLoad, ElementMotion, Hermite, Load, Motion, Node, ReferenceMotion, RingPoint, RingVariation,
};
use crate::ring::rotated::{RotatedElement, rotated_load, rotated_point};
use crate::ring::{Ring, ale};
use crate::scalar::{Real, zero_vector};

/// Kind of an Eulerian ring: it keeps to the reference curve (`ALE0`).
pub const GUIDED: u8 = 0;
/// It deflects, counted in fixed directions: A_i = identity in (10).
pub const FIXED: u8 = 1;
/// It deflects, counted along the reference curve and across it: A_i = [t, n, b]_ref in (10).
pub const TURNING: u8 = 2;

/// What happens at a station, per dξ.
#[derive(Clone, Copy, Debug)]
pub struct Action<T: Real, const D: usize = 2> {
    /// Loads on the ring: its own, and those of chain and contact.
    pub load: Load<T, D>,
    /// Ring tension T, N.
    pub tension: T,
    /// All forces across the ring, inwards, N/m.
    pub across: T,
    /// The ring's own forces and the ring friction along it, N/m.
    pub along: T,
    /// Length dξ, m.
    pub weight: T,
}

/// Energies of the ring per dξ, J/m, and the power that its damping takes, W/m.
#[derive(Clone, Copy, Debug)]
pub struct RingDensity<T> {
    /// Kinetic energy.
    pub kinetic: T,
    /// Elastic energy.
    pub elastic: T,
    /// Power of damping.
    pub viscous: T,
}

/// A ring as a cell sees it. Slot 0 is the left face of the cell, the slots from 1 on are its stations.
pub trait CellRing<T: Real, const D: usize = 2> {
    /// The ring where the reference curve is at `reference`.
    fn point(&self, slot: usize, reference: ReferencePoint<T>) -> RingPoint<T, D>;

    /// Adds the forces that the ring exerts by itself, inertia included; returns its tension, N. A ring that balances
    /// these on elements of its own adds nothing.
    fn own_load(&self, slot: usize, point: &RingPoint<T, D>, load: &mut Load<T, D>) -> T;

    /// Takes the loads at a station.
    fn take(&mut self, slot: usize, point: &RingPoint<T, D>, action: &Action<T, D>);

    /// Energies at a station; none of a ring that counts them on elements of its own.
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T>;
}

/// A ring that tells how it varies in directions which leave the reference curve where it is: its own unknowns, and the
/// drift.
pub trait VaryingRing<T: Real, const D: usize = 2>: CellRing<T, D> {
    /// Sums of varied loads.
    type Sum;

    /// Whether the ring moves in its own directions.
    const MOVES: bool;

    /// How the ring varies at a slot in its own direction `own`; `slopes` are the factors of acceleration and position.
    fn vary(&self, slot: usize, point: &RingPoint<T, D>, own: usize, slopes: [f64; 2]) -> RingVariation<T, D>;

    /// Adds how [`CellRing::own_load`] varies; returns how the tension does. `own` as above, if it is such a direction.
    fn vary_own_load(
        &self,
        slot: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        own: Option<usize>,
        load: &mut Load<T, D>,
    ) -> T;

    /// No loads.
    fn empty(&self) -> Self::Sum;

    /// Takes the variation of [`CellRing::take`], where the ring's own load is `own_load`.
    fn take_varied(
        &self,
        sum: &mut Self::Sum,
        slot: usize,
        at: (&RingPoint<T, D>, &RingVariation<T, D>),
        own_load: &Load<T, D>,
        action: &Action<T, D>,
    );

    /// How its forces vary. A ring that moves must have taken the loads of the cell.
    fn varied_forces(&self, sum: &Self::Sum, own: Option<usize>, beta: f64) -> RingForces<T, D>;
}

/// Generalised forces of a cell on an Eulerian ring (inertia − forces).
#[derive(Clone, Copy, Debug)]
pub struct RingForces<T: Real, const D: usize = 2> {
    /// Conjugates of the node motions (`ALE`).
    pub nodes: [Node<T, D>; 2],
    /// Tension balance along the cell (`ALE0`), N.
    pub tension: T,
    /// Conjugate of s; in `ALE0` the normal balance around the loop, N.
    pub drift: T,
    /// Conjugate of Θ, N·m.
    pub theta: T,
}

/// `ALE`: the ring deflects from the reference curve, in D components.
#[derive(Debug)]
pub struct Deflecting<'a, T: Real, const D: usize = 2> {
    ring: &'a Ring,
    place: &'a Place<'a, T>,
    element: ElementMotion<T, D>,
    motion: &'a ReferenceMotion<T>,
    growth: T,
    sum: ElementLoad<T, D>,
}

impl<'a, T: Real, const D: usize> Deflecting<'a, T, D> {
    /// The ring between two nodes.
    #[inline(always)]
    pub fn new(
        ring: &'a Ring,
        place: &'a Place<'a, T>,
        motion: &'a ReferenceMotion<T>,
        nodes: &[Motion<Node<T, D>>; 2],
    ) -> Self {
        Self {
            ring,
            place,
            element: ElementMotion::flexible(place.length, &motion.theta, nodes),
            motion,
            growth: place.length.d / place.length.v,
            sum: ElementLoad::zero(),
        }
    }

    /// What it has taken.
    #[inline(always)]
    pub fn forces(&self) -> RingForces<T, D> {
        let (nodes, theta) = self.sum.nodes(&self.element);
        RingForces {
            nodes,
            tension: T::zero(),
            drift: self.sum.s,
            theta,
        }
    }
}

impl<T: Real, const D: usize> CellRing<T, D> for Deflecting<'_, T, D> {
    #[inline(always)]
    fn point(&self, slot: usize, reference: ReferencePoint<T>) -> RingPoint<T, D> {
        RingPoint::new(reference, &self.place.slot(slot).shape, &self.element, self.motion)
    }

    #[inline(always)]
    fn own_load(&self, _slot: usize, point: &RingPoint<T, D>, load: &mut Load<T, D>) -> T {
        ale::add_inertia(self.ring, point, load);
        ale::add_elasticity(self.ring, point, self.growth, load)
    }

    #[inline(always)]
    fn take(&mut self, slot: usize, point: &RingPoint<T, D>, action: &Action<T, D>) {
        let shape = &self.place.slot(slot).shape;
        self.sum.add(&action.load, point, shape, &self.element, action.weight);
    }

    #[inline(always)]
    fn density(&self, point: &RingPoint<T, D>) -> RingDensity<T> {
        RingDensity {
            kinetic: ale::kinetic_energy_density(self.ring, point),
            elastic: ale::energy_density(self.ring, point),
            viscous: ale::dissipation_density(self.ring, point),
        }
    }
}

impl<T: Real, const D: usize> VaryingRing<T, D> for Deflecting<'_, T, D> {
    type Sum = ElementLoad<T, D>;

    const MOVES: bool = true;

    #[inline(always)]
    fn vary(&self, slot: usize, point: &RingPoint<T, D>, own: usize, slopes: [f64; 2]) -> RingVariation<T, D> {
        let shape = &self.place.slot(slot).shape;
        let (node, k, is_slope) = node_direction::<D>(own);
        let which = [2 * node + usize::from(is_slope), k];
        RingVariation::of_node(point, shape, &self.element, self.motion, which, slopes)
    }

    #[inline(always)]
    fn vary_own_load(
        &self,
        _slot: usize,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        _own: Option<usize>,
        load: &mut Load<T, D>,
    ) -> T {
        ale::vary_inertia(self.ring, point, by, load);
        ale::vary_elasticity(self.ring, point, by, self.growth, load)
    }

    #[inline(always)]
    fn empty(&self) -> ElementLoad<T, D> {
        ElementLoad::zero()
    }

    #[inline(always)]
    fn take_varied(
        &self,
        sum: &mut ElementLoad<T, D>,
        slot: usize,
        (point, by): (&RingPoint<T, D>, &RingVariation<T, D>),
        own_load: &Load<T, D>,
        action: &Action<T, D>,
    ) {
        let shape = &self.place.slot(slot).shape;
        sum.add(&action.load, point, shape, &self.element, action.weight);
        sum.add_varied(own_load, by, &self.element, action.weight);
    }

    #[inline(always)]
    fn varied_forces(&self, sum: &ElementLoad<T, D>, own: Option<usize>, beta: f64) -> RingForces<T, D> {
        let (nodes, mut theta) = sum.nodes(&self.element);
        if let Some((node, k, true)) = own.map(node_direction::<D>) {
            theta += self.sum.slope_varied(node, k, beta, &self.element);
        }
        RingForces {
            nodes,
            tension: T::zero(),
            drift: sum.s,
            theta,
        }
    }
}

/// Node, component, and whether it is the slope, of a direction of a ring that deflects.
#[inline(always)]
fn node_direction<const D: usize>(own: usize) -> (usize, usize, bool) {
    (own / (2 * D), own / 2 % D, own % 2 == 1)
}

/// `ALE` whose deflection is counted in directions that turn with the reference curve.
pub struct Turning<'a, T: Real, const D: usize = 2> {
    ring: Deflecting<'a, T, D>,
    ends: RotatedElement<T>,
    curve: [reference_curve::TangentAngle<T>; SLOTS],
}

impl<'a, T: Real, const D: usize> Turning<'a, T, D> {
    /// The ring between two nodes; `curve` tells turning angle and curvature of the reference curve at a fraction of
    /// the segment, `ends` where on it the element begins and ends.
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

    /// What it has taken.
    #[inline(always)]
    pub fn forces(&self) -> RingForces<T, D> {
        let mut forces = self.ring.forces();
        let [left, right] = &mut forces.nodes;
        self.ends.nodes([left, right], &mut forces.theta);
        forces
    }
}

impl<T: Real, const D: usize> CellRing<T, D> for Turning<'_, T, D> {
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
    fn take(&mut self, slot: usize, point: &RingPoint<T, D>, action: &Action<T, D>) {
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

/// `ALE0`: the ring keeps to the reference curve; its tension is an unknown at the faces.
#[derive(Debug)]
pub struct Guided<'a, T: Real> {
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
pub struct GuidedSum<T: Real> {
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
    fn take(
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

    /// What it has taken.
    #[inline(always)]
    pub fn forces<const D: usize>(&self) -> RingForces<T, D> {
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
        super::cell::between(&self.tension, self.place.slot(slot).right)
    }

    #[inline(always)]
    fn take(&mut self, slot: usize, point: &RingPoint<T>, action: &Action<T>) {
        self.sum
            .take(&self.place.slot(slot).shape, point, &self.element, action);
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

/// Of the tensions at the faces, and what is taken under them.
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
        own.map_or(T::zero(), |face| super::cell::share(face, right))
    }

    #[inline(always)]
    fn empty(&self) -> GuidedSum<T> {
        GuidedSum::empty()
    }

    #[inline(always)]
    fn take_varied(
        &self,
        sum: &mut GuidedSum<T>,
        slot: usize,
        (point, _): (&RingPoint<T>, &RingVariation<T>),
        _own_load: &Load<T>,
        action: &Action<T>,
    ) {
        sum.take(&self.place.slot(slot).shape, point, &self.element, action);
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
