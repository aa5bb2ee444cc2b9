//! Derivatives of the curve about displaced centres, on a mesh that does not follow its arcs,
//! against differences.

use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley, Unaligned};
use pushbelt_support::curves::{assert_derivatives, assert_path, curve, moving_frame, path};
use std::ops::Range;

/// The whole curve as a segment.
const WHOLE: Range<usize> = TwoPulley::WHOLE..TwoPulley::WHOLE + 1;

#[test]
fn derivatives_along_a_path_match_differences() {
    let frame = |t| curve().on_path(&path(t));
    assert_path(frame, &moving_frame(), WHOLE, Unaligned::point, Unaligned::point);
}

#[test]
fn derivatives_by_coordinates_match_differences() {
    assert_derivatives(WHOLE, Unaligned::point, |frame, _, fraction, point| {
        Unaligned::derivatives(frame, fraction, point)
    });
}
