//! The curve of `ALE0` and `ALE` for elements spaced evenly along the belt.

use crate::reference_curve::unaligned::slopes_with_lane;
use crate::reference_curve::{
    CoordinateSlopes, MeshCurve, Path, ReferencePoint, TwoPulley, TwoPulleyFrame, Unaligned, UnalignedFrame,
};
use crate::scalar::Real;

/// On a fixed mesh ξ and dξ are constant.
impl MeshCurve for Unaligned<TwoPulley> {
    fn on_path<T: Real>(curve: &TwoPulley, path: &Path<T>) -> Self::Frame<T> {
        Self::frame_of(curve, curve.on_path(path))
    }

    fn arcs<T: Real>(frame: &Self::Frame<T>) -> &TwoPulleyFrame<T> {
        &frame.frame
    }

    fn slopes<T: Real>(
        frame: &UnalignedFrame<TwoPulleyFrame<T>>,
        _segment: usize,
        fraction: T::Constant,
        point: &ReferencePoint<T>,
    ) -> CoordinateSlopes<T> {
        let of = |segment| {
            let (f, df) = Self::within(frame, segment, fraction);
            let mut slopes = frame.frame.slopes(segment, df + T::constant(f), point);
            for by in &mut slopes.shape {
                by.r -= point.t * ((point.kappa * frame.frame.growth.v + 1.0) * by.xi);
                (by.xi, by.growth) = (T::zero(), T::zero());
            }
            slopes
        };
        Self::gather::<T, _>(frame, fraction, of, slopes_with_lane)
    }
}
