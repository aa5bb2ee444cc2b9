//! Rings that deflect: running, oscillating, from the two-arc shape (paper fig. 7 and 5.3).

use std::f64::consts::TAU;

use crate::circle::Circle;
use crate::system::RingSystem;
use nalgebra::Vector2;
use pushbelt::ring::Ring;
use pushbelt::solver::State;
use pushbelt::solver::newton::Counts;
use pushbelt::solver::sdirk::Sdirk;
use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley};
use pushbelt_paper::ring::model::RingFormulation;

use super::cases::Case;
use super::motion::{Mode, fixed_steps, mode, nodes, ovality, run};
use super::record::{Record, record};
use super::specimens::{BAND_LENGTH, Specimen, band, band_circle, thin_ring_frequency, two_arc};

/// Heights of the middles of the upper and the lower strand above their chords, outwards, m. The
/// strands are those of the reference curve at Θ = 0.4.
pub fn bulges<M: RingFormulation>(curve: &TwoPulley, system: &RingSystem<M>, state: &State) -> [f64; 2] {
    let frame = curve.frame::<f64>(0.4);
    [1, 3].map(|segment| {
        let [from, middle, to] = [0.0, 0.5, 1.0].map(|fraction| {
            let xi = TwoPulley::point::<f64>(&frame, segment, fraction).xi.v;
            system.particle_at(state.view(), xi).r
        });
        let chord = (to - from).normalize();
        (middle - from).dot(&Vector2::new(-chord.y, chord.x))
    })
}

/// Paper fig. 7: the thick ring of about `elements` elements from Θ = 0.4 at rest, `count` times 50
/// µs.
pub fn deformable_ring<S: Case>(
    elements: usize,
    tolerance: f64,
    count: usize,
) -> (RingSystem<S::Model<TwoPulley>>, Record) {
    released_ring::<S>(&Specimen::thick(), elements, tolerance, 5.0e-5, count)
}

/// The same with any ring, `count` times `step`, s.
pub fn released_ring<S: Case>(
    specimen: &Specimen,
    elements: usize,
    tolerance: f64,
    step: f64,
    count: usize,
) -> (RingSystem<S::Model<TwoPulley>>, Record) {
    let mut system = S::system(specimen.ring.clone(), specimen.curve.clone(), elements);
    system.tolerance = tolerance;
    let start = system.rest(0.4);
    let record = record(&mut system, start, 0.02 * step, step, count, 0.95);
    (system, record)
}

/// Errors of strain, shape and drift of a running ring.
pub struct RunningRing {
    /// Mean strain relative to m_r ṡ²/(EA − m_r ṡ²), less 1.
    pub strain: f64,
    /// Largest error of the radius after one turn, relative.
    pub shape: f64,
    /// Error of the drift rate, relative.
    pub drift: f64,
    pub counts: Counts,
}

/// A ring that runs on a circle has EAγ = m_r ṡ²(1 + γ) and a constant shape in space. One turn in
/// `steps` fixed steps; with 0, steps are adapted to a tolerance of 1e-5.
pub fn running_ring<S: Case>(elements: usize, steps: usize) -> RunningRing {
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
    RunningRing {
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
    mode(&system, &rest, near).omega
}

/// Relative error of the thin band's first bending frequency, less 1.
pub fn thin_band_error<S: Case>(elements: usize) -> f64 {
    let ring = band(0.185e-3);
    let exact = TAU * thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    free_ring_mode::<S>(&ring, elements, 1.01 * exact) / exact - 1.0
}

/// Errors of the frequency on three meshes, compared with a mesh eight times finer than the last.
pub fn frequency_errors<S: Case>(ring: &Ring, near: f64, ladder: [usize; 3]) -> [f64; 3] {
    let exact = free_ring_mode::<S>(ring, 8 * ladder[2], near);
    ladder.map(|n| (free_ring_mode::<S>(ring, n, near) / exact - 1.0).abs())
}

/// Numbers of elements in the asymptotic range of a model's order in space.
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

/// The band from the two-arc shape at rest (paper 5.3; cables of Exudyn have 9.22 Hz with 80
/// elements, `examples/peers/exudyn_ring.py`).
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

/// A free band in its first bending mode.
pub struct SwingingBand<S: Case> {
    pub system: RingSystem<S::Model<Circle>>,
    pub state: State,
    /// Angular frequency, rad/s.
    pub omega: f64,
}

/// A free band of `thickness` in its first bending mode, `amplitude` in units of the radius.
pub fn swinging_band<S: Case>(thickness: f64, amplitude: f64) -> SwingingBand<S> {
    let ring = band(thickness);
    let near = 1.01 * TAU * thin_ring_frequency(&ring, BAND_LENGTH / TAU);
    let system = S::system(ring, band_circle(), 40);
    let mut state = system.rest(0.0);
    system.settle(&mut state, 0.5 / near, 20).expect("a balance");
    let Mode { omega, shape } = mode(&system, &state, near);
    let mut moving = state.clone();
    moving.y.copy_from_slice(&shape);
    let largest = (0..40)
        .map(|i| system.particle(moving.view(), i, -1.0).velocity.norm())
        .fold(0.0, f64::max);
    let scale = amplitude * BAND_LENGTH / TAU * omega / largest;
    state.y.iter_mut().zip(&shape).for_each(|(y, x)| *y = scale * x);
    SwingingBand { system, state, omega }
}

/// Errors of the nodes' places after 1.2 periods of an oscillating band, with these numbers of
/// fixed steps per period, m.
pub fn time_errors<S: Case>(thickness: f64, ladder: [f64; 3]) -> [f64; 3] {
    let shape = |steps: f64| {
        let SwingingBand {
            mut system,
            mut state,
            omega,
        } = swinging_band::<S>(thickness, 1.0e-2);
        let period = TAU / omega;
        let mut integrator = fixed_steps(&mut system, period / steps);
        run(&mut system, &mut integrator, &mut state, 0.0, 1.2 * period);
        nodes(&system, state.view())
    };
    let exact = shape(3000.0);
    let off = |q: &[Vector2<f64>]| q.iter().zip(&exact).fold(0.0_f64, |a, (x, y)| a.max((x - y).norm()));
    ladder.map(|steps| off(&shape(steps)))
}
