//! One suite for all ring models.

use crate::common::*;
use nalgebra::Vector2;
use num_dual::Dual64;
use pushbelt::reference_curve::ReferenceCurve;
use pushbelt::ring::Ring;
use pushbelt::ring::ancf::AncfElement;
use pushbelt::ring::kinematics::{Motion, ReferenceMotion};
use pushbelt::ring::lagrangian::{LagrangianElement, LagrangianRing};
use pushbelt::ring::model::{NODAL, RingModel};
use pushbelt::ring::particle::ParticleLoad;
use pushbelt::ring::rcm::RcmElement;
use pushbelt::ring::system::{RingSystem, State};
use pushbelt::solver::View;
use pushbelt::solver::sdirk::Sdirk;
use std::f64::consts::TAU;

/// Number of elements in the tests of derivatives: every kind of neighbourhood occurs.
const FEW: usize = 12;

/// A ring on the reference curve at Θ with deflections of a few per cent, in motion.
fn waving<M: RingModel>(system: &RingSystem<M>, theta: f64, amplitude: f64) -> State {
    let mut state = system.rest(theta);
    let length = system.model.length();
    let mut random = noise(11);
    for i in 0..system.drift() {
        let length = if system.model.is_length(i % M::BLOCK) {
            length
        } else {
            1.0
        };
        let step = length * amplitude / system.model.elements() as f64;
        state.q[i] += 0.05 * step * random();
        state.y[i] = 5.0 * step * random();
        state.y_dot[i] = 200.0 * step * random();
    }
    let (s, theta) = (system.drift(), system.theta());
    state.y[s] = 6.0 * length;
    state.y_dot[s] = 90.0;
    if !system.held.contains(&theta) {
        state.y[theta] = 8.0;
        state.y_dot[theta] = -70.0;
    }
    state
}

fn lagrangian<M: RingModel>(_: &RingSystem<M>) -> bool {
    M::LAGRANGIAN
}

/// Unknowns whose rows are balances of force: without s and Θ on a mesh that travels.
fn forces<M: RingModel>(system: &RingSystem<M>) -> usize {
    if M::LAGRANGIAN {
        system.drift()
    } else {
        system.theta() + 1
    }
}

const PLACES: [f64; 8] = [0.01, 0.093, 0.2, 0.31, 0.505, 0.62, 0.81, 0.97];

/// P (12): the velocity at a unit rate is how fast the particle at ξ = x̄ + s moves.
fn velocity_follows_the_particle<S: Case>() {
    let system = S::system(solid(), solid_curve(), FEW);
    let mut state = waving(&system, 0.25, 1.0);
    let (s, h) = (system.drift(), 3.0e-6);
    for xi in PLACES {
        for i in 0..state.y.len() {
            if lagrangian(&system) && i > s {
                continue;
            }
            state.y.fill(0.0);
            state.y[i] = 1.0;
            let velocity = system.particle_at(state.view(), xi).velocity;
            let place = |h: f64| {
                let mut moved = state.clone();
                moved.q[i] += h;
                system.particle_at(moved.view(), if i == s { xi + h } else { xi }).r
            };
            let difference = (place(h) - place(-h)) / (2.0 * h);
            assert!(
                (velocity - difference).norm() < 1e-8,
                "ξ = {xi}, unknown {i}: {velocity} {difference}"
            );
        }
    }
}

/// Dv/Dt, v', strain rate and velocity on a path q(t): differences in time of the particle's place and slope. The Eulerian
/// view sees the same at a station that stands in space.
fn acceleration_follows_the_particle<S: Case>() {
    let system = S::system(solid(), solid_curve(), FEW);
    let state = waving(&system, -0.3, 1.0);
    let at_time = |t: f64| {
        let mut moved = state.clone();
        for i in 0..state.q.len() {
            moved.q[i] += t * (state.y[i] + 0.5 * t * state.y_dot[i]);
        }
        moved
    };
    let h = 1.0e-5;
    let close = |a: Vector2<f64>, b: Vector2<f64>, tolerance: f64, what: &str, xi: f64| {
        assert!((a - b).norm() < tolerance * b.norm(), "{what} at ξ = {xi}: {a} {b}");
    };
    for xi in PLACES {
        let particle = |t: f64| {
            let moved = at_time(t);
            let drift = moved.q[system.drift()] - state.q[system.drift()];
            system.particle_at(moved.view(), xi + drift)
        };
        let now = system.particle_at(state.view(), xi);
        let (before, after) = (particle(-h), particle(h));
        let near = [-0.2 * h, 0.2 * h].map(particle);
        close(
            now.acceleration,
            (before.r - now.r * 2.0 + after.r) / (h * h),
            2e-5,
            "Dv/Dt",
            xi,
        );
        close(now.velocity, (after.r - before.r) / (2.0 * h), 1e-6, "v", xi);
        close(
            now.velocity_slope,
            (after.slope - before.slope) / (2.0 * h),
            1e-5,
            "v'",
            xi,
        );
        let rate = (near[1].strain() - near[0].strain()) / (0.4 * h);
        assert!(
            (now.strain_rate() - rate).abs() < 1e-5 * rate.abs().max(1.0),
            "{} {rate}",
            now.strain_rate()
        );
    }
}

/// r' and r'' are derivatives along ξ inside an element.
fn primes_are_derivatives<S: Case>() {
    let system = S::system(solid(), solid_curve(), FEW);
    let state = waving(&system, 0.25, 1.0);
    let frame = system.frame(state.view());
    let h = 1.0e-5;
    for element in 0..system.model.elements() {
        for x in [-0.7, 0.1, 0.6] {
            let at = |x: f64| {
                system
                    .model
                    .particle(&frame, element, x, &system.values(state.view(), element))
            };
            let (now, scale) = at(x);
            let (before, after) = (at(x - h).0, at(x + h).0);
            let along = |a: Vector2<f64>, b: Vector2<f64>| (a - b) / (2.0 * h * scale);
            assert!((now.slope - along(after.r, before.r)).norm() < 1e-7);
            assert!((now.bend - along(after.slope, before.slope)).norm() < 1e-6 * now.bend.norm().max(1.0));
            let gradient = along(after.velocity, before.velocity);
            assert!((now.velocity_slope - gradient).norm() < 1e-6 * gradient.norm().max(1.0));
        }
    }
}

/// What a station in space sees of the passing particle: differences in time of place and slope at fixed ξ.
fn a_station_sees_the_particle_pass<S: Case>() {
    let system = S::system(solid(), solid_curve(), FEW);
    let mut state = waving(&system, 0.25, 1.0);
    // Stations at fixed ξ, so Θ stands still.
    let theta = system.theta();
    (state.y[theta], state.y_dot[theta]) = (0.0, 0.0);
    let s = system.drift();
    let motion = ReferenceMotion {
        theta: Motion {
            value: 0.25,
            rate: 0.0,
            acceleration: 0.0,
        },
        s_dot: state.y[s],
        s_ddot: state.y_dot[s],
    };
    let curve = solid_curve();
    for xi in PLACES {
        let at = |t: f64| {
            let mut moved = state.clone();
            for i in 0..state.q.len() {
                moved.q[i] += t * (state.y[i] + 0.5 * t * state.y_dot[i]);
            }
            system.particle_at(moved.view(), xi)
        };
        let point = at(0.0).at_station(curve.at(&curve.frame::<f64>(0.25), xi), &motion);
        let h = 1.0e-5;
        let (before, after) = (at(-h), at(h));
        let close = |a: Vector2<f64>, b: Vector2<f64>, tolerance: f64| {
            assert!((a - b).norm() < tolerance * b.norm(), "{a} {b}")
        };
        let near = [-0.2 * h, 0.2 * h].map(at);
        close(point.r_dot, (near[1].r - near[0].r) / (0.4 * h), 1e-6);
        close(point.slope_dot, (near[1].slope - near[0].slope) / (0.4 * h), 1e-6);
        close(point.r_ddot, (after.r - point.r * 2.0 + before.r) / (h * h), 5e-5);
        close(point.velocity(), at(0.0).velocity, 1e-12);
        close(point.acceleration(), at(0.0).acceleration, 1e-12);
    }
}

/// Power of a load on a particle = its generalised forces on the rates.
fn projection_is_the_transpose<S: Case>() {
    let system = S::system(solid(), solid_curve(), FEW);
    let state = waving(&system, 0.25, 1.0);
    let frame = system.frame(state.view());
    let mut random = noise(7);
    let mut vector = || Vector2::new(random(), random());
    for element in 0..system.model.elements() {
        let motion = system.values(state.view(), element);
        for x in [-1.0, -0.3, 0.8] {
            let (particle, _) = system.model.particle(&frame, element, x, &motion);
            let load = ParticleLoad {
                position: vector(),
                slope: vector(),
                ..ParticleLoad::zero()
            };
            let rows = system.model.project(&frame, element, x, &motion, &load);
            let power: f64 = rows.iter().zip(&motion).map(|(row, m)| row * m.rate).sum();
            let expected = load.position.dot(&particle.velocity) + load.slope.dot(&particle.velocity_slope);
            assert!(
                (power - expected).abs() < 1e-10 * expected.abs().max(1.0),
                "{power} {expected}"
            );
            assert!(!lagrangian(&system) || rows[NODAL..].iter().all(|&row| row == 0.0));
        }
    }
}

/// The residual at rest is ∂V/∂q, moving arc borders included: there the curvature jumps.
fn elastic_force_is_the_gradient_of_the_energy<S: Case>() {
    let mut system = S::system(solid(), solid_curve(), FEW);
    system.held.clear();
    let mut state = waving(&system, 0.25, 0.3);
    state.y.fill(0.0);
    state.y_dot.fill(0.0);
    let force = residual(&mut system, state.view());
    let h = 1.0e-6;
    let scale = force.amax();
    for i in 0..forces(&system) {
        let energy = |h: f64| {
            let mut moved = state.clone();
            moved.q[i] += h;
            let energy = system.energy(moved.view());
            energy.membrane + energy.bending
        };
        let difference = (energy(h) - energy(-h)) / (2.0 * h);
        assert!(
            (force[i] - difference).abs() < 1e-7 * scale,
            "unknown {i}: {} {difference} {scale}",
            force[i]
        );
    }
}

/// What the damping force takes is what the model says it takes.
fn damping_takes_what_it_says<S: Case>() {
    let damped = Ring {
        damping: 1.0e-4,
        ..solid()
    };
    let mut with = S::system(damped, solid_curve(), FEW);
    let mut without = S::system(solid(), solid_curve(), FEW);
    let state = waving(&with, 0.25, 0.3);
    with.held.clear();
    without.held.clear();
    let force = residual(&mut with, state.view()) - residual(&mut without, state.view());
    let power: f64 = force.iter().zip(&state.y).map(|(f, y)| f * y).sum();
    let expected = with.dissipation(state.view());
    assert!((power / expected - 1.0).abs() < 1e-8, "{power} {expected}");
}

/// Inertia is M q̈ + Ṁq̇ − ∂T/∂q of the discrete ring.
fn inertia_is_lagranges<S: Case>() {
    let mut system = S::system(solid(), solid_curve(), FEW);
    *system.model.ring_mut() = without_stiffness(system.model.ring());
    system.held.clear();
    let state = waving(&system, 0.25, 1.0);
    let rows = forces(&system);
    let direct = residual(&mut system, state.view());
    let expected = inertia_by_differences(&system, &state);
    let off = (direct - &expected).rows(0, rows).amax() / expected.rows(0, rows).amax();
    println!("{}: inertia off by {off:.1e}", S::NAME);
    assert!(off < 1e-8);
}

/// Paper fig. 7 with about 12 elements: from Θ = 0.4 at rest for 0.2 ms. Height of the upper strand's middle above its chord
/// at every 50 µs, m, and the largest energy drift relative to the energy.
fn deformable_ring<S: Case>(tolerance: f64) -> (Vec<f64>, f64) {
    let mut system = S::system(solid(), solid_curve(), FEW);
    system.tolerance = tolerance;
    let mut state = system.rest(0.4);
    let curve = solid_curve();
    let frame = curve.frame::<f64>(0.4);
    let places: Vec<[f64; 3]> = [1, 3]
        .map(|segment| {
            [0.0, 0.5, 1.0].map(|f| {
                pushbelt::reference_curve::TwoPulley::point::<f64>(&frame, segment, f)
                    .xi
                    .v
            })
        })
        .to_vec();
    let start = system.energy(state.view()).total();
    let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-3);
    let (mut drift, mut bulges) = (0.0_f64, Vec::new());
    for k in 0..4 {
        let t = f64::from(k) * 5.0e-5;
        run(&mut system, &mut integrator, &mut state, t, t + 5.0e-5);
        let height = |places: &[f64; 3]| {
            let [from, middle, to] = places.map(|xi| system.particle_at(state.view(), xi).r);
            let chord = (to - from).normalize();
            (middle - from).dot(&Vector2::new(-chord.y, chord.x))
        };
        let (upper, lower) = (height(&places[0]), height(&places[1]));
        assert!((upper - lower).abs() < 2e-3, "at {t} s: {upper} and {lower} m");
        bulges.push(upper);
        drift = drift.max((system.energy(state.view()).total() / start - 1.0).abs());
    }
    println!(
        "{}, tolerance {tolerance:.0e}: bulge {} m, energy drift {drift:.2e}, {:?}",
        S::NAME,
        list(&bulges),
        integrator.newton.counts
    );
    (bulges, drift)
}

/// The strands bulge outwards, and the energy's drift falls with the tolerance.
fn deformable_ring_bulges_and_conserves_energy<S: Case>() {
    let runs = [1.0e-5, 1.0e-6, 1.0e-7].map(deformable_ring::<S>);
    let bulges = &runs[2].0;
    assert!(
        bulges[1..].windows(2).all(|b| b[1] > b[0]) && bulges[3] > 2.0e-3,
        "{bulges:?}"
    );
    assert!(runs[2].1 < 1e-4 && runs.windows(2).all(|pair| pair[1].1 < 0.4 * pair[0].1));
}

/// A ring that runs on a circle carries EAγ = m_r ṡ²(1 + γ) and keeps its shape where stations see it. Error of the shape
/// after one turn, relative to the radius, and of its drift rate; steps 0: as many as a tolerance of 1e-5 asks for.
fn running_ring<S: Case>(elements: usize, steps: usize) -> (f64, f64) {
    let ring = band(0.185e-3);
    let radius = BAND_LENGTH / TAU;
    let speed = 100.0;
    let pull = ring.mass_per_length * speed * speed;
    let gamma = pull / (ring.axial_stiffness - pull);
    let curve = band_circle();
    let mut system = S::system(ring, curve.clone(), elements);
    let at = |xi: f64| curve.at(&curve.frame::<f64>(0.0), xi);
    let mut state = system.rest_on(0.0, &|xi| [at(xi).r * (1.0 + gamma), at(xi).t * (1.0 + gamma)]);
    system
        .set_in_motion(&mut state, |xi| at(xi).t * (speed * (1.0 + gamma)))
        .expect("a ring with mass");
    let turn = BAND_LENGTH / speed;
    let mut integrator = if steps == 0 {
        Sdirk::new(&system, 1.0e-6, 1.0e-3)
    } else {
        fixed_steps(&mut system, turn / steps as f64)
    };
    run(&mut system, &mut integrator, &mut state, 0.0, turn);
    let (mut strain, mut round) = (0.0_f64, 0.0_f64);
    for k in 0..4 * elements {
        let p = system.particle_at(state.view(), BAND_LENGTH * (k as f64 + 0.3) / (4 * elements) as f64);
        strain += p.strain() / gamma / (4 * elements) as f64;
        round = round.max((p.r.norm() / radius / (1.0 + gamma) - 1.0).abs());
    }
    let drift = (state.y[system.drift()] / speed - 1.0).abs();
    println!(
        "{}, {elements} elements: γ = {gamma:.3e}, mean off by {:.2e}, shape off by {round:.2e}, ṡ off by {drift:.2e}, {:?}",
        S::NAME,
        strain - 1.0,
        integrator.newton.counts
    );
    (round, drift)
}

fn running_ring_stays_round<S: Case>() {
    if lagrangian(&S::system(solid(), band_circle(), FEW)) {
        // Every node runs around: what slows it down is the integrator's damping of a turn, of order 3.
        let errors = [400, 800, 1600].map(|steps| running_ring::<S>(40, steps));
        let observed = orders(&errors.map(|(_, drift)| drift), 2.0);
        assert!(observed.iter().all(|&order| order > 2.5), "{observed:?}");
        assert!(errors[2].0 < 2e-6, "{errors:?}");
    } else {
        // Nothing moves on this mesh.
        let errors = [10, 20, 40].map(|elements| running_ring::<S>(elements, 0).0);
        assert!(
            errors[2] < 1e-9 && errors.windows(2).all(|e| e[1] < 0.07 * e[0] || e[1] < 1e-13),
            "{errors:?}"
        );
    }
}

/// Frequency of the first bending mode of a free ring on a circle, rad/s.
fn free_ring_mode<S: Case>(ring: &Ring, elements: usize, near: f64) -> f64 {
    let system = S::system(ring.clone(), band_circle(), elements);
    let mut rest = system.rest(0.0);
    system.settle(&mut rest, 0.5 / near, 20).expect("a balance");
    mode(&system, &rest, near).0
}

/// A free thin ring: f_2 = 9.534 Hz within 0.5 % at 40 elements and converging.
fn free_ring_frequency<S: Case>() {
    let ring = band(0.185e-3);
    let exact = thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    assert!((exact - 9.534).abs() < 1e-3);
    let errors: Vec<f64> = [20, 40, 80, 160]
        .iter()
        .map(|&n| free_ring_mode::<S>(&ring, n, 1.01 * TAU * exact) / (TAU * exact) - 1.0)
        .collect();
    println!(
        "{}, 20 to 160 elements: off by {}; orders {:.2?}",
        S::NAME,
        list(&errors),
        orders(&errors.iter().map(|e| e.abs()).collect::<Vec<_>>(), 2.0)
    );
    assert!(errors[1].abs() < 5e-3 && errors[3].abs() < 1e-4);
    assert!(errors.windows(2).all(|e| e[1].abs() < e[0].abs().max(5e-5)));
}

/// Frequency of the large oscillation from the two-arc shape at rest, Hz, and the energy's largest drift.
fn large_oscillation<M: RingModel>(mut system: RingSystem<M>, tolerance: f64) -> (f64, f64) {
    system.tolerance = tolerance;
    let mut state = system.rest_on(0.0, &two_arc());
    let laid = system.energy(state.view());
    system.settle(&mut state, 1.0e-5, 20).expect("a balance");
    println!("laid on {laid:?}, settled {:?}", system.energy(state.view()));
    let start = system.energy(state.view()).total();
    let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-2);
    let (mut before, mut crossings, mut t) = (ovality(&system, &state), Vec::new(), 0.0);
    let mut drift = 0.0_f64;
    while crossings.len() < 3 && t < 0.2 {
        run(&mut system, &mut integrator, &mut state, t, t + 1.0e-3);
        let now = ovality(&system, &state);
        if before * now < 0.0 {
            crossings.push(t + 1.0e-3 * before / (before - now));
        }
        (before, t) = (now, t + 1.0e-3);
        drift = drift.max((system.energy(state.view()).total() / start - 1.0).abs());
    }
    let frequency = 1.0 / (crossings[2] - crossings[0]);
    println!(
        "{frequency:.3} Hz; first quarter {:.2} Hz; energy drift {drift:.1e}; {:?}",
        0.25 / crossings[0],
        integrator.newton.counts
    );
    (frequency, drift)
}

fn two_arc_oscillation<S: Case>() {
    let system = S::system(band(0.185e-3), band_circle(), S::ELEMENTS);
    let (dofs, nonlinear) = (system.degrees_of_freedom(), lagrangian(&system));
    assert_eq!(dofs, 160);
    let (frequency, _) = large_oscillation(system, 1.0e-4);
    println!("{}, {} elements: {frequency:.3} Hz", S::NAME, S::ELEMENTS);
    if nonlinear {
        assert!((frequency - 9.23).abs() < 0.05, "{frequency}");
    } else {
        // The linear curvature measure makes a large deflection from a circle swing too slowly: reported, not judged.
        assert!((8.0..9.3).contains(&frequency), "{frequency}");
    }
}

/// A free band of `thickness` in its first bending mode, `amplitude` in units of the radius; with its frequency, rad/s.
fn swinging_band<S: Case>(
    thickness: f64,
    amplitude: f64,
) -> (RingSystem<S::Model<pushbelt::reference_curve::Circle>>, State, f64) {
    let ring = band(thickness);
    let near = 1.01 * TAU * thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    let system = S::system(ring, band_circle(), 40);
    let mut state = system.rest(0.0);
    system.settle(&mut state, 0.5 / near, 20).expect("a balance");
    let (omega, shape) = mode(&system, &state, near);
    let mut moving = state.clone();
    moving.y.copy_from_slice(&shape);
    let largest = (0..40)
        .map(|i| system.particle(moving.view(), i, -1.0).velocity.norm())
        .fold(0.0, f64::max);
    let scale = amplitude * BAND_LENGTH / TAU * omega / largest;
    state.y.iter_mut().zip(&shape).for_each(|(y, x)| *y = scale * x);
    (system, state, omega)
}

/// Places of the nodes, m.
fn nodes<M: RingModel>(system: &RingSystem<M>, view: View<'_>) -> Vec<Vector2<f64>> {
    (0..system.model.elements())
        .map(|i| system.particle(view, i, -1.0).r)
        .collect()
}

/// The same mode in time: after whole periods it has its first velocities again.
fn free_ring_swings_at_its_frequency<S: Case>() {
    let (mut system, mut state, omega) = swinging_band::<S>(0.185e-3, 1.0e-4);
    let period = TAU / omega;
    let mut integrator = fixed_steps(&mut system, period / 400.0);
    let start = nodes(&system, state.view());
    run(&mut system, &mut integrator, &mut state, 0.0, 0.25 * period);
    let quarter = nodes(&system, state.view());
    run(&mut system, &mut integrator, &mut state, 0.25 * period, 3.0 * period);
    let after = nodes(&system, state.view());
    let largest =
        |a: &[Vector2<f64>], b: &[Vector2<f64>]| a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).norm()));
    let off = largest(&start, &after) / largest(&start, &quarter);
    println!("{}: after three periods {off:.2e} of the amplitude is off", S::NAME);
    assert!(off < 5e-3);
}

/// Frequencies of a ring whose membrane is soft enough not to decide.
fn order_in_space<S: Case>() {
    let radius = BAND_LENGTH / TAU;
    let thin = band(0.185e-3);
    let ring = Ring {
        axial_stiffness: 10.0 * thin.bending_stiffness / (radius * radius),
        ..thin
    };
    let near = 0.9 * TAU * thin_ring_frequency(&ring, radius);
    frequencies_converge::<S>(
        &ring,
        near,
        [12, 24, 48].map(|n| if S::ORDER < 3.0 { 2 * n } else { n }),
        S::ORDER,
    );
}

fn frequencies_converge<S: Case>(ring: &Ring, near: f64, ladder: [usize; 3], order: f64) {
    let exact = free_ring_mode::<S>(ring, 8 * ladder[2], near);
    let errors = ladder.map(|n| (free_ring_mode::<S>(ring, n, near) / exact - 1.0).abs());
    assert_order(&format!("{}, frequency", S::NAME), &errors, order);
}

/// With one strain an element the membrane does not lock: a thin band's frequencies have the order of bending, 4, from the
/// coarsest mesh on.
#[test]
fn co_rotational_bending_has_order_four() {
    let ring = band(0.185e-3);
    let near = 1.01 * TAU * thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    frequencies_converge::<crate::common::CoRotational>(&ring, near, [10, 20, 40], 4.0);
}

/// The integrator's order 2 on rings with a thick and a thin membrane.
fn order_in_time<S: Case>() {
    for thickness in [5.0e-3, 0.185e-3] {
        let shape = |steps: f64| {
            let (mut system, mut state, omega) = swinging_band::<S>(thickness, 1.0e-2);
            let period = TAU / omega;
            let mut integrator = fixed_steps(&mut system, period / steps);
            run(&mut system, &mut integrator, &mut state, 0.0, 1.2 * period);
            nodes(&system, state.view())
        };
        let exact = shape(3000.0);
        let off = |q: &[Vector2<f64>]| q.iter().zip(&exact).fold(0.0_f64, |a, (x, y)| a.max((x - y).norm()));
        let errors: Vec<f64> = [50.0, 100.0, 200.0].map(|steps| off(&shape(steps))).to_vec();
        assert_order(&format!("{}, band of {thickness} m", S::NAME), &errors, 2.0);
    }
}

/// Places that move with the unknowns: derivatives through x of a Lagrangian element.
fn places_may_carry_derivatives<E: LagrangianElement>() {
    let ring = LagrangianRing::<E, _>::new(solid(), solid_curve(), FEW, 5);
    let system = RingSystem::new(ring);
    let state = waving(&system, 0.25, 1.0);
    let scale = 0.5 * system.model.length() / FEW as f64;
    for element in 0..FEW {
        let motion = system.values(state.view(), element).map(|m| Motion {
            value: Dual64::from_re(m.value),
            rate: Dual64::from_re(m.rate),
            acceleration: Dual64::from_re(m.acceleration),
        });
        let p = system.model.passing(&motion, Dual64::new(0.3, 1.0));
        let plain = system.particle(state.view(), element, 0.3);
        let (re, eps) = (p.r.map(|v| v.re), p.r.map(|v| v.eps));
        assert!((re - plain.r).norm() < 1e-15 && (eps - plain.slope * scale).norm() < 1e-14);
        assert!((p.velocity.map(|v| v.eps) - plain.velocity_slope * scale).norm() < 1e-11);
    }
}

#[test]
fn places_on_lagrangian_elements_may_carry_derivatives() {
    places_may_carry_derivatives::<AncfElement>();
    places_may_carry_derivatives::<RcmElement>();
}

macro_rules! suite {
    ($($name:ident: $case:ty),*) => {$(
        mod $name {
            suite!(@tests $case: velocity_follows_the_particle, acceleration_follows_the_particle,
                primes_are_derivatives, a_station_sees_the_particle_pass, projection_is_the_transpose, elastic_force_is_the_gradient_of_the_energy,
                damping_takes_what_it_says, inertia_is_lagranges, deformable_ring_bulges_and_conserves_energy,
                running_ring_stays_round, free_ring_frequency, two_arc_oscillation, free_ring_swings_at_its_frequency,
                order_in_space, order_in_time);
        }
    )*};
    (@tests $case:ty: $($test:ident),*) => {$(
        #[test]
        fn $test() {
            super::$test::<$case>();
        }
    )*};
}
suite!(ale: crate::common::Ale, ale_turning: crate::common::AleTurning, ancf: crate::common::AbsoluteNodal,
    rcm: crate::common::CoRotational);
