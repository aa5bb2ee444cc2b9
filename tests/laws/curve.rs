//! The reference curve about displaced centres against differences.

use pushbelt::reference_curve::{Displaced, ReferenceCurve};
use pushbelt_support::curves::{assert_path, assert_slopes, curve, moving_frame, path};

#[test]
fn derivatives_along_a_path_match_differences() {
    let frame = |t: f64| Displaced::at_place(&curve(), &path(t));
    assert_path::<Displaced>(frame, &moving_frame(), curve().segments());
}

/// Derivatives by each coordinate.
#[test]
fn derivatives_by_coordinates_match_differences() {
    let frame = |path: &_| Displaced::at_place(&curve(), path);
    assert_slopes::<Displaced>(frame, curve().segments());
}
