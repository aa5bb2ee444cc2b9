//! Kinds of ring and of mesh that the cells can have, as types: the choice is made once, at the start.

use crate::reference_curve::{ReferenceCurve, TwoPulley, TwoPulleyFrame, Unaligned};
use crate::ring::Ring;
use crate::ring::kinematics::ReferenceMotion;
use crate::scalar::Real;
use crate::variator::assembly::unknowns::{ReadUnknowns, nodes, tensions};
use crate::variator::cell::directions::{DeflectingRing, Directions, GuidedRing, RotatingRing};
use crate::variator::law::place::Place;
use crate::variator::rings::deflecting::Deflecting;
use crate::variator::rings::guided::Guided;
use crate::variator::rings::ring::EulerianRing;
use crate::variator::rings::rotating::Rotating;

/// The reference curve of a mesh that stands still or follows the arcs.
pub(crate) trait MeshCurve: ReferenceCurve + std::fmt::Debug + Clone + Send + Sync + 'static {
    /// The frame of this curve from that of the two pulleys.
    fn mesh_frame<T: Real>(curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> Self::Frame<T>;

    /// Radii of the secondary and of the primary arc, m.
    fn arc_radii<T: Real>(frame: &Self::Frame<T>) -> [T; 2];
}

/// The curve of a mesh whose element borders follow the arc borders.
impl MeshCurve for TwoPulley {
    #[inline(always)]
    fn mesh_frame<T: Real>(_curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> TwoPulleyFrame<T> {
        frame
    }

    #[inline(always)]
    fn arc_radii<T: Real>(frame: &TwoPulleyFrame<T>) -> [T; 2] {
        frame.radius.map(|radius| radius.v)
    }
}

/// The curve of a mesh whose elements stand still.
impl MeshCurve for Unaligned<TwoPulley> {
    fn mesh_frame<T: Real>(curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> Self::Frame<T> {
        Self::frame_of(curve, frame)
    }

    #[inline(always)]
    fn arc_radii<T: Real>(frame: &Self::Frame<T>) -> [T; 2] {
        <TwoPulley as MeshCurve>::arc_radii(frame.aligned())
    }
}

/// A ring whose mesh stands still, in D components.
pub(crate) trait RingKind<const D: usize>: Directions {
    /// The ring inside a cell.
    type Ring<'a, T: Real>: EulerianRing<T, D>;

    /// The ring between two nodes of a cell `at` a place under a reference motion, from the cell's `unknowns`; `seed` makes
    /// a scalar of a value, its direction and its slope. `curve` gives frame and segment of the reference curve there.
    fn ring<'a, T: Real, C: MeshCurve>(
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
    fn ring<'a, T: Real, C: MeshCurve>(
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
    fn ring<'a, T: Real, C: MeshCurve>(
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
    fn ring<'a, T: Real, C: MeshCurve>(
        ring: &'a Ring,
        (place, motion): (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        (frame, segment): (&C::Frame<T>, usize),
        unknowns: &impl ReadUnknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Rotating<'a, T, D> {
        let [start, share] = place.of_segment;
        let curve = |fraction| C::tangent_angle(frame, segment, fraction);
        let nodes = nodes(unknowns, slopes, seed);
        Rotating::new(ring, place, motion, nodes, [start, start + share], curve)
    }
}
