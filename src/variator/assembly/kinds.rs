//! Kinds of ring and of mesh as types, chosen once at the start.

use crate::reference_curve::{
    Displaced, DisplacedCurve, DisplacedFrame, Jet, Path, ReferenceCurve, TwoPulley, TwoPulleyFrame, TwoPulleyShape,
};
use crate::ring::Ring;
use crate::ring::kinematics::ReferenceMotion;
use crate::scalar::Real;
use crate::variator::assembly::unknowns::{ReadUnknowns, nodes, tensions};
use crate::variator::cell::directions::{DeflectingRing, Directions, GuidedRing};
use crate::variator::law::place::Place;
use crate::variator::rings::deflecting::Deflecting;
use crate::variator::rings::guided::Guided;
use crate::variator::rings::ring::EulerianRing;

/// The reference curve of a mesh, evenly spaced or following the arcs.
pub trait MeshCurve: ReferenceCurve + std::fmt::Debug + Clone + Send + Sync + 'static {
    /// The curve at given coordinates, independent of the scalar.
    type Shape;

    /// The shape at one place of a path of the coordinates.
    fn shape(curve: &TwoPulley, path: &Path<f64>) -> Self::Shape;

    /// The frame of a shape. `by` returns zero with the derivatives of a coordinate of the path and of its derivatives
    /// along the path.
    fn mesh_frame<T: Real>(shape: &Self::Shape, by: impl Fn(usize) -> Jet<T>) -> Self::Frame<T>;

    /// Radii of the secondary and of the primary arc, m.
    fn arc_radii<T: Real>(frame: &Self::Frame<T>) -> [T; 2];

    /// Wrap angles of the secondary and of the primary arc, rad.
    fn arc_wraps<T: Real>(frame: &Self::Frame<T>) -> [T; 2];
}

/// The curve of a mesh whose element borders follow the arc borders.
impl MeshCurve for TwoPulley {
    type Shape = TwoPulleyShape;

    #[inline(always)]
    fn shape(curve: &TwoPulley, path: &Path<f64>) -> TwoPulleyShape {
        curve.shape(path[0].v)
    }

    #[inline(always)]
    fn mesh_frame<T: Real>(shape: &TwoPulleyShape, by: impl Fn(usize) -> Jet<T>) -> TwoPulleyFrame<T> {
        shape.frame(by(0).v)
    }

    #[inline(always)]
    fn arc_radii<T: Real>(frame: &TwoPulleyFrame<T>) -> [T; 2] {
        frame.radius.map(|radius| radius.v)
    }

    #[inline(always)]
    fn arc_wraps<T: Real>(frame: &TwoPulleyFrame<T>) -> [T; 2] {
        frame.wraps()
    }
}

/// The curve with displaced centres: its frame holds derivatives along the motion.
impl MeshCurve for Displaced {
    type Shape = (TwoPulley, Path<f64>);

    fn shape(curve: &TwoPulley, path: &Path<f64>) -> Self::Shape {
        (curve.clone(), *path)
    }

    fn mesh_frame<T: Real>((curve, path): &Self::Shape, by: impl Fn(usize) -> Jet<T>) -> DisplacedFrame<T> {
        let path = std::array::from_fn(|k| {
            let (of, by) = (path[k], by(k));
            Jet {
                v: by.v + of.v,
                d: by.d + of.d,
                dd: by.dd + of.dd,
            }
        });
        Self::at_place(curve, &path)
    }

    #[inline(always)]
    fn arc_radii<T: Real>(frame: &DisplacedFrame<T>) -> [T; 2] {
        frame.radius.map(|radius| radius.v)
    }

    #[inline(always)]
    fn arc_wraps<T: Real>(frame: &DisplacedFrame<T>) -> [T; 2] {
        frame.wraps()
    }
}

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
}

impl<C: MeshCurve + DisplacedCurve> RingKind<2, C> for GuidedRing {
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
}
