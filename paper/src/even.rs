//! The curve of `ALE0` and `ALE` for elements spaced evenly along the belt.

use crate::reference_curve::unaligned::merge_derivatives;
use crate::reference_curve::{
    CoordinateDerivatives, MeshCurve, Path, ReferencePoint, TwoPulley, TwoPulleyFrame, Unaligned,
    UnalignedFrame,
};
use crate::scalar::Real;

/// On a fixed mesh ξ and dξ are constant.
impl MeshCurve for Unaligned<TwoPulley> {
    fn on_path<T: Real>(curve: &TwoPulley, path: &Path<T>) -> Self::Frame<T> {
        Self::frame_of(curve, TwoPulley::on_path(curve, path))
    }

    fn arcs<T: Real>(frame: &Self::Frame<T>) -> &TwoPulleyFrame<T> {
        &frame.frame
    }

    fn derivatives<T: Real>(
        frame: &UnalignedFrame<TwoPulleyFrame<T>>,
        _segment: usize,
        fraction: T,
        point: &ReferencePoint<T>,
    ) -> CoordinateDerivatives<T> {
        let fraction = fraction.value();
        let of = |segment| {
            let (f, df) = Self::within(frame, segment, fraction);
            let mut derivatives = TwoPulley::derivatives(&frame.frame, segment, df + T::constant(f), point);
            for by in &mut derivatives.0 {
                by.r -= point.t * ((point.kappa * frame.frame.growth.v + 1.0) * by.xi);
                (by.xi, by.dilation) = (T::zero(), T::zero());
            }
            derivatives
        };
        Self::gather::<T, _>(frame, fraction, of, merge_derivatives)
    }
}
