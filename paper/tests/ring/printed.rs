//! Equations of the paper as they are printed, beside the forms that the code uses. Each test
//! prints by how much the printed form is off; `docs/paper-corrections.md` has these numbers. (14)
//! is in `ale`.

use nalgebra::Vector2;
use pushbelt::pulley::PerPulley;
use pushbelt::ring::kinematics::Hermite;
use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley};
use pushbelt_paper::ring::ale_ring::AleRing;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper_lab::*;
use std::f64::consts::{PI, TAU};

/// Axle distance and belt length of bench168, m.
const CENTER_DISTANCE: f64 = 0.168;
const LENGTH: f64 = 0.703;
/// Θ at the start of the paper's fig. 6.
const THETA: f64 = 0.4;

/// Radii r_P, r_S, m, and φ of the curve of bench168 at a ratio parameter.
fn radii(theta: f64) -> (f64, f64, f64) {
    let PerPulley {
        primary: r_p,
        secondary: r_s,
    } = TwoPulley::new(CENTER_DISTANCE, LENGTH)
        .radii((1.0 - theta) / (1.0 + theta))
        .unwrap();
    (r_p, r_s, ((r_p - r_s) / CENTER_DISTANCE).acos())
}

/// The Leibniz rule (3) of ∫_l^u g dx̄ with g = t x̄², l = t, u = 2t: f = 7t⁴/3. The printed rule
/// adds ∫∂g/∂x̄ dx̄.
#[test]
fn leibniz_rule() {
    let t = 0.5_f64;
    let borders = -t * t.powi(2) + t * (2.0 * t).powi(2) * 2.0;
    let local = ((2.0 * t).powi(3) - t.powi(3)) / 3.0;
    let printed = borders + t * ((2.0 * t).powi(2) - t.powi(2)) + local;
    let exact = 28.0 / 3.0 * t.powi(3);
    println!("(3): printed off by {:+.0} %", 100.0 * (printed / exact - 1.0));
    assert!(((borders + local) / exact - 1.0).abs() < 1e-12 && printed / exact > 1.1);
}

/// Border terms of (18): V = ½ EI Σ b_k/r_k² over both arcs, whose lengths change with Θ.
#[test]
fn moving_borders_of_arcs() {
    let arcs = |theta: f64| {
        let (r_p, r_s, phi) = radii(theta);
        [(1.0 / r_p, 2.0 * r_p * (PI - phi)), (1.0 / r_s, 2.0 * r_s * phi)]
    };
    let h = 1e-5;
    let (before, at, after) = (arcs(THETA - h), arcs(THETA), arcs(THETA + h));
    let energy = |arcs: [(f64, f64); 2]| arcs.iter().map(|(kappa, b)| 0.5 * kappa * kappa * b).sum::<f64>();
    let exact = (energy(after) - energy(before)) / (2.0 * h);
    let mut printed = 0.0;
    let mut borders = 0.0;
    for k in 0..2 {
        printed += at[k].0 * (after[k].0 - before[k].0) / (2.0 * h) * at[k].1;
        borders += 0.5 * at[k].0.powi(2) * (after[k].1 - before[k].1) / (2.0 * h);
    }
    println!(
        "(18), (23b) without border terms: {printed:.2} EI, with them {:.2} EI, difference of V {exact:.2} EI",
        printed + borders
    );
    assert!(((printed + borders) / exact - 1.0).abs() < 1e-6);
    assert!((printed / exact - 1.0).abs() > 0.2);
}

/// The bending measure of 4.2, κ_n = n_refᵀ r'': a free circle is turned, or stretched. Neither
/// bends it.
#[test]
fn bending_measure() {
    let system = RingSystem::new(AleRing::flexible(
        band(0.185e-3),
        band_circle(),
        RingMesh::even(&[48], 3),
    ));
    let radius = band_circle().radius;
    let energies = |turn: f64, stretch: f64| {
        let shape = |xi: f64| {
            let chi = xi / radius + turn;
            let (sin, cos) = chi.sin_cos();
            [
                Vector2::new(-cos, sin) * (radius * stretch),
                Vector2::new(sin, cos) * stretch,
            ]
        };
        let state = system.rest_on(0.0, &shape);
        let count = 960;
        let printed: f64 = (0..count)
            .map(|k| {
                let xi = (f64::from(k) + 0.5) / f64::from(count) * TAU * radius;
                let (sin, cos) = (xi / radius).sin_cos();
                let kappa = Vector2::new(cos, -sin).dot(&system.particle_at(state.view(), xi).bend);
                0.5 * system.model.ring.bending_stiffness * kappa * kappa * TAU * radius / f64::from(count)
            })
            .sum();
        (printed, system.energy(state.view()).bending)
    };
    let (printed, used) = energies(0.0, 1.0);
    for (what, turn, stretch) in [("turned by 0.1 rad", 0.1, 1.0), ("stretched by 1 %", 0.0, 1.01)] {
        let (printed_then, used_then) = energies(turn, stretch);
        let (printed, used) = (printed_then / printed - 1.0, used_then / used - 1.0);
        println!(
            "κ_n, {what}: bending energy printed {:+.2} %, used {:+.4} %",
            100.0 * printed,
            100.0 * used
        );
        assert!(used.abs() < 1e-4 && printed.abs() > 5e-3, "{what}: {printed} {used}");
    }
}

/// (27) to (29) and the definitions beside them, on the pulleys of bench168.
#[test]
fn reference_curve() {
    let (r_p, r_s, phi) = radii(THETA);
    let arcs = 2.0 * r_p * (PI - phi) + 2.0 * r_s * phi;
    // α = arcsin((r_B − r_B)/d_A) is zero as printed.
    let (printed_b, b) = (
        CENTER_DISTANCE,
        CENTER_DISTANCE * ((r_p - r_s) / CENTER_DISTANCE).asin().cos(),
    );
    let closure = |b: f64| LENGTH - 2.0 * b - arcs;
    println!("(27) with α as printed: {:.2} mm open", 1e3 * closure(printed_b).abs());
    assert!(closure(b).abs() < 1e-12 && closure(printed_b).abs() > 1e-3);

    let primary = |phi_p: f64| Vector2::new(CENTER_DISTANCE - r_p * phi_p.cos(), r_p * phi_p.sin());
    // ξ_P = ξ − r_S φ + b and φ_P = φ + ξ/r_P as printed; φ_P = φ + ξ_P/r_P with ξ_P = ξ − r_S φ −
    // b as used.
    let printed = |xi: f64| primary(phi + xi / r_p);
    let printed_place = |xi: f64| primary(phi + (xi - r_s * phi + b) / r_p);
    let used = |xi: f64| primary(phi + (xi - r_s * phi - b) / r_p);
    let curve = TwoPulley::new(CENTER_DISTANCE, LENGTH);
    let frame = curve.frame::<f64>(THETA);
    let begin = r_s * phi + b;
    for k in 0..=10 {
        let xi = begin + (LENGTH / 2.0 - begin) * f64::from(k) / 10.0;
        let place = curve.at(&frame, xi).r;
        assert!((used(xi) - place).norm() < 1e-12);
        assert!((printed(xi) - place).norm() > 1e-3 && (printed_place(xi) - place).norm() > 1e-3);
        // (29) mirrors at L − ξ; the printed ξ − L is negative, where (28) has no branch.
        let mirrored = curve.at(&frame, LENGTH - xi).r;
        assert!((mirrored - Vector2::new(place.x, -place.y)).norm() < 1e-12);
    }
    let strand_end = Vector2::new(-r_s * phi.cos(), r_s * phi.sin()) + Vector2::new(phi.sin(), phi.cos()) * b;
    assert!((strand_end - used(begin)).norm() < 1e-12);
    println!(
        "(28): gap at the begin of the primary arc {:.0} mm with φ_P as printed, {:.0} mm with ξ_P as printed",
        1e3 * (printed(begin) - strand_end).norm(),
        1e3 * (printed_place(begin) - strand_end).norm()
    );
}

/// The shape function N_4 of 5.2: a straight element turns by a small angle, which bends nothing.
#[test]
fn shape_function_of_the_second_slope() {
    let length = 0.1;
    // N_4 as printed, and its second derivative over x.
    let printed = |x: f64| {
        (
            length / 8.0 * (1.0 + x - x * x - x * x * x),
            length / 8.0 * (-2.0 - 6.0 * x),
        )
    };
    let used = |x: f64| {
        let shape = Hermite::new(x);
        (length * shape.n[3], length * shape.ddn[3])
    };
    // ∫u''² dξ of u = ξ: values −l/2, l/2 and slopes 1 at the ends. d²/dξ² = (2/l)² d²/dx². Two
    // Gauss points are exact.
    let bending = |fourth: &dyn Fn(f64) -> (f64, f64)| {
        let at = |x: f64| {
            let shape = Hermite::new(x);
            let bend = (-shape.ddn[0] + shape.ddn[2]) * length / 2.0 + shape.ddn[1] * length + fourth(x).1;
            bend * bend * (2.0 / length).powi(4) * length / 2.0
        };
        let gauss = (1.0_f64 / 3.0).sqrt();
        at(-gauss) + at(gauss)
    };
    // ∫N_4''² = 4/l is the stiffness of an end that is turned alone.
    let share = bending(&printed) / (4.0 / length);
    println!("N_4 as printed: a rigid turn has {share:.2} times the bending energy of turning one end alone");
    assert!((printed(0.3).0 + used(0.3).0).abs() < 1e-15);
    assert!(bending(&used) < 1e-20 && share > 1.0);
}
