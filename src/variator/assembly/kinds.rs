//! Kinds of ring as types, chosen once at the start: the motion of a cell with them from its
//! unknowns, its balance and the rows of the balance, generic over the scalar.

use crate::reference_curve::{MeshCurve, Path, TwoPulley, along_theta};
use crate::ring::Ring;
use crate::ring::kinematics::{Motion, Node, ReferenceMotion};
use crate::scalar::{Lanes, Real};
use crate::variator::assembly::pack::Pack;
use crate::variator::belt::equations::InForce;
use crate::variator::cell::balance::balance;
use crate::variator::cell::degrees::{DeflectingRing, DegreesOfFreedom, GuidedRing, MOST_ROWS};
use crate::variator::cell::sample::AtStation;
use crate::variator::cell::state::{CellPoints, CellState};
use crate::variator::law::arguments::{
    CellBalance, CellGeometry, CellInput, CellMotion, FirstUnknowns, StateComponent,
};
use crate::variator::rings::deflecting::Deflecting;
use crate::variator::rings::guided::Guided;
use crate::variator::rings::ring::{EulerianRing, RingForces, VaryingRing};
use nalgebra::SVector;

/// A ring on an Eulerian mesh in D components, on the curve `C`. A value of it holds parameters of
/// the ring beyond those of the beam.
pub trait RingKind<const D: usize, C: MeshCurve>: DegreesOfFreedom {
    /// The ring inside a cell.
    type Ring<'a, T: Real>: EulerianRing<T, D>;

    /// The ring between two nodes of a cell `at` a place and a reference motion, from the `unknown`
    /// of a part and a degree of freedom of the cell. `curve` is frame and segment of the reference
    /// curve.
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        at: (&'a CellGeometry<'a, T>, &'a ReferenceMotion<T>),
        curve: (&'a C::Frame<T>, usize),
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Self::Ring<'a, T>;

    /// The ring itself, if its derivatives are written by hand.
    #[doc(hidden)]
    fn by_hand<'r, 'a: 'r>(_ring: &'r Self::Ring<'a, Lanes>) -> Option<&'r impl VaryingRing<Lanes, D>> {
        None::<&Deflecting<'a, Lanes, D>>
    }
}

impl<C: MeshCurve> RingKind<2, C> for GuidedRing {
    type Ring<'a, T: Real> = Guided<'a, T, C>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        (geometry, motion): (&'a CellGeometry<'a, T>, &'a ReferenceMotion<T>),
        curve: (&'a C::Frame<T>, usize),
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Guided<'a, T, C> {
        let after = Self::DEGREES.content;
        let tension = [1, 2].map(|k| unknown(StateComponent::Value, after + k));
        Guided::new(ring, (geometry, motion), curve, tension)
    }

    #[inline(always)]
    fn by_hand<'r, 'a: 'r>(ring: &'r Guided<'a, Lanes, C>) -> Option<&'r impl VaryingRing<Lanes, 2>> {
        Some(ring)
    }
}

impl<const D: usize, C: MeshCurve> RingKind<D, C> for DeflectingRing<D> {
    type Ring<'a, T: Real> = Deflecting<'a, T, D>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        (geometry, motion): (&'a CellGeometry<'a, T>, &'a ReferenceMotion<T>),
        _: (&'a C::Frame<T>, usize),
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> Deflecting<'a, T, D> {
        Deflecting::new(ring, geometry, motion, &nodes(unknown))
    }

    #[inline(always)]
    fn by_hand<'r, 'a: 'r>(ring: &'r Deflecting<'a, Lanes, D>) -> Option<&'r impl VaryingRing<Lanes, D>> {
        Some(ring)
    }
}

/// The frame of the curve at one place of a path, which a ring of kind `K` follows: with the motion
/// of Θ as the variable, unless the curve has other coordinates.
#[inline(always)]
pub(crate) fn frame<T: Real, K: DegreesOfFreedom, C: MeshCurve>(
    curve: &TwoPulley,
    mut path: Path<T>,
) -> C::Frame<T> {
    if K::DEGREES.coordinates == 1 {
        path = along_theta(path[0].v);
    }
    C::on_path(curve, &path)
}

/// The balance of a pack of cells with this kind of ring, from the `unknown` of a part and a
/// direction, and what `then` returns for the loaded ring.
#[inline(always)]
pub(crate) fn pack_balance<T: Real<Constant = Lanes>, K: RingKind<D, C>, const D: usize, C: MeshCurve, O>(
    InForce { belt, friction }: InForce<'_>,
    (kind, pack): (&K, &Pack),
    frame: &C::Frame<T>,
    unknown: impl Fn(StateComponent, usize) -> T,
    observe: impl FnMut(&AtStation<'_, T, D>),
    then: impl FnOnce(&K::Ring<'_, T>, (CellInput<'_, T>, CellState<T>, &CellPoints<T, D>)) -> O,
) -> (CellBalance<T>, O) {
    let law = &belt.law;
    let motion = motion::<T, K>(&unknown);
    let geometry = pack.geometry::<T, C>(law, frame);
    let reference = |at: usize| C::point(frame, pack.segment, geometry.fraction(at));
    let curve = (frame, pack.segment);
    let mut ring = kind.ring::<T>(&law.ring, (&geometry, &motion.reference), curve, &unknown);
    let given = CellInput {
        law,
        friction,
        geometry: &geometry,
        motion: &motion,
    };
    let mut points = CellPoints::empty();
    let (b, cell) = balance(&given, &mut ring, reference, &mut points, observe);
    (b, then(&ring, (given, cell, &points)))
}

/// Motion of the nodes (`ALE`), from the `unknown` of a part and a direction.
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

/// Motion of a cell, from the `unknown` of a part and a direction.
#[inline(always)]
pub(crate) fn motion<T: Real, K: DegreesOfFreedom>(
    unknown: impl Fn(StateComponent, usize) -> T,
) -> CellMotion<T> {
    let degrees = K::DEGREES;
    let first = FirstUnknowns {
        own: degrees.nodes,
        drift: degrees.drift,
        sheave: degrees.sheave,
    };
    let mut motion = CellMotion::from_unknowns(first, unknown);
    if degrees.coordinates > 1 {
        // The curve holds derivatives along the motion, so time replaces Θ.
        (motion.reference.theta.rate, motion.reference.theta.acceleration) = (T::one(), T::zero());
    }
    motion
}

/// Rows of the balance in the order of the directions, then the resultant of the contact forces.
/// The row of the content is zero; its balance is that of the fluxes.
#[inline(always)]
pub(crate) fn rows<T: Real, K: DegreesOfFreedom, const D: usize>(
    b: &CellBalance<T>,
    ring: &RingForces<T, D>,
) -> [T; MOST_ROWS] {
    let degrees = K::DEGREES;
    let mut rows = [T::zero(); MOST_ROWS];
    for (node, rows) in ring.nodes.iter().zip(rows[..degrees.nodes].chunks_exact_mut(2 * D)) {
        for k in 0..D {
            [rows[2 * k], rows[2 * k + 1]] = [node.a[k], node.b[k]];
        }
    }
    rows[degrees.nodes..][..2].copy_from_slice(&b.speed);
    if degrees.tensions > 0 {
        rows[degrees.content + 1] = ring.tension;
    }
    rows[degrees.drift] = ring.drift;
    rows[degrees.theta] = ring.theta;
    let centres = degrees.coordinates - 1;
    rows[degrees.theta + 1..][..centres].copy_from_slice(&ring.centres[..centres]);
    let of_pulley = [
        b.pulley.axial,
        -b.pulley.tilting[0],
        -b.pulley.tilting[1],
        -b.pulley.torque,
    ];
    rows[degrees.sheave..degrees.count].copy_from_slice(&of_pulley);
    rows[degrees.count..degrees.rows].copy_from_slice(&b.pulley.resultant);
    rows
}
