//! Derivatives of the curve about displaced centres, on a mesh that does not follow its arcs,
//! against differences.

use pushbelt_paper::reference_curve::{MeshCurve, TwoPulley, Unaligned};
use pushbelt_support::curves::{assert_derivatives, assert_path, curve, moving_frame, path};

type Curve = Unaligned<TwoPulley>;

#[test]
fn derivatives_along_a_path_match_differences() {
    let frame = |t| Curve::on_path(&curve(), &path(t));
    assert_path::<Curve>(frame, &Curve::frame_of(&curve(), moving_frame()), 1);
}

#[test]
fn derivatives_by_coordinates_match_differences() {
    assert_derivatives::<Curve>(|path| Curve::on_path(&curve(), path), 1);
}
