//! The curve of a belt drive with idlers: closure, Θ derivatives, drives around which no belt runs.

use nalgebra::Vector2;
use pushbelt::pulley::PerPulley;
use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley};
use pushbelt_paper_lab::drive::{BeltDrive, DriveError, DrivePulley, Tensioner};
use std::f64::consts::TAU;

fn pulley(x: f64, y: f64, radius: f64) -> DrivePulley {
    DrivePulley {
        center: [x, y],
        radius,
    }
}

/// Two pulleys and a back-side idler on the lower strand.
fn idler() -> BeltDrive<3> {
    BeltDrive::new([
        pulley(0.0, 0.0, 0.04),
        pulley(0.25, 0.02, 0.06),
        pulley(0.12, -0.05, -0.02),
    ])
    .unwrap()
}

fn tensioned() -> BeltDrive<3> {
    idler()
        .with_tensioner(Tensioner {
            pulley: 2,
            pivot: [0.17, -0.12],
        })
        .unwrap()
}

#[test]
fn a_drive_with_two_pulleys_is_the_two_pulley_curve() {
    let curve = TwoPulley::new(0.168, 0.703);
    let PerPulley {
        primary: r_p,
        secondary: r_s,
    } = curve.radii(0.6).unwrap();
    let drive = BeltDrive::new([pulley(0.0, 0.0, r_s), pulley(0.168, 0.0, r_p)]).unwrap();
    assert!((drive.length() - 0.703).abs() < 1e-14);
    let theta = (1.0 - 0.6) / (1.0 + 0.6);
    for xi in [0.0, 0.03, 0.1, 0.3, 0.45, 0.69] {
        let (a, b) = (
            drive.at(&drive.frame::<f64>(0.0), xi),
            curve.at(&curve.frame::<f64>(theta), xi),
        );
        let off = [(a.r - b.r).norm(), (a.t - b.t).norm(), (a.kappa - b.kappa).abs()];
        assert!(off[0] < 1e-13 && off[1] < 1e-12 && off[2] < 1e-9, "ξ = {xi}: {off:?}");
    }
}

#[test]
fn the_loop_closes_and_turns_once() {
    for drive in [idler(), tensioned()] {
        let frame = drive.frame::<f64>(0.0);
        let count = drive.segments();
        for k in 0..count {
            let (end, start) = (
                BeltDrive::<3>::point::<f64>(&frame, k, 1.0),
                BeltDrive::<3>::point::<f64>(&frame, (k + 1) % count, 0.0),
            );
            assert!(
                (end.r - start.r).norm() < 1e-14 && (end.t - start.t).norm() < 1e-14,
                "segment {k}"
            );
            assert!(BeltDrive::<3>::segment_length(&frame, k).v > 0.0);
        }
        assert!((BeltDrive::<3>::tangent_angle::<f64>(&frame, count - 1, 1.0).chi.v - TAU).abs() < 1e-14);
        // The idler bends the belt backwards.
        assert!(BeltDrive::<3>::point::<f64>(&frame, 4, 0.5).kappa < 0.0);
    }
}

#[test]
fn derivatives_match_differences() {
    let drive = tensioned();
    let h = 1e-5;
    let close = |a: Vector2<f64>, b: Vector2<f64>, tol: f64| assert!((a - b).norm() < tol, "{a} {b}");
    for theta in [-0.15, 0.0, 0.2] {
        let sum: f64 = (0..drive.segments())
            .map(|k| BeltDrive::<3>::segment_length(&drive.frame::<f64>(theta), k).v)
            .sum();
        assert!((sum - drive.length()).abs() < 1e-14);
        for segment in 0..drive.segments() {
            for f in [0.0, 0.3, 1.0] {
                let at = |theta: f64, f: f64| BeltDrive::<3>::point::<f64>(&drive.frame(theta), segment, f);
                let angle =
                    |theta: f64| BeltDrive::<3>::tangent_angle::<f64>(&drive.frame(theta), segment, f).chi;
                let (p, plus, minus) = (at(theta, f), at(theta + h, f), at(theta - h, f));
                close(p.r_theta, (plus.r - minus.r) / (2.0 * h), 1e-8);
                close(p.r_theta2, (plus.r_theta - minus.r_theta) / (2.0 * h), 1e-6);
                close(p.n * p.chi_theta, (plus.t - minus.t) / (2.0 * h), 1e-8);
                assert!((p.xi.d - (plus.xi.v - minus.xi.v) / (2.0 * h)).abs() < 1e-8);
                assert!((p.xi.dd - (plus.xi.d - minus.xi.d) / (2.0 * h)).abs() < 1e-6);
                let chi_dd = (angle(theta + h).d - angle(theta - h).d) / (2.0 * h);
                assert!((angle(theta).dd - chi_dd).abs() < 1e-6);
                if f == 0.3 {
                    let (a, b) = (at(theta, f - h), at(theta, f + h));
                    let dxi = b.xi.v - a.xi.v;
                    close(p.t, (b.r - a.r) / dxi, 1e-9);
                    close(p.n * p.kappa, (b.t - a.t) / dxi, 1e-7);
                }
            }
        }
    }
}

#[test]
fn impossible_drives_are_refused() {
    assert_eq!(BeltDrive::new([pulley(0.0, 0.0, 0.1)]).unwrap_err(), DriveError::TooFew);
    let inside = BeltDrive::new([pulley(0.0, 0.0, 0.1), pulley(0.01, 0.0, 0.05)]);
    assert_eq!(inside.unwrap_err(), DriveError::Wrap(0));
    let backwards = BeltDrive::new([pulley(0.3, 0.0, 0.05), pulley(0.0, 0.0, 0.05), pulley(0.15, 0.1, 0.02)]);
    assert!(backwards.is_err());
    let fixed = Tensioner {
        pulley: 0,
        pivot: [0.0, 0.1],
    };
    assert_eq!(idler().with_tensioner(fixed).unwrap_err(), DriveError::Tensioner);
}
