//! Derivatives of the curve about displaced centres, on a mesh that does not follow its arcs, against differences.

use pushbelt_paper::reference_curve::{TwoPulley, Unaligned};
use pushbelt_support::curves::{assert_path, assert_slopes, curve, moving_frame, path};

#[test]
fn derivatives_along_a_path_match_differences() {
    let frame = |t| Unaligned::frame_of(&curve(), curve().on_path(&path(t)));
    assert_path::<Unaligned<TwoPulley>>(frame, &Unaligned::frame_of(&curve(), moving_frame()), 1);
}

#[test]
fn slopes_match_differences() {
    let frame = |path: &_| Unaligned::frame_of(&curve(), curve().on_path(path));
    assert_slopes::<Unaligned<TwoPulley>>(frame, 1);
}
