//! The ring alone: kinematics, inertia and elasticity against differences, and motions with known answers, for the
//! levels of detail `ALE` (deflecting) and `ALE0` (reference motion only).

use nalgebra::{DMatrix, DVector, Vector2};
use pushbelt::reference_curve::{Circle, ReferenceCurve, TwoPulley};
use pushbelt::ring::Ring;
use pushbelt::ring::mesh::RingMesh;
use pushbelt::ring::system::{Inertia, RingSystem, State};
use pushbelt::solver::arrow::{Arrow, ArrowLu};
use pushbelt::solver::sdirk::Sdirk;
use pushbelt::solver::{System, View};
use std::f64::consts::TAU;

/// The ring of the reference numbers for the paper's fig. 6 and 7: L = 1 m, d_A = 0.2 m. EA belongs to the same steel
/// section (E = 2.1e11 N/m², ρ = 7800 kg/m³).
fn solid() -> Ring {
    Ring {
        mass_per_length: 154.0,
        axial_stiffness: 154.0 / 7800.0 * 2.1e11,
        bending_stiffness: 35_000.0,
        damping: 0.0,
    }
}

fn solid_curve() -> TwoPulley {
    TwoPulley::new(0.2, 1.0)
}

/// A steel band of `thickness`, 9.5 mm wide.
fn band(thickness: f64) -> Ring {
    let (e, rho, width) = (2.1e11, 7800.0, 9.5e-3);
    Ring {
        mass_per_length: rho * thickness * width,
        axial_stiffness: e * thickness * width,
        bending_stiffness: e * width * thickness.powi(3) / 12.0,
        damping: 0.0,
    }
}

/// Circumference of the free band, m.
const BAND_LENGTH: f64 = 0.70;

fn band_circle() -> Circle {
    Circle {
        radius: BAND_LENGTH / TAU,
    }
}

/// First bending frequency of a free thin ring, Hz.
fn thin_ring_frequency(ring: &Ring, radius: f64) -> f64 {
    (36.0_f64 / 5.0).sqrt() * (ring.bending_stiffness / (ring.mass_per_length * radius.powi(4))).sqrt() / TAU
}

/// The same ring without stiffness: its residual is inertia alone.
fn without_stiffness(ring: Ring) -> Ring {
    Ring {
        axial_stiffness: 0.0,
        bending_stiffness: 0.0,
        ..ring
    }
}

fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

/// A smooth deflection of a few per cent of the ring, in motion, the same on every mesh. With `amplitude` 0 the state
/// moves along s and Θ only.
fn waving<C: ReferenceCurve>(system: &RingSystem<C>, theta: f64, amplitude: f64) -> State {
    let mut state = system.rest(theta);
    let length = system.curve.length();
    let frame = system.curve.frame::<f64>(theta);
    let wave = |k: f64, phase: f64, xi: f64| {
        let argument = TAU * k * xi / length + phase;
        (argument.sin(), argument.cos() * TAU * k / length)
    };
    for (i, element) in system.mesh.elements.iter().enumerate() {
        let xi = C::point(&frame, element.segment, element.start).xi.v;
        for (k, phase) in [(0, 0.3), (2, 1.1)] {
            let size = amplitude * length;
            let at = system.node(i, k);
            (state.q[at], state.q[at + 1]) = scaled(wave(2.0, phase, xi), 0.01 * size);
            (state.y[at], state.y[at + 1]) = scaled(wave(3.0, 2.0 * phase, xi), 0.5 * size);
            (state.y_dot[at], state.y_dot[at + 1]) = scaled(wave(1.0, 3.0 * phase, xi), 20.0 * size);
        }
    }
    let (s, theta) = (system.drift(), system.theta());
    state.y[s] = 6.0 * length;
    state.y_dot[s] = 90.0;
    if system.curve.has_ratio() {
        state.y[theta] = 8.0;
        state.y_dot[theta] = -70.0;
    }
    state
}

fn scaled((a, b): (f64, f64), factor: f64) -> (f64, f64) {
    (a * factor, b * factor)
}

fn residual<C: ReferenceCurve>(system: &mut RingSystem<C>, view: View<'_>) -> DVector<f64> {
    let mut out = vec![0.0; view.y.len()];
    system.residual(view, &mut out);
    DVector::from_vec(out)
}

/// The ring at the place ξ of the curve, wherever the mesh stands.
fn point_at<C: ReferenceCurve>(
    system: &RingSystem<C>,
    view: View<'_>,
    xi: f64,
) -> pushbelt::ring::kinematics::RingPoint<f64> {
    let frame = system.curve.frame::<f64>(view.q[system.theta()]);
    let (element, x) = system
        .mesh
        .elements
        .iter()
        .enumerate()
        .find_map(|(i, element)| {
            let start = C::point::<f64>(&frame, element.segment, 0.0).xi.v;
            let fraction = (xi - start) / C::segment_length::<f64>(&frame, element.segment).v;
            let x = 2.0 * (fraction - element.start) / element.share - 1.0;
            (-1.0..=1.0).contains(&x).then_some((i, x))
        })
        .expect("ξ lies on the curve");
    system.point(view, element, x)
}

/// Integrator with fixed steps.
fn fixed_steps<C: ReferenceCurve>(system: &mut RingSystem<C>, step: f64) -> Sdirk {
    system.tolerance = f64::INFINITY;
    Sdirk::new(system, step, step)
}

fn run<C: ReferenceCurve>(system: &mut RingSystem<C>, integrator: &mut Sdirk, state: &mut State, from: f64, to: f64) {
    integrator
        .advance(system, &mut state.y, &mut state.y_dot, &mut state.q, from, to)
        .expect("the free ring can be integrated");
}

/// Angular frequency and shape of the small oscillation about the rest state `state` nearest to `near`, rad/s.
fn mode<C: ReferenceCurve>(system: &mut RingSystem<C>, state: &State, near: f64) -> (f64, Vec<f64>) {
    let n = state.y.len();
    let matrix = |system: &mut RingSystem<C>, alpha: f64, beta: f64| {
        let mut a = Arrow::new(system.shape());
        system.jacobian(state.view(), alpha, beta, &mut a);
        a
    };
    let (mass, stiffness) = (matrix(system, 1.0, 0.0), matrix(system, 0.0, 1.0));
    let mut factors = ArrowLu::new(system.shape());
    let mut omega2 = near * near;
    factors.factor(&matrix(system, -omega2, 1.0)).unwrap();
    let mut random = noise(5);
    let mut v: Vec<f64> = (0..n).map(|_| random()).collect();
    let mut product = vec![0.0; n];
    let clear = |v: &mut [f64], system: &RingSystem<C>| system.locked.iter().for_each(|&i| v[i] = 0.0);
    for _ in 0..60 {
        clear(&mut v, system);
        mass.multiply(&v, &mut product);
        clear(&mut product, system);
        let norm = v.iter().zip(&product).map(|(a, b)| a * b).sum::<f64>().sqrt();
        v.iter_mut().for_each(|x| *x /= norm);
        stiffness.multiply(&v, &mut product);
        clear(&mut product, system);
        omega2 = v.iter().zip(&product).map(|(a, b)| a * b).sum();
        mass.multiply(&v, &mut product);
        clear(&mut product, system);
        factors.solve(&mut product);
        std::mem::swap(&mut v, &mut product);
    }
    (omega2.sqrt(), product)
}

/// Numbers in a line.
fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!(" {x:.2e}")).collect()
}

/// Orders between the errors of a ladder whose rungs differ by `ratio`.
fn orders(errors: &[f64], ratio: f64) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).ln() / ratio.ln()).collect()
}

// ---------------------------------------------------------------------------------------------------------------------
// Derivatives

/// P = [r', ∂r/∂Θ, B] (12): the velocity at a unit rate is how fast the particle at ξ = x̄ + s moves.
#[test]
fn velocity_follows_the_particle() {
    let system = RingSystem::flexible(solid(), solid_curve(), RingMesh::even(&[2, 3, 4, 3, 2], 3));
    let mut state = waving(&system, 0.25, 1.0);
    let (s, h) = (system.drift(), 1.0e-5);
    for xi in [0.01, 0.093, 0.2, 0.31, 0.505, 0.62, 0.81, 0.97] {
        for i in 0..state.y.len() {
            state.y.fill(0.0);
            state.y[i] = 1.0;
            let velocity = point_at(&system, state.view(), xi).velocity();
            let place = |h: f64| {
                let mut moved = state.clone();
                moved.q[i] += h;
                point_at(&system, moved.view(), if i == s { xi + h } else { xi }).r
            };
            let difference = (place(h) - place(-h)) / (2.0 * h);
            assert!(
                (velocity - difference).norm() < 1e-8,
                "ξ = {xi}, unknown {i}: {velocity} {difference}"
            );
        }
    }
}

/// Dv/Dt, strain rate and velocity on a path q(t): differences in time of the particle's place and stretch.
#[test]
fn acceleration_follows_the_particle() {
    let system = RingSystem::flexible(solid(), solid_curve(), RingMesh::even(&[2, 3, 4, 3, 2], 3));
    let state = waving(&system, -0.3, 1.0);
    let at_time = |t: f64| {
        let mut moved = state.clone();
        for i in 0..state.q.len() {
            moved.q[i] += t * (state.y[i] + 0.5 * t * state.y_dot[i]);
        }
        moved
    };
    let h = 2.0e-5;
    for xi in [0.01, 0.15, 0.4, 0.6, 0.8, 0.95] {
        let particle = |t: f64| {
            let moved = at_time(t);
            let s = moved.q[system.drift()];
            point_at(&system, moved.view(), xi + s)
        };
        let now = point_at(&system, state.view(), xi);
        let (before, after) = (particle(-h), particle(h));
        let second = (before.r - now.r * 2.0 + after.r) / (h * h);
        let acceleration = now.acceleration();
        assert!(
            (acceleration - second).norm() < 1e-5 * second.norm(),
            "ξ = {xi}: {acceleration} {second}"
        );
        assert!((now.velocity() - (after.r - before.r) / (2.0 * h)).norm() < 1e-6 * now.velocity().norm());
        let rate = (after.strain() - before.strain()) / (2.0 * h);
        assert!(
            (now.strain_rate() - rate).abs() < 1e-5 * rate.abs(),
            "{} {rate}",
            now.strain_rate()
        );
    }
}

/// The residual at rest is ∂V/∂q, moving arc borders included: there the curvature jumps.
#[test]
fn elastic_force_is_the_gradient_of_the_energy() {
    let check = |mut system: RingSystem<TwoPulley>, amplitude: f64| {
        system.locked.clear();
        let mut state = waving(&system, 0.25, amplitude);
        state.y.fill(0.0);
        state.y_dot.fill(0.0);
        let force = residual(&mut system, state.view());
        let h = 1.0e-6;
        let scale = force.amax();
        for i in 0..state.q.len() {
            let energy = |h: f64| {
                let mut moved = state.clone();
                moved.q[i] += h;
                let energy = system.energy(moved.view());
                energy.membrane + energy.bending
            };
            let difference = (energy(h) - energy(-h)) / (2.0 * h);
            assert!(
                (force[i] - difference).abs() < 3e-8 * scale,
                "unknown {i}: {} {difference} {scale}",
                force[i]
            );
        }
        scale
    };
    let mesh = RingMesh::even(&[2, 2, 3, 2, 2], 3);
    check(RingSystem::flexible(solid(), solid_curve(), mesh.clone()), 0.3);
    check(RingSystem::rigid(solid(), solid_curve(), mesh), 0.0);
}

/// What the damping force takes is ∫EA η (Dγ/Dt)² dξ.
#[test]
fn damping_takes_what_it_says() {
    let mesh = RingMesh::even(&[2, 2, 3, 2, 2], 3);
    let damped = Ring {
        damping: 1.0e-4,
        ..solid()
    };
    let mut with = RingSystem::flexible(damped, solid_curve(), mesh.clone());
    let mut without = RingSystem::flexible(solid(), solid_curve(), mesh);
    let state = waving(&with, 0.25, 0.3);
    with.locked.clear();
    without.locked.clear();
    let force = residual(&mut with, state.view()) - residual(&mut without, state.view());
    let power: f64 = force.iter().zip(&state.y).map(|(f, y)| f * y).sum();
    let expected = with.integrate(state.view(), |p| {
        with.ring.axial_stiffness * with.ring.damping * p.strain_rate().powi(2)
    });
    assert!((power / expected - 1.0).abs() < 1e-9, "{power} {expected}");
}

/// (13) and (14) from differences of the mass matrix: M q̈ + Ṁ q̇ − ∂T/∂q.
fn inertia_by_differences<C: ReferenceCurve>(system: &RingSystem<C>, state: &State) -> DVector<f64> {
    let rate = DVector::from_column_slice(&state.y);
    let moved = |i: Option<usize>, h: f64| {
        let mut q = state.q.clone();
        match i {
            Some(i) => q[i] += h,
            None => q.iter_mut().zip(&state.y).for_each(|(q, y)| *q += h * y),
        }
        system.mass_matrix(&q)
    };
    let h = 1.0e-6;
    let along = (moved(None, h) - moved(None, -h)) / (2.0 * h);
    let mut force = system.mass_matrix(&state.q) * DVector::from_column_slice(&state.y_dot) + along * &rate;
    for i in 0..state.q.len() {
        let slope: DMatrix<f64> = (moved(Some(i), h) - moved(Some(i), -h)) / (2.0 * h);
        force[i] -= 0.5 * rate.dot(&(slope * &rate));
    }
    force
}

/// Relative error of the residual's inertia against [`inertia_by_differences`].
fn inertia_error<C: ReferenceCurve>(mut system: RingSystem<C>, inertia: Inertia, amplitude: f64) -> f64 {
    system.ring = without_stiffness(system.ring);
    system.inertia = inertia;
    system.locked.clear();
    let state = waving(&system, 0.25, amplitude);
    let direct = residual(&mut system, state.view());
    let expected = inertia_by_differences(&system, &state);
    (direct - &expected).amax() / expected.amax()
}

/// The conservative form is Lagrange's on every mesh. Dv/Dt at the points differs from it by ∮∂(…)/∂ξ dξ = 0, which a
/// quadrature integrates inexactly: the difference must fall with Gauss points and with the mesh.
#[test]
fn inertia_is_lagranges() {
    let mesh = |refinement: usize, points: usize| RingMesh::even(&[1, 1, 2, 1, 1].map(|n| n * refinement), points);
    let flexible = |inertia, refinement, points| {
        inertia_error(
            RingSystem::flexible(solid(), solid_curve(), mesh(refinement, points)),
            inertia,
            1.0,
        )
    };
    let rigid =
        |inertia, points| inertia_error(RingSystem::rigid(solid(), solid_curve(), mesh(1, points)), inertia, 0.0);
    for points in 2..=5 {
        assert!(flexible(Inertia::Conservative, 1, points) < 1e-9);
        assert!(rigid(Inertia::Conservative, points) < 1e-9 && rigid(Inertia::Pointwise, points) < 1e-9);
    }
    let by_points: Vec<f64> = (2..=5).map(|points| flexible(Inertia::Pointwise, 1, points)).collect();
    let by_mesh: Vec<f64> = [1, 2, 4]
        .map(|refinement| flexible(Inertia::Pointwise, refinement, 3))
        .to_vec();
    println!(
        "2 to 5 points {}; 6, 12, 24 elements {}",
        list(&by_points),
        list(&by_mesh)
    );
    assert!(by_points.windows(2).all(|e| e[1] < 0.1 * e[0]) && by_points[3] < 1e-6);
    assert!(by_mesh.windows(2).all(|e| e[1] < 0.1 * e[0]));
}

/// The printed (14), 2ρA q̇ᵀ∫PᵀṖ, holds only where ∫PᵀṖ is symmetric. On a circle P = [r', B] and Ṗ = [ṙ', 0]:
/// the printed form gives 2∫m_r v·ṙ' to s and nothing to q_f.
#[test]
fn the_printed_convective_term_is_wrong() {
    let mesh = RingMesh::even(&[12], 5);
    let mut system = RingSystem::flexible(solid(), band_circle(), mesh);
    system.ring = without_stiffness(system.ring);
    system.locked.clear();
    let mut state = waving(&system, 0.0, 1.0);
    state.y_dot.fill(0.0);
    let right = inertia_by_differences(&system, &state);
    let direct = residual(&mut system, state.view());
    // Both share −∂T/∂q (13); Ṁq̇ is exchanged for the printed term.
    let h = 1.0e-6;
    let moved = |h: f64| {
        let q: Vec<f64> = state.q.iter().zip(&state.y).map(|(q, y)| q + h * y).collect();
        system.mass_matrix(&q)
    };
    let mut printed = &right - (moved(h) - moved(-h)) / (2.0 * h) * DVector::from_column_slice(&state.y);
    printed[system.drift()] += system.integrate(state.view(), |p| {
        2.0 * system.ring.mass_per_length * p.velocity().dot(&p.slope_dot)
    });
    let (ours, theirs) = (
        (direct - &right).amax() / right.amax(),
        (printed - &right).amax() / right.amax(),
    );
    println!("printed (14): off by {theirs:.1e}; Dv/Dt: {ours:.1e}");
    assert!(ours < 1e-7 && theirs > 1e-2);
}

// ---------------------------------------------------------------------------------------------------------------------
// Motions with known answers

/// Reference oscillation (paper fig. 6).
#[test]
fn reference_oscillation_has_the_reference_numbers() {
    let (r_p, r_s) = solid_curve().radii(1.0).unwrap();
    assert!((r_p - 0.095_493).abs() < 5e-7 && (r_s - r_p).abs() < 1e-12);
    let (r_p, r_s) = solid_curve().radii(0.6 / 1.4).unwrap();
    assert!((r_p - 0.127_690).abs() < 5e-7 && (r_s - 0.054_724).abs() < 5e-7);
    let mut system = RingSystem::rigid(solid(), solid_curve(), RingMesh::even(&[4, 4, 8, 4, 4], 5));
    let (s, theta) = (system.drift(), system.theta());
    for (at, potential, inertia) in [(0.0, 1_151_453.8, 3.10883), (0.4, 1_298_705.6, 2.04239)] {
        let state = system.rest(at);
        let energy = system.energy(state.view());
        let mass = system.mass_matrix(&state.q);
        println!(
            "Θ = {at}: V = {:.1} J, M_ΘΘ = {:.5}, M_sΘ = {:.1e}",
            energy.bending,
            mass[(theta, theta)],
            mass[(s, theta)]
        );
        assert!((energy.total() - potential).abs() < 0.06);
        assert!((mass[(theta, theta)] - inertia).abs() < 6e-6);
        assert!(mass[(s, theta)].abs() < 1e-12);
    }
    let rest = system.rest(0.0);
    let (omega, _) = mode(&mut system, &rest, 700.0);
    println!("small oscillation {omega:.3} rad/s");
    assert!((omega - 718.05).abs() < 5e-3);
}

/// From Θ = 0.4 at rest the reference motion swings to −0.4 and back; s stays 0.
#[test]
fn reference_oscillation_conserves_energy() {
    let mut drifts = Vec::new();
    for tolerance in [1.0e-6, 1.0e-7, 1.0e-8] {
        let mut system = RingSystem::rigid(solid(), solid_curve(), RingMesh::even(&[2, 2, 4, 2, 2], 5));
        system.tolerance = tolerance;
        let (s, theta) = (system.drift(), system.theta());
        let mut state = system.rest(0.4);
        let start = system.energy(state.view()).total();
        let swing = start - system.energy(system.rest(0.0).view()).total();
        let mut integrator = Sdirk::new(&system, 1.0e-5, 1.0e-3);
        let (mut low, mut high, mut drift) = (0.0_f64, 0.0_f64, 0.0_f64);
        for k in 0..100 {
            let t = f64::from(k) * 2.0e-4;
            run(&mut system, &mut integrator, &mut state, t, t + 2.0e-4);
            (low, high) = (low.min(state.q[theta]), high.max(state.q[theta]));
            drift = drift.max((system.energy(state.view()).total() - start).abs() / swing);
            assert!(state.q[s].abs() < 1e-9, "s = {}", state.q[s]);
        }
        let counts = integrator.newton.counts;
        println!(
            "tolerance {tolerance:.0e}: energy drift {drift:.2e} of the swing, Θ from {low:.4} to {high:.4}, {counts:?}"
        );
        assert!((low + 0.4).abs() < 0.01 && (high - 0.4).abs() < 0.01);
        drifts.push(drift);
    }
    assert!(
        drifts[2] < 1e-4 && drifts.windows(2).all(|d| d[1] < 0.4 * d[0]),
        "{drifts:?}"
    );
}

/// Paper fig. 7: 8 elements, from Θ = 0.4 at rest for 0.3 ms. Height of the strands' middles above their chords at
/// every 50 µs, m, and the largest energy drift relative to the energy.
fn deformable_ring(inertia: Inertia, tolerance: f64) -> (Vec<f64>, f64) {
    let mut system = RingSystem::flexible(solid(), solid_curve(), RingMesh::even(&[1, 2, 2, 2, 1], 3));
    system.inertia = inertia;
    system.tolerance = tolerance;
    let mut state = system.rest(0.4);
    let start = system.energy(state.view()).total();
    let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-3);
    let (mut drift, mut bulges) = (0.0_f64, Vec::new());
    for k in 0..6 {
        let t = f64::from(k) * 5.0e-5;
        run(&mut system, &mut integrator, &mut state, t, t + 5.0e-5);
        let [upper, lower] = [1_usize, 5].map(|element| {
            let at = |i, x| system.point(state.view(), element + i, x).r;
            let [from, middle, to] = [at(0, -1.0), at(0, 1.0), at(1, 1.0)];
            let chord = (to - from).normalize();
            (middle - from).dot(&Vector2::new(-chord.y, chord.x))
        });
        assert!((upper - lower).abs() < 1e-6, "at {t} s: {upper} and {lower} m");
        bulges.push(upper);
        let energy = system.energy(state.view());
        drift = drift.max((energy.total() / start - 1.0).abs());
        // Nothing drives the drift: its momentum ∂T/∂ṡ stays zero.
        let momentum = (system.mass_matrix(&state.q) * DVector::from_column_slice(&state.y))[system.drift()];
        let size = (2.0 * energy.kinetic * system.ring.mass_per_length).sqrt();
        assert!(momentum.abs() < 1e-6 * size, "{momentum} of {size}");
    }
    println!(
        "{inertia:?}, tolerance {tolerance:.0e}: bulge {} m, Θ = {:.3}, energy drift {drift:.2e}, {:?}",
        list(&bulges),
        state.q[system.theta()],
        integrator.newton.counts
    );
    (bulges, drift)
}

/// After a first bending wave of 1 mm the strands bulge outwards by 15 mm within 0.3 ms and the ring becomes rounder.
/// Later its leftmost point comes so close to the axis of S that Θ can't follow (Θ → 1 at 1.1 ms): the run ends before.
#[test]
fn deformable_ring_bulges_and_conserves_energy() {
    let runs = [1.0e-5, 1.0e-6, 1.0e-7].map(|tolerance| deformable_ring(Inertia::Conservative, tolerance));
    for (bulges, _) in &runs {
        assert!(bulges[0] > -2.0e-3 && bulges[1..].windows(2).all(|b| b[1] > b[0]) && bulges[5] > 0.01);
    }
    assert!(runs[2].1 < 5e-5 && runs.windows(2).all(|pair| pair[1].1 < 0.3 * pair[0].1));
    // Dv/Dt at the points leaves a drift that no tolerance removes.
    assert!(deformable_ring(Inertia::Pointwise, 1.0e-7).1 > 10.0 * runs[2].1);
}

/// A ring that runs on a circle carries EAγ = m_r ṡ²(1 + γ) and keeps its shape.
#[test]
fn running_ring_stays_round() {
    let ring = band(0.185e-3);
    let mut shapes = Vec::new();
    for n in [10, 20, 40] {
        let mut system = RingSystem::flexible(ring.clone(), band_circle(), RingMesh::even(&[n], 3));
        let speed = 100.0;
        let pull = ring.mass_per_length * speed * speed;
        let gamma = pull / (ring.axial_stiffness - pull);
        let mut state = system.rest(0.0);
        for i in 0..n {
            let p = system.point(state.view(), i, -1.0).reference;
            for (k, value) in [p.r.x, p.t.x, p.r.y, p.t.y].into_iter().enumerate() {
                let at = system.node(i, k);
                state.q[at] = gamma * value;
            }
        }
        let drift = system.drift();
        state.y[drift] = speed;
        let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-3);
        // Five turns.
        run(&mut system, &mut integrator, &mut state, 0.0, 5.0 * BAND_LENGTH / speed);
        let off = |x: f64| {
            (0..n)
                .map(|i| (system.point(state.view(), i, x).strain() / gamma - 1.0).abs())
                .fold(0.0, f64::max)
        };
        let off = off(-1.0).max(off(0.0));
        println!(
            "{n} elements: γ = {gamma:.3e}, off by {off:.2e}, {:?}",
            integrator.newton.counts
        );
        assert!((state.y[drift] / speed - 1.0).abs() < 1e-3 * off);
        shapes.push(off);
    }
    assert!(
        shapes[2] < 1e-5 && orders(&shapes, 2.0).iter().all(|order| (order - 4.0).abs() < 0.2),
        "{shapes:?}"
    );
}

/// A free thin ring: f_2 within 0.5 % at 40 elements and converging. The thin band's EA R²/EI = 4.4e6 makes its
/// membrane lock on coarse meshes, so the order comes late and is the membrane's, 6; see [`order_in_space`].
#[test]
fn free_ring_frequency() {
    let ring = band(0.185e-3);
    let exact = thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    assert!((exact - 9.534).abs() < 1e-3);
    let errors: Vec<f64> = [20, 40, 80, 160]
        .iter()
        .map(|&n| {
            let mut system = RingSystem::flexible(ring.clone(), band_circle(), RingMesh::even(&[n], 3));
            let rest = system.rest(0.0);
            mode(&mut system, &rest, 1.02 * TAU * exact).0 / (TAU * exact) - 1.0
        })
        .collect();
    println!(
        "20 to 160 elements: off by {}; orders {:.2?}",
        list(&errors),
        orders(&errors, 2.0)
    );
    assert!(errors[1].abs() < 5e-3 && errors[3].abs() < 1e-4);
    assert!(orders(&errors, 2.0).windows(2).all(|o| o[0] > 2.0 && o[1] > o[0]));
}

/// The same mode in time: after whole periods it has its first velocities again.
#[test]
fn free_ring_swings_at_its_frequency() {
    let (mut system, mut state, omega) = swinging_band(0.185e-3, 1.0e-4);
    let period = TAU / omega;
    let mut integrator = fixed_steps(&mut system, period / 400.0);
    let start = state.clone();
    run(&mut system, &mut integrator, &mut state, 0.0, 3.0 * period);
    let size = start.y.iter().fold(0.0_f64, |a, y| a.max(y.abs()));
    let off = start
        .y
        .iter()
        .zip(&state.y)
        .fold(0.0_f64, |a, (x, y)| a.max((x - y).abs()));
    println!("after three periods {:.2e} of the velocity is off", off / size);
    assert!(off < 5e-3 * size);
}

/// From the two-arc shape Θ = 0.4, d_A = 0.155 m, at rest, the full nonlinear ring swings at 9.23 Hz. Here the shape is
/// a deflection from a circle, and the linear curvature measure makes the ring swing at 8.5 Hz: reported, not judged.
#[test]
fn large_oscillation_is_too_slow() {
    let curve = TwoPulley::new(0.155, BAND_LENGTH);
    let n = 40;
    let mut system = RingSystem::flexible(band(0.185e-3), band_circle(), RingMesh::even(&[n], 3));
    system.tolerance = 1.0e-4;
    let mut state = system.rest(0.0);
    let mut arcs = RingSystem::rigid(band(0.185e-3), curve, RingMesh::even(&[1, 1, 1, 1, 1], 3));
    arcs.locked.clear();
    let shape = arcs.rest(0.4);
    let leftmost = point_at(&arcs, shape.view(), 0.0).r;
    for i in 0..n {
        let from = system.point(state.view(), i, -1.0).reference;
        let to = point_at(&arcs, shape.view(), from.xi.v).reference;
        // Both start at their leftmost point.
        let a = (to.r - leftmost) - (from.r + Vector2::new(BAND_LENGTH / TAU, 0.0));
        let b = to.t - from.t;
        for (k, value) in [a.x, b.x, a.y, b.y].into_iter().enumerate() {
            let at = system.node(i, k);
            state.q[at] = value;
        }
    }
    // Mean square extent along the centre line less that across it.
    let ovality = |system: &RingSystem<Circle>, state: &State| {
        let mean = system.integrate(state.view(), |p| p.r.x) / BAND_LENGTH;
        system.integrate(state.view(), |p| (p.r.x - mean).powi(2) - p.r.y.powi(2))
    };
    let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-2);
    let (mut before, mut crossings, mut t) = (ovality(&system, &state), Vec::new(), 0.0);
    while crossings.len() < 3 && t < 0.2 {
        run(&mut system, &mut integrator, &mut state, t, t + 1.0e-3);
        let now = ovality(&system, &state);
        if before * now < 0.0 {
            crossings.push(t + 1.0e-3 * before / (before - now));
        }
        (before, t) = (now, t + 1.0e-3);
    }
    let frequency = 1.0 / (crossings[2] - crossings[0]);
    println!(
        "{frequency:.2} Hz; first quarter {:.2} Hz; {:?}",
        0.25 / crossings[0],
        integrator.newton.counts
    );
    assert!((8.0..9.3).contains(&frequency));
}

// ---------------------------------------------------------------------------------------------------------------------
// Orders of convergence

/// A free band of `thickness` in its first bending mode, `amplitude` in units of the radius; with its frequency, rad/s.
fn swinging_band(thickness: f64, amplitude: f64) -> (RingSystem<Circle>, State, f64) {
    let ring = band(thickness);
    let near = 1.02 * TAU * thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    let mut system = RingSystem::flexible(ring, band_circle(), RingMesh::even(&[40], 3));
    let mut state = system.rest(0.0);
    let (omega, shape) = mode(&mut system, &state, near);
    let height = |i: usize| shape[system.node(i, 0)].hypot(shape[system.node(i, 2)]);
    let largest = (0..40).map(height).fold(0.0, f64::max);
    let scale = amplitude * BAND_LENGTH / TAU * omega / largest;
    state.y.iter_mut().zip(&shape).for_each(|(y, x)| *y = scale * x);
    (system, state, omega)
}

/// Asserts `≈ order ± 0.2` on a ladder of halved steps or element lengths.
fn assert_order(name: &str, errors: &[f64], expected: f64) {
    let observed = orders(errors, 2.0);
    println!("{name}: errors {}, orders {observed:.2?}", list(errors));
    assert!(
        observed.iter().all(|order| (order - expected).abs() < 0.2),
        "{name}: {observed:?}"
    );
}

/// Cubic elements give frequencies of order 4, unless the membrane is so stiff that it decides.
#[test]
fn order_in_space() {
    let radius = BAND_LENGTH / TAU;
    let thin = band(0.185e-3);
    let ring = Ring {
        axial_stiffness: 10.0 * thin.bending_stiffness / (radius * radius),
        ..thin
    };
    let near = 0.9 * TAU * thin_ring_frequency(&ring, radius);
    let frequency = |n: usize| {
        let mut system = RingSystem::flexible(ring.clone(), band_circle(), RingMesh::even(&[n], 5));
        let rest = system.rest(0.0);
        mode(&mut system, &rest, near).0
    };
    let exact = frequency(192);
    let errors: Vec<f64> = [6, 12, 24, 48].map(|n| frequency(n) / exact - 1.0).to_vec();
    assert_order("frequency", &errors, 4.0);
}

/// The integrator's order 2, on a nonlinear motion of two coordinates and on rings with stiff membranes.
#[test]
fn order_in_time() {
    let theta = |step: f64| {
        let mut system = RingSystem::rigid(solid(), solid_curve(), RingMesh::even(&[1, 1, 2, 1, 1], 5));
        let mut integrator = fixed_steps(&mut system, step);
        let mut state = system.rest(0.4);
        run(&mut system, &mut integrator, &mut state, 0.0, 5.0e-3);
        state.q[system.theta()]
    };
    let exact = theta(1.0e-6);
    let errors: Vec<f64> = [1.0e-4, 5.0e-5, 2.5e-5]
        .map(|step| (theta(step) - exact).abs())
        .to_vec();
    assert_order("ALE0", &errors, 2.0);
    for thickness in [5.0e-3, 0.185e-3] {
        let shape = |steps: f64| {
            let (mut system, mut state, omega) = swinging_band(thickness, 1.0e-2);
            let period = TAU / omega;
            let mut integrator = fixed_steps(&mut system, period / steps);
            run(&mut system, &mut integrator, &mut state, 0.0, 1.2 * period);
            state.q
        };
        let exact = shape(3000.0);
        let off = |q: &[f64]| q.iter().zip(&exact).fold(0.0_f64, |a, (x, y)| a.max((x - y).abs()));
        let errors: Vec<f64> = [50.0, 100.0, 200.0].map(|steps| off(&shape(steps))).to_vec();
        assert_order(&format!("band of {thickness} m"), &errors, 2.0);
    }
}
