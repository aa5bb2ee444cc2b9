//! The reference curve: published radii, and about displaced centres against differences.

use pushbelt::reference_curve::{MeshCurve, ReferenceCurve, TwoPulley, ratio_of_theta};
use pushbelt::scalar::Dual;
use pushbelt_support::curves::{assert_derivatives, assert_path, curve, moving_frame, path};

#[test]
fn derivatives_along_a_path_match_differences() {
    let frame = |t: f64| TwoPulley::on_path(&curve(), &path(t));
    assert_path::<TwoPulley>(frame, &moving_frame(), curve().segments());
    for theta in [-0.4, 0.0, 0.3] {
        let about_the_axes = |t: f64| curve().frame(theta + t);
        let moving = curve().frame(Dual::seed(theta, 0, 1.0));
        assert_path::<TwoPulley>(about_the_axes, &moving, curve().segments());
    }
}

/// Derivatives by each coordinate.
#[test]
fn derivatives_by_coordinates_match_differences() {
    let frame = |path: &_| TwoPulley::on_path(&curve(), path);
    assert_derivatives::<TwoPulley>(frame, curve().segments());
}

#[test]
fn the_loop_closes_and_its_tangent_is_continuous() {
    let frame = TwoPulley::on_path(&curve(), &path(0.0));
    let segments = curve().segments();
    for segment in 0..segments {
        let end = TwoPulley::point(&frame, segment, 1.0);
        let start = TwoPulley::point(&frame, (segment + 1) % segments, 0.0);
        assert!((end.r - start.r).norm() < 1e-14 && (end.t - start.t).norm() < 1e-13);
    }
    let end = TwoPulley::point(&frame, segments - 1, 1.0);
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
        let (r_p, r_s) = TwoPulley::new(distance, length).radii(ratio).unwrap();
        assert!(
            (r_p - primary).abs() < error && (r_s - secondary).abs() < error,
            "{r_p} {r_s}"
        );
    }
    assert!(TwoPulley::new(0.4, 0.703).radii(1.0).is_err());
}
