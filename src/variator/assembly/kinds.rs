//! Kinds of ring as types, chosen once at the start, and the balance of a pack of cells with them, generic over the scalar.

use crate::reference_curve::{COORDINATES, Jet, MeshCurve, Path, TwoPulley};
use crate::ring::Ring;
use crate::ring::kinematics::ReferenceMotion;
use crate::scalar::{Lanes, Real};
use crate::variator::assembly::derivatives::Columns;
use crate::variator::assembly::pack::Pack;
use crate::variator::assembly::unknowns::{Unknowns, motion, nodes, tensions};
use crate::variator::belt::equations::InForce;
use crate::variator::cell::balance::balance;
use crate::variator::cell::directions::{DeflectingRing, Directions, GuidedRing};
use crate::variator::cell::sample::AtStation;
use crate::variator::cell::state::{CellInput, Slots};
use crate::variator::cell::variation::Evaluated;
use crate::variator::law::place::{CellBalance, Place};
use crate::variator::rings::deflecting::Deflecting;
use crate::variator::rings::guided::Guided;
use crate::variator::rings::ring::{EulerianRing, RingForces};

/// A ring on an Eulerian mesh in D components, on the curve `C`. A value of it holds parameters of the ring beyond those of
/// the beam.
pub trait RingKind<const D: usize, C: MeshCurve>: Directions {
    /// The ring inside a cell.
    type Ring<'a, T: Real>: EulerianRing<T, D>;

    /// The ring between two nodes of a cell `at` a place and a reference motion, from the cell's `unknowns`. `seed` makes a
    /// scalar from a value, its direction and its derivative. `curve` is frame and segment of the reference curve.
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        at: (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        curve: (&'a C::Frame<T>, usize),
        unknowns: &Unknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Self::Ring<'a, T>;

    /// Derivatives by hand in the directions before the drift, of the rings that have them.
    #[doc(hidden)]
    fn by_hand(_ring: &Self::Ring<'_, Lanes>, _evaluated: Evaluated<'_, D>, _columns: &mut Columns<'_>) {}
}

impl<C: MeshCurve> RingKind<2, C> for GuidedRing {
    type Ring<'a, T: Real> = Guided<'a, T, C>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        curve: (&'a C::Frame<T>, usize),
        unknowns: &Unknowns<T::Constant>,
        _slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Guided<'a, T, C> {
        Guided::new(ring, (place, motion), curve, tensions(unknowns, seed))
    }

    #[inline(always)]
    fn by_hand(ring: &Guided<'_, Lanes, C>, evaluated: Evaluated<'_, 2>, columns: &mut Columns<'_>) {
        columns.record_by_hand::<Self, _, 2>(ring, evaluated);
    }
}

impl<const D: usize, C: MeshCurve> RingKind<D, C> for DeflectingRing<D> {
    type Ring<'a, T: Real> = Deflecting<'a, T, D>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        _: (&'a C::Frame<T>, usize),
        unknowns: &Unknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Deflecting<'a, T, D> {
        Deflecting::new(ring, place, motion, &nodes(unknowns, slopes, seed))
    }

    #[inline(always)]
    fn by_hand(ring: &Deflecting<'_, Lanes, D>, evaluated: Evaluated<'_, D>, columns: &mut Columns<'_>) {
        columns.record_by_hand::<Self, _, D>(ring, evaluated);
    }
}

/// The path along which a ring of kind `K` follows the curve, with the motion `path`: that of Θ as the variable, unless
/// the curve has other coordinates.
#[inline(always)]
pub(crate) fn path_of<T: Real, K: Directions>(path: Path<T>) -> Path<T> {
    if K::COORDINATES > 1 {
        return path;
    }
    let mut by_theta = [Jet::constant(0.0); COORDINATES];
    by_theta[0] = Jet::variable(path[0].v);
    by_theta
}

/// The frame of the curve at one place of a path, the same in all lanes.
#[inline(always)]
pub(crate) fn frame<K: Directions, C: MeshCurve>(curve: &TwoPulley, path: Path<f64>) -> C::Frame<Lanes> {
    C::on_path(curve, &path_of::<_, K>(path.map(Jet::lifted)))
}

/// The balance of a pack of cells with this kind of ring; `seed` makes a scalar from a value, its direction and its
/// derivative.
#[inline(always)]
pub(crate) fn pack_balance<T: Real<Constant = Lanes>, K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    InForce { law, friction, .. }: InForce<'_>,
    (kind, pack): (&K, &Pack),
    frame: &C::Frame<T>,
    unknowns: &Unknowns<Lanes>,
    slopes: [f64; 2],
    seed: impl Fn(Lanes, usize, f64) -> T,
    observe: impl FnMut(&AtStation<'_, T, D>),
) -> (CellBalance<T>, RingForces<T, D>) {
    let motion = motion::<T, K>(unknowns, slopes, &seed);
    let place = pack.place::<T, C>(law, frame);
    let reference = |slot: usize| C::point(frame, pack.segment, place.fraction(slot));
    let at = (frame, pack.segment);
    let mut ring = kind.ring::<T>(&law.ring, (&place, &motion.reference), at, unknowns, slopes, &seed);
    let given = CellInput {
        law,
        friction,
        place: &place,
        motion: &motion,
    };
    let (b, _) = balance(&given, &mut ring, reference, &mut Slots::empty(), observe);
    (b, ring.forces())
}
