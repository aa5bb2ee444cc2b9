//! Kinds of ring and of mesh as types, chosen once at the start.

use crate::reference_curve::MeshCurve;
use crate::ring::Ring;
use crate::ring::kinematics::ReferenceMotion;
use crate::scalar::{Lanes, Real};
use crate::variator::assembly::jacobian::{Columns, vary_own};
use crate::variator::assembly::unknowns::{ReadUnknowns, nodes, tensions};
use crate::variator::cell::directions::{DeflectingRing, Directions, GuidedRing};
use crate::variator::cell::variation::Evaluated;
use crate::variator::law::place::Place;
use crate::variator::rings::deflecting::Deflecting;
use crate::variator::rings::guided::Guided;
use crate::variator::rings::ring::EulerianRing;

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
        unknowns: &impl ReadUnknowns<T::Constant>,
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
        unknowns: &impl ReadUnknowns<T::Constant>,
        _slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Guided<'a, T, C> {
        Guided::new(ring, (place, motion), curve, tensions(unknowns, seed))
    }

    #[inline(always)]
    fn by_hand(ring: &Guided<'_, Lanes, C>, evaluated: Evaluated<'_, 2>, columns: &mut Columns<'_>) {
        vary_own::<Self, _, 2>(ring, evaluated, columns);
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
        unknowns: &impl ReadUnknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Deflecting<'a, T, D> {
        Deflecting::new(ring, place, motion, &nodes(unknowns, slopes, seed))
    }

    #[inline(always)]
    fn by_hand(ring: &Deflecting<'_, Lanes, D>, evaluated: Evaluated<'_, D>, columns: &mut Columns<'_>) {
        vary_own::<Self, _, D>(ring, evaluated, columns);
    }
}
