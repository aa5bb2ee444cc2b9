//! Derivatives of the curve about displaced centres, on a mesh that does not follow its arcs, against differences.

use pushbelt_paper::reference_curve::{Displaced, Unaligned};
use pushbelt_support::curves::{assert_path, assert_slopes, curve, moving_frame, path};

#[test]
fn derivatives_along_a_path_match_differences() {
    let mesh = Displaced { curve: curve() };
    let frame = |t| Unaligned::frame_of(&mesh, Displaced::at_place(&curve(), &path(t)));
    assert_path::<Unaligned<Displaced>>(frame, &Unaligned::frame_of(&mesh, moving_frame()), 1);
}

#[test]
fn slopes_match_differences() {
    let mesh = Displaced { curve: curve() };
    let frame = |path: &_| Unaligned::frame_of(&mesh, Displaced::at_place(&curve(), path));
    assert_slopes::<Unaligned<Displaced>>(frame, 1);
}
