//! Measurements on the ring alone: what the tests judge, and what the report on the paper shows
//! (`examples/paper_rings`).

use super::common::*;
use nalgebra::Vector2;
use pushbelt::reference_curve::{Circle, ReferenceCurve, TwoPulley};
use pushbelt::ring::Ring;
use pushbelt::ring::ale_ring::AleRing;
use pushbelt::ring::mesh::RingMesh;
use pushbelt::ring::model::{Energy, RingModel};
use pushbelt::ring::system::RingSystem;
use pushbelt::solver::newton::Counts;
use pushbelt::solver::sdirk::Sdirk;
use pushbelt::solver::{State, View};
use std::f64::consts::TAU;

/// Number of elements in the tests of derivatives: every kind of neighbourhood occurs.
pub const FEW: usize = 12;

/// A ring on the reference curve at Θ with deflections of a few per cent, in motion.
pub fn waving<M: RingModel<D, N>, const D: usize, const N: usize>(
    system: &RingSystem<M, D, N>,
    theta: f64,
    amplitude: f64,
) -> State {
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

pub fn lagrangian<M: RingModel<D, N>, const D: usize, const N: usize>(_: &RingSystem<M, D, N>) -> bool {
    M::LAGRANGIAN
}

/// Unknowns whose rows are balances of force: without s and Θ on a mesh that travels.
fn forces<M: RingModel<D, N>, const D: usize, const N: usize>(system: &RingSystem<M, D, N>) -> usize {
    if M::LAGRANGIAN {
        system.drift()
    } else {
        system.theta() + 1
    }
}

pub const PLACES: [f64; 8] = [0.01, 0.093, 0.2, 0.31, 0.505, 0.62, 0.81, 0.97];

/// P (12): the velocity at a unit rate is how fast the particle at ξ = x̄ + s moves. Largest difference of the columns,
/// m.
pub fn velocity_error<S: Case<D, N>, const D: usize, const N: usize>() -> f64 {
    let system = S::system(solid(), solid_curve(), FEW);
    let mut state = waving(&system, 0.25, 1.0);
    let (s, h) = (system.drift(), 3.0e-6);
    let mut off = 0.0_f64;
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
            off = off.max((velocity - (place(h) - place(-h)) / (2.0 * h)).norm());
        }
    }
    off
}

/// The residual at rest is ∂V/∂q, moving arc borders included: there the curvature jumps. Largest difference relative
/// to the largest force.
pub fn elastic_force_error<S: Case<D, N>, const D: usize, const N: usize>() -> f64 {
    let mut system = S::system(solid(), solid_curve(), FEW);
    system.held.clear();
    let mut state = waving(&system, 0.25, 0.3);
    state.y.fill(0.0);
    state.y_dot.fill(0.0);
    let force = residual(&mut system, state.view());
    let h = 1.0e-6;
    let mut off = 0.0_f64;
    for i in 0..forces(&system) {
        let energy = |h: f64| {
            let mut moved = state.clone();
            moved.q[i] += h;
            let energy = system.energy(moved.view());
            energy.membrane + energy.bending
        };
        off = off.max((force[i] - (energy(h) - energy(-h)) / (2.0 * h)).abs());
    }
    off / force.amax()
}

/// Inertia is M q̈ + Ṁq̇ − ∂T/∂q of the discrete ring. Largest difference relative to the largest force.
pub fn inertia_error<S: Case<D, N>, const D: usize, const N: usize>() -> f64 {
    let mut system = S::system(solid(), solid_curve(), FEW);
    *system.model.ring_mut() = without_stiffness(system.model.ring());
    system.held.clear();
    let state = waving(&system, 0.25, 1.0);
    let rows = forces(&system);
    let direct = residual(&mut system, state.view());
    let expected = inertia_by_differences(&system, &state);
    (direct - &expected).rows(0, rows).amax() / expected.rows(0, rows).amax()
}

/// The solid ring that keeps to its reference curve.
pub fn rigid<C: ReferenceCurve + std::fmt::Debug>(curve: C, mesh: RingMesh) -> RingSystem<AleRing<C>> {
    RingSystem::new(AleRing::rigid(solid(), curve, mesh))
}

/// What the reference motion of the solid ring has to meet: bending energy, J, and M_ΘΘ, kg·m², at Θ.
pub const REFERENCE_NUMBERS: [(f64, f64, f64); 2] = [(0.0, 1_151_453.8, 3.10883), (0.4, 1_298_705.6, 2.04239)];

/// The frequency of its small oscillation, rad/s.
pub const REFERENCE_FREQUENCY: f64 = 718.05;

/// Energy, M_ΘΘ and M_sΘ of the reference motion at Θ.
pub fn reference_numbers(theta: f64) -> (Energy, f64, f64) {
    let system = rigid(solid_curve(), RingMesh::even(&[4, 4, 8, 4, 4], 5));
    let state = system.rest(theta);
    let mass = system.mass_matrix(&state.q);
    let (s, theta) = (system.drift(), system.theta());
    (system.energy(state.view()), mass[(theta, theta)], mass[(s, theta)])
}

/// Frequency of the reference motion's small oscillation, rad/s.
pub fn reference_frequency() -> f64 {
    let system = rigid(solid_curve(), RingMesh::even(&[4, 4, 8, 4, 4], 5));
    mode(&system, &system.rest(0.0), 700.0).0
}

/// A ring at a moment.
pub struct Sample {
    pub time: f64,
    pub theta: f64,
    /// s, m.
    pub drift: f64,
    pub energy: Energy,
    pub state: State,
}

/// A run, sampled at even times from its start on.
pub struct Record {
    pub samples: Vec<Sample>,
    pub counts: Counts,
}

impl Record {
    /// Largest change of the energy, J.
    pub fn energy_drift(&self) -> f64 {
        let start = self.samples[0].energy.total();
        let off = |sample: &Sample| (sample.energy.total() - start).abs();
        self.samples.iter().map(off).fold(0.0, f64::max)
    }

    /// Smallest and largest Θ.
    pub fn ratios(&self) -> (f64, f64) {
        self.samples
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), sample| {
                (low.min(sample.theta), high.max(sample.theta))
            })
    }

    /// Largest |s|, m.
    pub fn largest_drift(&self) -> f64 {
        self.samples.iter().map(|sample| sample.drift.abs()).fold(0.0, f64::max)
    }
}

/// Runs from `state` for `count` times `step`, s. Ends early where the integrator can't go on or Θ leaves ±`limit`.
pub fn record<M: RingModel>(
    system: &mut RingSystem<M>,
    mut state: State,
    first_step: f64,
    step: f64,
    count: usize,
    limit: f64,
) -> Record {
    let sample = |system: &RingSystem<M>, state: &State, time: f64| Sample {
        time,
        theta: state.q[system.theta()],
        drift: state.q[system.drift()],
        energy: system.energy(state.view()),
        state: state.clone(),
    };
    let mut integrator = Sdirk::new(system, first_step, 1.0e-3);
    let mut samples = vec![sample(system, &state, 0.0)];
    for k in 0..count {
        let (from, to) = (k as f64 * step, (k + 1) as f64 * step);
        if integrator.advance(system, &mut state, from, to).is_err() || state.q[system.theta()].abs() > limit {
            break;
        }
        samples.push(sample(system, &state, to));
    }
    Record {
        samples,
        counts: integrator.newton.counts,
    }
}

/// The reference oscillation (paper fig. 6) from Θ = 0.4 at rest, over 20 ms. With the energy of the swing, J.
pub fn reference_oscillation<C: ReferenceCurve + std::fmt::Debug>(
    curve: C,
    mesh: RingMesh,
    tolerance: f64,
) -> (RingSystem<AleRing<C>>, Record, f64) {
    let mut system = rigid(curve, mesh);
    system.tolerance = tolerance;
    let start = system.rest(0.4);
    let energy = |state: &State| system.energy(state.view()).total();
    let swing = energy(&start) - energy(&system.rest(0.0));
    let record = record(&mut system, start, 1.0e-5, 2.0e-4, 100, 1.0);
    (system, record, swing)
}

/// Error of Θ after 5 ms of the reference oscillation with fixed steps.
pub fn reference_time_errors(steps: [f64; 3]) -> [f64; 3] {
    let theta = |step: f64| {
        let mut system = rigid(solid_curve(), RingMesh::even(&[1, 1, 2, 1, 1], 5));
        let mut integrator = fixed_steps(&mut system, step);
        let mut state = system.rest(0.4);
        run(&mut system, &mut integrator, &mut state, 0.0, 5.0e-3);
        state.q[system.theta()]
    };
    let exact = theta(1.0e-6);
    steps.map(|step| (theta(step) - exact).abs())
}

/// Heights of the middles of the upper and the lower strand above their chords, outwards, m. The strands are those of
/// the solid ring's reference curve at Θ = 0.4.
pub fn bulges<M: RingModel>(system: &RingSystem<M>, state: &State) -> [f64; 2] {
    let frame = solid_curve().frame::<f64>(0.4);
    [1, 3].map(|segment| {
        let [from, middle, to] = [0.0, 0.5, 1.0].map(|fraction| {
            let xi = TwoPulley::point::<f64>(&frame, segment, fraction).xi.v;
            system.particle_at(state.view(), xi).r
        });
        let chord = (to - from).normalize();
        (middle - from).dot(&Vector2::new(-chord.y, chord.x))
    })
}

/// Paper fig. 7: a deformable ring from Θ = 0.4 at rest, `count` times 50 µs. The model gets about `elements` elements.
pub fn deformable_ring<S: Case>(
    elements: usize,
    tolerance: f64,
    count: usize,
) -> (RingSystem<S::Model<TwoPulley>>, Record) {
    let mut system = S::system(solid(), solid_curve(), elements);
    system.tolerance = tolerance;
    let start = system.rest(0.4);
    let record = record(&mut system, start, 1.0e-6, 5.0e-5, count, 0.95);
    (system, record)
}

/// How a running ring keeps its shape.
pub struct Running {
    /// Mean strain relative to m_r ṡ²/(EA − m_r ṡ²), less 1.
    pub strain: f64,
    /// Largest error of the radius after one turn, relative.
    pub shape: f64,
    /// Error of the drift rate, relative.
    pub drift: f64,
    pub counts: Counts,
}

/// A ring that runs on a circle carries EAγ = m_r ṡ²(1 + γ) and keeps its shape where stations see it. One turn; steps
/// 0: as many as a tolerance of 1e-5 asks for.
pub fn running_ring<S: Case>(elements: usize, steps: usize) -> Running {
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
    Running {
        strain: strain - 1.0,
        shape: round,
        drift: (state.y[system.drift()] / speed - 1.0).abs(),
        counts: integrator.newton.counts,
    }
}

/// Frequency of the first bending mode of a free ring on a circle, rad/s.
pub fn free_ring_mode<S: Case>(ring: &Ring, elements: usize, near: f64) -> f64 {
    let system = S::system(ring.clone(), band_circle(), elements);
    let mut rest = system.rest(0.0);
    system.settle(&mut rest, 0.5 / near, 20).expect("a balance");
    mode(&system, &rest, near).0
}

/// Relative error of the thin band's first bending frequency, less 1.
pub fn thin_band_error<S: Case>(elements: usize) -> f64 {
    let ring = band(0.185e-3);
    let exact = TAU * thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    free_ring_mode::<S>(&ring, elements, 1.01 * exact) / exact - 1.0
}

/// Frequencies' errors on a ladder of meshes, against one eight times finer than its last rung.
pub fn frequency_errors<S: Case>(ring: &Ring, near: f64, ladder: [usize; 3]) -> [f64; 3] {
    let exact = free_ring_mode::<S>(ring, 8 * ladder[2], near);
    ladder.map(|n| (free_ring_mode::<S>(ring, n, near) / exact - 1.0).abs())
}

/// A ring whose membrane is soft enough not to decide, and about what its first frequency is, rad/s.
pub fn soft_membrane() -> (Ring, f64) {
    let radius = BAND_LENGTH / TAU;
    let thin = band(0.185e-3);
    let near = 0.9 * TAU * thin_ring_frequency(&thin, radius);
    let ring = Ring {
        axial_stiffness: 10.0 * thin.bending_stiffness / (radius * radius),
        ..thin
    };
    (ring, near)
}

/// Meshes on which the order of a model in space shows.
pub fn space_ladder<S: Case>() -> [usize; 3] {
    [12, 24, 48].map(|n| if S::ORDER < 3.0 { 2 * n } else { n })
}

/// A large oscillation.
pub struct Swing {
    /// Hz.
    pub frequency: f64,
    /// From the first quarter period, Hz.
    pub first_quarter: f64,
    /// Largest change of the energy, relative.
    pub drift: f64,
    pub counts: Counts,
}

/// The band from the two-arc shape at rest (paper 5.3; about 9.23 Hz by an independent nonlinear code).
pub fn two_arc_swing<S: Case>(tolerance: f64) -> Swing {
    let mut system = S::system(band(0.185e-3), band_circle(), S::ELEMENTS);
    system.tolerance = tolerance;
    let mut state = system.rest_on(0.0, &two_arc());
    system.settle(&mut state, 1.0e-5, 20).expect("a balance");
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
    Swing {
        frequency: 1.0 / (crossings[2] - crossings[0]),
        first_quarter: 0.25 / crossings[0],
        drift,
        counts: integrator.newton.counts,
    }
}

/// A free band of `thickness` in its first bending mode, `amplitude` in units of the radius; with its frequency, rad/s.
pub fn swinging_band<S: Case>(thickness: f64, amplitude: f64) -> (RingSystem<S::Model<Circle>>, State, f64) {
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
pub fn nodes<M: RingModel>(system: &RingSystem<M>, view: View<'_>) -> Vec<Vector2<f64>> {
    (0..system.model.elements())
        .map(|i| system.particle(view, i, -1.0).r)
        .collect()
}

/// Errors of the nodes' places after 1.2 periods of a swinging band, with so many fixed steps a period, m.
pub fn time_errors<S: Case>(thickness: f64, ladder: [f64; 3]) -> [f64; 3] {
    let shape = |steps: f64| {
        let (mut system, mut state, omega) = swinging_band::<S>(thickness, 1.0e-2);
        let period = TAU / omega;
        let mut integrator = fixed_steps(&mut system, period / steps);
        run(&mut system, &mut integrator, &mut state, 0.0, 1.2 * period);
        nodes(&system, state.view())
    };
    let exact = shape(3000.0);
    let off = |q: &[Vector2<f64>]| q.iter().zip(&exact).fold(0.0_f64, |a, (x, y)| a.max((x - y).norm()));
    ladder.map(|steps| off(&shape(steps)))
}
