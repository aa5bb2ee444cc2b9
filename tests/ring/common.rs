//! Rings, models and tools that the tests of the ring share.

use nalgebra::{DMatrix, DVector, Vector2};
use pushbelt::reference_curve::{Circle, ReferenceCurve, TwoPulley};
use pushbelt::ring::Ring;
use pushbelt::ring::ale_ring::{AleRing, Directions};
use pushbelt::ring::ancf::Ancf;
use pushbelt::ring::mesh::RingMesh;
use pushbelt::ring::model::RingModel;
use pushbelt::ring::rcm::Rcm;
use pushbelt::ring::system::RingSystem;
use pushbelt::solver::arrow::{Arrow, ArrowLu};
use pushbelt::solver::sdirk::Sdirk;
use pushbelt::solver::{State, System, View};
use std::f64::consts::TAU;
use std::fmt::Debug;

/// The ring of the reference numbers for the paper's fig. 6 and 7: L = 1 m, d_A = 0.2 m. EA belongs to the same steel
/// section (E = 2.1e11 N/m², ρ = 7800 kg/m³).
pub fn solid() -> Ring {
    Ring {
        mass_per_length: 154.0,
        axial_stiffness: 154.0 / 7800.0 * 2.1e11,
        bending_stiffness: 35_000.0,
        lateral_bending_stiffness: 35_000.0,
        damping: 0.0,
    }
}

pub fn solid_curve() -> TwoPulley {
    TwoPulley::new(0.2, 1.0)
}

/// A steel band of `thickness`, 9.5 mm wide.
pub fn band(thickness: f64) -> Ring {
    let (e, rho, width) = (2.1e11, 7800.0, 9.5e-3_f64);
    Ring {
        mass_per_length: rho * thickness * width,
        axial_stiffness: e * thickness * width,
        bending_stiffness: e * width * thickness.powi(3) / 12.0,
        lateral_bending_stiffness: e * thickness * width.powi(3) / 12.0,
        damping: 0.0,
    }
}

/// Circumference of the free band, m.
pub const BAND_LENGTH: f64 = 0.70;

pub fn band_circle() -> Circle {
    Circle {
        radius: BAND_LENGTH / TAU,
    }
}

/// First bending frequency of a free thin ring, Hz.
pub fn thin_ring_frequency(ring: &Ring, radius: f64) -> f64 {
    (36.0_f64 / 5.0).sqrt() * (ring.bending_stiffness / (ring.mass_per_length * radius.powi(4))).sqrt() / TAU
}

/// The same ring without stiffness: its residual is inertia alone.
pub fn without_stiffness(ring: &Ring) -> Ring {
    Ring {
        axial_stiffness: 0.0,
        bending_stiffness: 0.0,
        lateral_bending_stiffness: 0.0,
        ..ring.clone()
    }
}

#[path = "../../src/noise.rs"]
mod numbers;
pub use numbers::noise;

/// A ring model under test.
pub trait Case<const D: usize = 2, const N: usize = 10> {
    /// The model on a curve.
    type Model<C: ReferenceCurve + Debug>: RingModel<D, N>;
    const NAME: &'static str;
    /// Order of frequencies in the element length when stretch and bending both matter.
    const ORDER: f64;
    /// Elements of 160 degrees of freedom, as in the paper.
    const ELEMENTS: usize = 40;
    /// With about `elements` elements, with exactly so many on a circle.
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> Self::Model<C>;
    fn system<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> RingSystem<Self::Model<C>, D, N> {
        RingSystem::new(Self::model(ring, curve, elements))
    }
}

/// A mesh of about `elements` elements with borders on the arcs.
pub fn aligned(segments: usize, elements: usize, points: usize) -> RingMesh {
    match segments {
        1 => RingMesh::even(&[elements], points),
        5 => RingMesh::even(&[1, 1, 2, 1, 1].map(|n| n * (elements / 6).max(1)), points),
        n => RingMesh::even(&vec![(elements / n).max(1); n], points),
    }
}

pub struct Ale;
pub struct AleTurning;
pub struct AleSpatial;
pub struct AleSpatialTurning;
pub struct AbsoluteNodal;
pub struct CoRotational;

impl Case for Ale {
    type Model<C: ReferenceCurve + Debug> = AleRing<C>;
    const NAME: &'static str = "ALE";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C> {
        let mesh = aligned(curve.segments(), elements, 3);
        AleRing::flexible(ring, curve, mesh)
    }
}

impl Case for AleTurning {
    type Model<C: ReferenceCurve + Debug> = AleRing<C>;
    const NAME: &'static str = "ALE, overlay along t and n";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C> {
        let mut model = Ale::model(ring, curve, elements);
        model.directions = Directions::Reference;
        model
    }
}

impl Case<3, 14> for AleSpatial {
    type Model<C: ReferenceCurve + Debug> = AleRing<C, 3>;
    const NAME: &'static str = "ALE in space";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C, 3> {
        let mesh = aligned(curve.segments(), elements, 3);
        AleRing::spatial(ring, curve, mesh)
    }
}

impl Case<3, 14> for AleSpatialTurning {
    type Model<C: ReferenceCurve + Debug> = AleRing<C, 3>;
    const NAME: &'static str = "ALE in space, overlay along t, n and b";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C, 3> {
        let mut model = AleSpatial::model(ring, curve, elements);
        model.directions = Directions::Reference;
        model
    }
}

impl Case for AbsoluteNodal {
    type Model<C: ReferenceCurve + Debug> = Ancf<C>;
    const NAME: &'static str = "ANCF";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> Ancf<C> {
        Ancf::new(ring, curve, elements, 3)
    }
}

impl Case for CoRotational {
    type Model<C: ReferenceCurve + Debug> = Rcm<C>;
    const NAME: &'static str = "RCM";
    const ELEMENTS: usize = 32;
    // One strain an element. Bending alone has order 4.
    const ORDER: f64 = 2.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> Rcm<C> {
        Rcm::new(ring, curve, elements, 5)
    }
}

pub fn residual<M: RingModel<D, N>, const D: usize, const N: usize>(
    system: &mut RingSystem<M, D, N>,
    view: View<'_>,
) -> DVector<f64> {
    let mut out = vec![0.0; view.y.len()];
    system.residual(0.0, view, &mut out);
    DVector::from_vec(out)
}

/// (13) and (14) from differences of the mass matrix: M q̈ + Ṁ q̇ − ∂T/∂q.
pub fn inertia_by_differences<M: RingModel<D, N>, const D: usize, const N: usize>(
    system: &RingSystem<M, D, N>,
    state: &State,
) -> DVector<f64> {
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

/// Integrator with fixed steps. Errors that Newton's method leaves in the velocities add up over the steps of a
/// ladder's last rung, so it is held tighter than its default.
pub fn fixed_steps<M: RingModel<D, N>, const D: usize, const N: usize>(
    system: &mut RingSystem<M, D, N>,
    step: f64,
) -> Sdirk {
    system.tolerance = f64::INFINITY;
    let mut integrator = Sdirk::new(system, step, step);
    integrator.newton_tolerance = 0.05;
    integrator
}

pub fn run<M: RingModel<D, N>, const D: usize, const N: usize>(
    system: &mut RingSystem<M, D, N>,
    integrator: &mut Sdirk,
    state: &mut State,
    from: f64,
    to: f64,
) {
    integrator
        .advance(system, state, from, to)
        .expect("the free ring can be integrated");
}

/// Angular frequency and shape of the small oscillation about the rest state `state` nearest to `near`, rad/s.
pub fn mode<M: RingModel<D, N>, const D: usize, const N: usize>(
    system: &RingSystem<M, D, N>,
    state: &State,
    near: f64,
) -> (f64, Vec<f64>) {
    let mut system = system.clone();
    if M::LAGRANGIAN {
        // s follows, it takes no part.
        let s = system.drift();
        system.held.push(s);
    }
    let n = state.y.len();
    let matrix = |system: &mut RingSystem<M, D, N>, alpha: f64, beta: f64| {
        let mut a = Arrow::new(system.shape());
        system.jacobian(0.0, state.view(), alpha, beta, &mut a);
        a
    };
    let (mass, stiffness) = (matrix(&mut system, 1.0, 0.0), matrix(&mut system, 0.0, 1.0));
    let mut factors = ArrowLu::new(system.shape());
    let mut omega2 = near * near;
    factors.factor(&matrix(&mut system, -omega2, 1.0)).unwrap();
    let mut random = noise(5);
    let mut v: Vec<f64> = (0..n).map(|_| random()).collect();
    let mut product = vec![0.0; n];
    let held = system.held.clone();
    let clear = |v: &mut [f64]| held.iter().for_each(|&i| v[i] = 0.0);
    for _ in 0..60 {
        clear(&mut v);
        mass.multiply(&v, &mut product);
        clear(&mut product);
        let norm = v.iter().zip(&product).map(|(a, b)| a * b).sum::<f64>().sqrt();
        v.iter_mut().for_each(|x| *x /= norm);
        stiffness.multiply(&v, &mut product);
        clear(&mut product);
        omega2 = v.iter().zip(&product).map(|(a, b)| a * b).sum();
        mass.multiply(&v, &mut product);
        clear(&mut product);
        factors.solve(&mut product);
        std::mem::swap(&mut v, &mut product);
    }
    (omega2.sqrt(), v)
}

/// Mean square extent along x less that along y, m²: zero when round.
pub fn ovality<M: RingModel>(system: &RingSystem<M>, state: &State) -> f64 {
    let length = system.model.length();
    let mean = |f: &dyn Fn(Vector2<f64>) -> f64| system.integrate(state.view(), |p| f(p.r)) / length;
    let (x, y) = (mean(&|r| r.x), mean(&|r| r.y));
    mean(&|r| (r.x - x).powi(2) - (r.y - y).powi(2))
}

/// The two-arc shape of a belt of the band's length at Θ = 0.4 and d_A = 0.155 m: (r, r') at ξ.
pub fn two_arc() -> impl Fn(f64) -> [Vector2<f64>; 2] {
    let curve = TwoPulley::new(0.155, BAND_LENGTH);
    let frame = curve.frame::<f64>(0.4);
    // Leftmost point where the circle has its own.
    let shift = curve.at(&frame, 0.0).r + Vector2::new(BAND_LENGTH / TAU, 0.0);
    move |xi| {
        let point = curve.at(&frame, xi);
        [point.r - shift, point.t]
    }
}

/// Numbers in a line.
pub fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!(" {x:.2e}")).collect()
}

/// Orders between the errors of a ladder whose rungs differ by `ratio`.
pub fn orders(errors: &[f64], ratio: f64) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).ln() / ratio.ln()).collect()
}

/// Asserts `≈ order ± 0.2` on a ladder of halved steps or element lengths.
pub fn assert_order(name: &str, errors: &[f64], expected: f64) {
    let observed = orders(errors, 2.0);
    println!("{name}: errors {}, orders {observed:.2?}", list(errors));
    assert!(
        observed.iter().all(|order| (order - expected).abs() < 0.2),
        "{name}: {observed:?}"
    );
}
