//! The curves of `ALE0` and `ALE` for elements spaced evenly along the belt.

use crate::reference_curve::{
    Displaced, DisplacedCurve, DisplacedFrame, DisplacedPoint, Jet, Path, ReferencePoint, TwoPulley, Unaligned,
    UnalignedFrame,
};
use crate::scalar::Real;
use pushbelt::variator::belt_ring::MeshCurve;

impl<C: MeshCurve + OnPulleys> MeshCurve for Unaligned<C> {
    type Shape = (C, C::Shape);

    fn shape(curve: &TwoPulley, path: &Path<f64>) -> Self::Shape {
        (C::on_pulleys(curve), C::shape(curve, path))
    }

    fn mesh_frame<T: Real>((curve, shape): &Self::Shape, by: impl Fn(usize) -> Jet<T>) -> Self::Frame<T> {
        Self::frame_of(curve, C::mesh_frame(shape, by))
    }

    #[inline(always)]
    fn arc_radii<T: Real>(frame: &Self::Frame<T>) -> [T; 2] {
        C::arc_radii(frame.aligned())
    }

    #[inline(always)]
    fn arc_wraps<T: Real>(frame: &Self::Frame<T>) -> [T; 2] {
        C::arc_wraps(frame.aligned())
    }
}

/// A curve around two pulleys.
trait OnPulleys {
    /// This curve, from the curve about the axes.
    fn on_pulleys(curve: &TwoPulley) -> Self;
}

impl OnPulleys for TwoPulley {
    fn on_pulleys(curve: &TwoPulley) -> Self {
        curve.clone()
    }
}

impl OnPulleys for Displaced {
    fn on_pulleys(curve: &TwoPulley) -> Self {
        Self { curve: curve.clone() }
    }
}

/// On a fixed mesh ξ and dξ are constant.
impl DisplacedCurve for Unaligned<Displaced> {
    fn slopes<T: Real>(
        frame: &UnalignedFrame<DisplacedFrame<T>>,
        _segment: usize,
        fraction: T::Constant,
        point: &ReferencePoint<T>,
    ) -> DisplacedPoint<T> {
        let of = |segment| {
            let (f, df) = Self::within(frame, segment, fraction);
            let mut slopes = frame.frame.slopes(segment, df + T::constant(f), point);
            for by in &mut slopes.shape {
                by.r -= point.t * ((point.kappa * frame.frame.growth.v + 1.0) * by.xi);
                (by.xi, by.growth) = (T::zero(), T::zero());
            }
            slopes
        };
        Self::gather::<T, _>(frame, fraction, of, DisplacedPoint::with_lane)
    }

    fn growth<T: Real>(frame: &UnalignedFrame<DisplacedFrame<T>>) -> [Jet<T>; 2] {
        Displaced::growth(&frame.frame)
    }
}
