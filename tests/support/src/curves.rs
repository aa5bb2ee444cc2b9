//! Derivatives of a reference curve about displaced centres against differences.

use nalgebra::Vector2;
use pushbelt::reference_curve::{
    COORDINATES, CoordinateDerivatives, Jet, Path, PointDerivatives, ReferencePoint, TwoPulley,
    TwoPulleyFrame,
};
use pushbelt::scalar::Dual;
use std::ops::Range;

/// Fractions of a segment at which the curve is examined.
pub const FRACTIONS: [f64; 3] = [0.0, 0.3, 1.0];

/// The curve of the default variator.
pub fn curve() -> TwoPulley {
    TwoPulley::new(0.168, 0.703)
}

/// Coordinates of a path at the time t.
pub fn path(t: f64) -> Path<f64> {
    let of = [
        [0.3, 0.2, -0.4],
        [2e-3, 0.01, 0.03],
        [0.02, -0.3, 0.2],
        [1e-3, 0.02, -0.01],
        [-3e-3, 0.01, 0.05],
        [1e-4, 0.02, 0.03],
    ];
    Path::from_array(of.map(|[v, d, dd]| Jet {
        v: v + t * d + 0.5 * t * t * dd,
        d: d + t * dd,
        dd,
    }))
}

/// The frame at t = 0 with its derivatives in time.
pub fn moving_frame() -> TwoPulleyFrame<Dual> {
    // Derivatives in time of a coordinate and its rates; the third derivative is zero.
    let moving = path(0.0).map(|x| Jet {
        v: Dual::seed(x.v, 0, x.d),
        d: Dual::seed(x.d, 0, x.dd),
        dd: Dual::seed(x.dd, 0, 0.0),
    });
    curve().on_path(&moving)
}

#[track_caller]
fn close(a: Vector2<f64>, b: Vector2<f64>, tolerance: f64) {
    assert!((a - b).norm() < tolerance, "{a} {b}");
}

/// Derivatives along a path, and the derivatives of these by the scalar, against central
/// differences. The curve is that of `point`, and with derivatives of `dual_point`.
#[track_caller]
pub fn assert_path(
    frame: impl Fn(f64) -> TwoPulleyFrame<f64>,
    dual: &TwoPulleyFrame<Dual>,
    segments: Range<usize>,
    point: impl Fn(&TwoPulleyFrame<f64>, usize, f64) -> ReferencePoint<f64>,
    dual_point: impl Fn(&TwoPulleyFrame<Dual>, usize, f64) -> ReferencePoint<Dual>,
) {
    let h = 1e-5;
    for segment in segments {
        for f in FRACTIONS {
            let at = |t: f64| point(&frame(t), segment, f);
            let (p, plus, minus) = (at(0.0), at(h), at(-h));
            let difference = |a: Vector2<f64>, b: Vector2<f64>| (a - b) / (2.0 * h);
            close(p.r_theta, difference(plus.r, minus.r), 1e-9);
            close(p.r_theta2, difference(plus.r_theta, minus.r_theta), 1e-8);
            close(p.n * p.chi_theta, difference(plus.t, minus.t), 1e-8);
            assert!((p.kappa_theta - (plus.kappa - minus.kappa) / (2.0 * h)).abs() < 1e-6);
            assert!((p.xi.d - (plus.xi.v - minus.xi.v) / (2.0 * h)).abs() < 1e-9);
            assert!((p.xi.dd - (plus.xi.d - minus.xi.d) / (2.0 * h)).abs() < 1e-8);
            let d = dual_point(dual, segment, f);
            close(d.r.map(|x| x.eps[0]), p.r_theta, 1e-12);
            close(d.r_theta.map(|x| x.eps[0]), p.r_theta2, 1e-11);
            close(d.t.map(|x| x.eps[0]), p.n * p.chi_theta, 1e-11);
            let third = difference(plus.r_theta2, minus.r_theta2);
            close(d.r_theta2.map(|x| x.eps[0]), third, 1e-5);
            assert!((d.xi.d.eps[0] - p.xi.dd).abs() < 1e-11);
            assert!((d.kappa.eps[0] - p.kappa_theta).abs() < 1e-9);
        }
    }
}

/// Derivatives by each coordinate, those of `derivatives`, against central differences.
#[track_caller]
pub fn assert_derivatives(
    segments: Range<usize>,
    point: impl Fn(&TwoPulleyFrame<f64>, usize, f64) -> ReferencePoint<f64>,
    derivatives: impl Fn(&TwoPulleyFrame<f64>, usize, f64, &ReferencePoint<f64>) -> CoordinateDerivatives<f64>,
) {
    let h = 1e-6;
    for segment in segments {
        for f in FRACTIONS {
            let at = |k: usize, step: f64| {
                let mut path = path(0.0).to_array();
                path[k].v += step;
                let frame = curve().on_path(&Path::from_array(path));
                let length = frame.segment_length(segment).v;
                (point(&frame, segment, f), length.ln())
            };
            let of = curve().on_path(&path(0.0));
            let here = point(&of, segment, f);
            let by = derivatives(&of, segment, f, &here);
            for k in 0..COORDINATES {
                let ((plus, of_plus), (minus, of_minus)) = (at(k, h), at(k, -h));
                let [xi, kappa, dilation] =
                    [plus.xi.v - minus.xi.v, plus.kappa - minus.kappa, of_plus - of_minus]
                        .map(|difference| difference / (2.0 * h));
                let unit = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)];
                let found = match k {
                    0 => by.theta,
                    1 => by.spread,
                    _ => PointDerivatives {
                        r: match k {
                            2 => by.turn,
                            5 => -here.n,
                            _ => unit[k - 3],
                        },
                        xi: 0.0,
                        kappa: 0.0,
                        dilation: 0.0,
                    },
                };
                close(found.r, (plus.r - minus.r) / (2.0 * h), 1e-8);
                let rows = [
                    (found.xi, xi, 1e-8),
                    (found.kappa, kappa, 1e-5),
                    (found.dilation, dilation, 1e-7),
                ];
                for (found, expected, tolerance) in rows {
                    assert!((found - expected).abs() < tolerance, "{k}: {found} {expected}");
                }
            }
        }
    }
}
