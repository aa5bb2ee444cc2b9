//! Which ring the cells have, and on which mesh: known at compile time, chosen once.

use crate::reference_curve::{ReferenceCurve, TwoPulley, TwoPulleyFrame, Unaligned};
use crate::ring::Ring;
use crate::ring::kinematics::ReferenceMotion;
use crate::scalar::Real;
use crate::variator::assembly::unknowns::{ReadUnknowns, nodes, tensions};
use crate::variator::cell::deflecting::Deflecting;
use crate::variator::cell::directions::{DeflectingRing, Directions, GuidedRing, RotatingRing};
use crate::variator::cell::guided::Guided;
use crate::variator::cell::place::Place;
use crate::variator::cell::ring::EulerianRing;
use crate::variator::cell::rotating::Rotating;

/// The reference curve as a mesh stands on it.
pub(crate) trait Standing: ReferenceCurve + std::fmt::Debug + Clone + Send + Sync + 'static {
    /// What a frame of the curve is to the mesh.
    fn stand<T: Real>(curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> Self::Frame<T>;
}

/// Element borders follow the arc borders.
impl Standing for TwoPulley {
    #[inline(always)]
    fn stand<T: Real>(_curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> TwoPulleyFrame<T> {
        frame
    }
}

/// Elements stand still.
impl Standing for Unaligned<TwoPulley> {
    fn stand<T: Real>(curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> Self::Frame<T> {
        Self::seen(curve, frame)
    }
}

/// A ring whose mesh stands still, in D components.
pub(crate) trait RingKind<const D: usize>: Directions {
    /// The ring inside a cell.
    type Ring<'a, T: Real>: EulerianRing<T, D>;

    /// The ring between two nodes of a cell `at` a place under a reference motion, from the cell's `unknowns`; `seed` makes
    /// a scalar of a value, its direction and its slope. `curve` gives frame and segment of the reference curve there.
    fn ring<'a, T: Real, C: Standing>(
        ring: &'a Ring,
        at: (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        curve: (&C::Frame<T>, usize),
        unknowns: &impl ReadUnknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Self::Ring<'a, T>;
}

impl RingKind<2> for GuidedRing {
    type Ring<'a, T: Real> = Guided<'a, T>;

    #[inline(always)]
    fn ring<'a, T: Real, C: Standing>(
        ring: &'a Ring,
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        _: (&C::Frame<T>, usize),
        unknowns: &impl ReadUnknowns<T::Constant>,
        _slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Guided<'a, T> {
        Guided::new(ring, place, motion, tensions(unknowns, seed))
    }
}

impl<const D: usize> RingKind<D> for DeflectingRing<D> {
    type Ring<'a, T: Real> = Deflecting<'a, T, D>;

    #[inline(always)]
    fn ring<'a, T: Real, C: Standing>(
        ring: &'a Ring,
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        _: (&C::Frame<T>, usize),
        unknowns: &impl ReadUnknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Deflecting<'a, T, D> {
        Deflecting::new(ring, place, motion, &nodes(unknowns, slopes, seed))
    }
}

impl<const D: usize> RingKind<D> for RotatingRing<D> {
    type Ring<'a, T: Real> = Rotating<'a, T, D>;

    #[inline(always)]
    fn ring<'a, T: Real, C: Standing>(
        ring: &'a Ring,
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        (frame, segment): (&C::Frame<T>, usize),
        unknowns: &impl ReadUnknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Rotating<'a, T, D> {
        let [start, share] = place.of_segment;
        let curve = |fraction| C::turning(frame, segment, fraction);
        let nodes = nodes(unknowns, slopes, seed);
        Rotating::new(ring, place, motion, nodes, [start, start + share], curve)
    }
}
