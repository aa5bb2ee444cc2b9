//! The reference curve: published radii, and about displaced centres against differences.

use pushbelt::reference_curve::{TwoPulley, TwoPulleyFrame, ratio_of_theta};
use pushbelt::scalar::Dual;
use pushbelt_support::curves::{assert_derivatives, assert_path, curve, moving_frame, path};

#[test]
fn derivatives_along_a_path_match_differences() {
    let check = |frame: &dyn Fn(f64) -> TwoPulleyFrame<f64>, moving: &TwoPulleyFrame<Dual>| {
        let segments = 0..TwoPulley::SEGMENTS;
        assert_path(frame, moving, segments, TwoPulleyFrame::point, TwoPulleyFrame::point);
    };
    check(&|t| curve().on_path(&path(t)), &moving_frame());
    for theta in [-0.4, 0.0, 0.3] {
        check(&|t| curve().frame(theta + t), &curve().frame(Dual::seed(theta, 0, 1.0)));
    }
}

#[test]
fn derivatives_by_coordinates_match_differences() {
    let segments = 0..TwoPulley::SEGMENTS;
    assert_derivatives(segments, TwoPulleyFrame::point, TwoPulleyFrame::derivatives);
}

#[test]
fn the_loop_closes_and_its_tangent_is_continuous() {
    let frame = curve().on_path(&path(0.0));
    let segments = TwoPulley::SEGMENTS;
    for segment in 0..segments {
        let end = frame.point(segment, 1.0);
        let start = frame.point((segment + 1) % segments, 0.0);
        assert!((end.r - start.r).norm() < 1e-14 && (end.t - start.t).norm() < 1e-13);
    }
    let end = frame.point(segments - 1, 1.0);
    assert!((end.xi.v - 0.703).abs() < 1e-14 && end.xi.d.abs() < 1e-13 && end.xi.dd.abs() < 1e-12);
}

/// Those that are published for a variator, and those of the paper.
#[test]
fn published_radii() {
    for (distance, length, ratio, [primary, secondary], error) in [
        (0.168, 0.703, 1.0, [0.05841; 2], 1e-5),
        (0.168, 0.703, 1.0 / 2.25, [0.07837, 0.03483], 1e-5),
        (0.2, 1.0, ratio_of_theta(0.4), [0.127_690, 0.054_724], 5e-7),
    ] {
        let radii = TwoPulley::new(distance, length).radii(ratio).unwrap();
        assert!(
            (radii.primary - primary).abs() < error && (radii.secondary - secondary).abs() < error,
            "{radii:?}"
        );
    }
    assert!(TwoPulley::new(0.4, 0.703).radii(1.0).is_err());
}
