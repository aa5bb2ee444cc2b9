//! The reference curve about displaced centres against differences.

use nalgebra::Vector2;
use pushbelt::reference_curve::{Displaced, DisplacedCurve, ReferenceCurve, TwoPulley};
use pushbelt_support::curves::{FRACTIONS, assert_path, assert_slopes, curve, moving_frame, path};

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

fn close(a: Vector2<f64>, b: Vector2<f64>, tolerance: f64) {
    assert!((a - b).norm() < tolerance, "{a} {b}");
}

/// About the axes the curve is that of two pulleys, with all derivatives by Θ.
#[test]
fn about_the_axes_it_is_the_curve_of_two_pulleys() {
    let displaced = Displaced { curve: curve() };
    for theta in [-0.4, 0.0, 0.3] {
        for segment in 0..displaced.segments() {
            for f in FRACTIONS {
                let p = TwoPulley::point(&curve().frame(theta), segment, f);
                let frame = displaced.frame(theta);
                let q = Displaced::point(&frame, segment, f);
                let slopes = Displaced::slopes(&frame, segment, f, &q);
                for (a, b) in [(p.r, q.r), (p.t, q.t), (p.n, q.n), (p.r_theta, q.r_theta)] {
                    close(a, b, 1e-14);
                }
                close(p.r_theta2, q.r_theta2, 1e-13);
                close(p.r_theta, slopes.shape[0].r, 1e-14);
                for (a, b) in [
                    (p.chi_theta, q.chi_theta),
                    (p.kappa, q.kappa),
                    (p.kappa_theta, q.kappa_theta),
                    (p.kappa_theta, slopes.shape[0].kappa),
                    (p.xi.v, q.xi.v),
                    (p.xi.d, q.xi.d),
                    (p.xi.dd, q.xi.dd),
                    (p.xi.d, slopes.shape[0].xi),
                ] {
                    assert!((a - b).abs() < 1e-12 * a.abs().max(1.0), "{a} {b}");
                }
            }
        }
    }
}

#[test]
fn the_loop_closes_and_its_tangent_is_continuous() {
    let frame = Displaced::at_place(&curve(), &path(0.0));
    let segments = curve().segments();
    for segment in 0..segments {
        let (end, start) = (
            Displaced::point(&frame, segment, 1.0),
            Displaced::point(&frame, (segment + 1) % segments, 0.0),
        );
        assert!((end.r - start.r).norm() < 1e-14 && (end.t - start.t).norm() < 1e-13);
    }
    let end = Displaced::point(&frame, segments - 1, 1.0);
    assert!((end.xi.v - 0.703).abs() < 1e-14 && end.xi.d.abs() < 1e-13 && end.xi.dd.abs() < 1e-12);
}
