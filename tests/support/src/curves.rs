//! Derivatives of a reference curve about displaced centres against differences.

use nalgebra::Vector2;
use pushbelt::reference_curve::{
    COORDINATES, Jet, MeshCurve, Path, PointDerivatives, ReferenceCurve, TwoPulley, TwoPulleyFrame,
};
use pushbelt::scalar::Dual;

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
    of.map(|[v, d, dd]| Jet {
        v: v + t * d + 0.5 * t * t * dd,
        d: d + t * dd,
        dd,
    })
}

/// The frame at t = 0 with its derivatives in time.
pub fn moving_frame() -> TwoPulleyFrame<Dual> {
    // Derivatives in time of a coordinate and its rates; the third derivative is zero.
    let moving = path(0.0).map(|x| Jet {
        v: Dual::seed(x.v, 0, x.d),
        d: Dual::seed(x.d, 0, x.dd),
        dd: Dual::seed(x.dd, 0, 0.0),
    });
    TwoPulley::on_path(&curve(), &moving)
}

#[track_caller]
fn close(a: Vector2<f64>, b: Vector2<f64>, tolerance: f64) {
    assert!((a - b).norm() < tolerance, "{a} {b}");
}

/// Derivatives along a path, and the derivatives of these by the scalar, against central
/// differences.
#[track_caller]
pub fn assert_path<C: ReferenceCurve>(
    frame: impl Fn(f64) -> C::Frame<f64>,
    dual: &C::Frame<Dual>,
    segments: usize,
) {
    let h = 1e-5;
    for segment in 0..segments {
        for f in FRACTIONS {
            let at = |t: f64| C::point(&frame(t), segment, f);
            let (p, plus, minus) = (at(0.0), at(h), at(-h));
            let difference = |a: Vector2<f64>, b: Vector2<f64>| (a - b) / (2.0 * h);
            close(p.r_theta, difference(plus.r, minus.r), 1e-9);
            close(p.r_theta2, difference(plus.r_theta, minus.r_theta), 1e-8);
            close(p.n * p.chi_theta, difference(plus.t, minus.t), 1e-8);
            assert!((p.kappa_theta - (plus.kappa - minus.kappa) / (2.0 * h)).abs() < 1e-6);
            assert!((p.xi.d - (plus.xi.v - minus.xi.v) / (2.0 * h)).abs() < 1e-9);
            assert!((p.xi.dd - (plus.xi.d - minus.xi.d) / (2.0 * h)).abs() < 1e-8);
            let d = C::point(dual, segment, f);
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

/// Derivatives by each coordinate against central differences.
#[track_caller]
pub fn assert_derivatives<C: MeshCurve>(frame: impl Fn(&Path<f64>) -> C::Frame<f64>, segments: usize) {
    let h = 1e-6;
    for segment in 0..segments {
        for f in FRACTIONS {
            let at = |k: usize, step: f64| {
                let mut path = path(0.0);
                path[k].v += step;
                let frame = frame(&path);
                let length = C::segment_length(&frame, segment).v;
                (C::point(&frame, segment, f), length.ln())
            };
            let of = frame(&path(0.0));
            let (shape, turn) = C::derivatives(&of, segment, f, &C::point(&of, segment, f));
            for k in 0..COORDINATES {
                let ((plus, of_plus), (minus, of_minus)) = (at(k, h), at(k, -h));
                let [xi, kappa, dilation] =
                    [plus.xi.v - minus.xi.v, plus.kappa - minus.kappa, of_plus - of_minus]
                        .map(|difference| difference / (2.0 * h));
                let unit = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)];
                let found = match k {
                    0 | 1 => shape[k],
                    _ => PointDerivatives {
                        r: match k {
                            2 => turn,
                            5 => -C::point(&of, segment, f).n,
                            _ => unit[k - 3],
                        },
                        xi: 0.0,
                        kappa: 0.0,
                        dilation: 0.0,
                    },
                };
                close(found.r, (plus.r - minus.r) / (2.0 * h), 1e-8);
                assert!((found.xi - xi).abs() < 1e-8, "{k}: {} {xi}", found.xi);
                assert!((found.kappa - kappa).abs() < 1e-5, "{k}: {} {kappa}", found.kappa);
                assert!(
                    (found.dilation - dilation).abs() < 1e-7,
                    "{k}: {} {dilation}",
                    found.dilation
                );
            }
        }
    }
}
