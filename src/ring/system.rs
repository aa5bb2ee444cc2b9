//! The ring alone, free in the plane, as an implicit system: no chain, contact or pulleys (paper 5.3).
//!
//! ∫ m_r Pᵀ Dv/Dt dξ + ∂V/∂q + damping = 0 with q = (s, Θ, q_f) (25), from the kinematics and the law that the variator
//! uses too. Unknowns are the rates: block k holds ȧ_x, ḃ_x, ȧ_y, ḃ_y of node k, the border holds ṡ and Θ̇.
//!
//! s and Θ repeat motions that q_f can make, so node 0 is locked to the reference curve: along the curve because of s,
//! across it because of Θ. A curve without a ratio needs the first lock only; a second would hold the free ring.
//! `ALE0` locks every node: the ring then has s and Θ alone.

use super::kinematics::{ElementLoad, ElementMotion, Load, Motion, Node, ReferenceMotion, RingPoint};
use super::mesh::{RingMesh, Station};
use super::{Ring, ale};
use crate::reference_curve::{Jet, ReferenceCurve};
use crate::scalar::Real;
use crate::solver::arrow::{Arrow, Shape};
use crate::solver::sdirk::Evolution;
use crate::solver::{System, View};
use nalgebra::{DMatrix, SVector, Vector2};
use num_dual::{Derivative, DualSVec64};
use std::f64::consts::TAU;

/// Derivative directions of an element: four of each node, then s and Θ.
const DIRECTIONS: usize = 10;
/// Node unknowns.
const BLOCK: usize = 4;
/// Change of the shape that does not matter to Newton's method, in units of the length L. Thin rings leave no smaller
/// one: rounding in the tension bends them by 1e-16·EA L²/EI.
const NEWTON_ACCURACY: f64 = 1.0e-9;

/// Rates, accelerations and positions in the order of the unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// q̇.
    pub y: Vec<f64>,
    /// q̈.
    pub y_dot: Vec<f64>,
    /// q.
    pub q: Vec<f64>,
}

impl State {
    /// View for a residual.
    #[must_use]
    pub fn view(&self) -> View<'_> {
        View {
            y: &self.y,
            y_dot: &self.y_dot,
            q: &self.q,
        }
    }
}

/// Form of the inertia.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inertia {
    /// [`ale::add_conservative_inertia`].
    Conservative,
    /// [`ale::add_inertia`].
    Pointwise,
}

/// Energies of a ring, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// T (6).
    pub kinetic: f64,
    /// Membrane part of V (17).
    pub membrane: f64,
    /// Bending part of V (17).
    pub bending: f64,
}

impl Energy {
    /// T + V, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.membrane + self.bending
    }
}

/// A free ring.
#[derive(Clone, Debug)]
pub struct RingSystem<C> {
    /// Beam.
    pub ring: Ring,
    /// Reference curve.
    pub curve: C,
    /// Elements.
    pub mesh: RingMesh,
    /// Form of the inertia; conservative unless changed.
    pub inertia: Inertia,
    /// Position error of a step that is tolerated, in units of L (deflection, drift) and 1 (slope, Θ). Infinite:
    /// every step is accepted, so the longest step of the integrator is the step.
    pub tolerance: f64,
    /// Unknowns held at zero.
    pub locked: Vec<usize>,
    /// Energy that damping took since the start, J.
    pub dissipated: f64,
    flexible: bool,
    has_position: Vec<bool>,
}

impl<C: ReferenceCurve> RingSystem<C> {
    /// A ring that deflects (`ALE`).
    ///
    /// # Panics
    /// With fewer than three elements.
    #[must_use]
    pub fn flexible(ring: Ring, curve: C, mesh: RingMesh) -> Self {
        Self::new(ring, curve, mesh, true)
    }

    /// A ring that keeps to the reference curve, `q_f` = 0 (`ALE0`).
    ///
    /// # Panics
    /// With fewer than three elements.
    #[must_use]
    pub fn rigid(ring: Ring, curve: C, mesh: RingMesh) -> Self {
        Self::new(ring, curve, mesh, false)
    }

    fn new(ring: Ring, curve: C, mesh: RingMesh, flexible: bool) -> Self {
        assert!(mesh.elements.len() >= 3, "a ring needs three elements");
        let mut system = Self {
            ring,
            curve,
            mesh,
            inertia: Inertia::Conservative,
            tolerance: 1.0e-5,
            locked: Vec::new(),
            dissipated: 0.0,
            flexible,
            has_position: Vec::new(),
        };
        let unknowns = system.shape().len();
        system.has_position = vec![true; unknowns];
        let ratio = system.curve.has_ratio();
        // At ξ = 0, the leftmost point, y is along the curve and x across it.
        system.locked = match (flexible, ratio) {
            (false, _) => (0..system.drift()).collect(),
            (true, true) => vec![system.node(0, 0), system.node(0, 2)],
            (true, false) => vec![system.node(0, 2)],
        };
        if !ratio {
            let theta = system.theta();
            system.locked.push(theta);
        }
        system
    }

    /// Index of component `k` (a_x, b_x, a_y, b_y) of a node; nodes count around the loop.
    #[must_use]
    pub fn node(&self, node: usize, k: usize) -> usize {
        node % self.mesh.elements.len() * BLOCK + k
    }

    /// Index of the drift s.
    #[must_use]
    pub fn drift(&self) -> usize {
        self.mesh.elements.len() * BLOCK
    }

    /// Index of Θ.
    #[must_use]
    pub fn theta(&self) -> usize {
        self.drift() + 1
    }

    /// At rest on the reference curve.
    #[must_use]
    pub fn rest(&self, theta: f64) -> State {
        let zeros = vec![0.0; self.shape().len()];
        let mut q = zeros.clone();
        q[self.theta()] = theta;
        State {
            y: zeros.clone(),
            y_dot: zeros,
            q,
        }
    }

    /// Whether an unknown is the rate of a length.
    fn is_length(&self, i: usize) -> bool {
        i == self.drift() || (i < self.drift() && i.is_multiple_of(2))
    }

    fn directions(&self, element: usize) -> [usize; DIRECTIONS] {
        std::array::from_fn(|k| match k {
            0..8 => self.node(element + k / BLOCK, k % BLOCK),
            8 => self.drift(),
            _ => self.theta(),
        })
    }

    /// Motion of an element and of the reference; `seed` makes a scalar of a value, its direction and its slope.
    fn motion<T: Real<Constant = f64>>(
        &self,
        view: View<'_>,
        element: usize,
        frame: &C::Frame<T>,
        [alpha, beta]: [f64; 2],
        seed: impl Fn(f64, usize, f64) -> T,
    ) -> (ElementMotion<T>, ReferenceMotion<T>) {
        let at = self.directions(element);
        let value = |k: usize| seed(view.q[at[k]], k, beta);
        let rate = |k: usize| seed(view.y[at[k]], k, 1.0);
        let acceleration = |k: usize| seed(view.y_dot[at[k]], k, alpha);
        let motion = ReferenceMotion {
            theta: Motion {
                value: value(9),
                rate: rate(9),
                acceleration: acceleration(9),
            },
            s_dot: rate(8),
            s_ddot: acceleration(8),
        };
        let place = &self.mesh.elements[element];
        let length = Jet::constant(0.0).plus_scaled(C::segment_length(frame, place.segment), place.share);
        if !self.flexible {
            return (ElementMotion::rigid(length), motion);
        }
        let node = |i: usize, of: &dyn Fn(usize) -> T| Node {
            a: Vector2::new(of(BLOCK * i), of(BLOCK * i + 2)),
            b: Vector2::new(of(BLOCK * i + 1), of(BLOCK * i + 3)),
        };
        let nodes = [0, 1].map(|i| Motion {
            value: node(i, &value),
            rate: node(i, &rate),
            acceleration: node(i, &acceleration),
        });
        (ElementMotion::flexible(length, &motion.theta, &nodes), motion)
    }

    fn frame(&self, view: View<'_>) -> C::Frame<f64> {
        self.curve.frame(view.q[self.theta()])
    }

    fn station_point(
        &self,
        view: View<'_>,
        frame: &C::Frame<f64>,
        element: usize,
        station: &Station,
    ) -> (RingPoint<f64>, f64) {
        let (overlay, motion) = self.motion(view, element, frame, [0.0; 2], |value, _, _| value);
        let reference = C::point(frame, self.mesh.elements[element].segment, station.fraction);
        let point = RingPoint::new(reference, &station.shape, &overlay, &motion);
        (point, overlay.length.v * station.weight)
    }

    /// The ring at the local coordinate x ∈ [−1, 1] of an element.
    #[must_use]
    pub fn point(&self, view: View<'_>, element: usize, x: f64) -> RingPoint<f64> {
        let station = self.mesh.elements[element].station(x, 0.0, 0.0);
        self.station_point(view, &self.frame(view), element, &station).0
    }

    /// ∫ `f` dξ over the ring.
    pub fn integrate(&self, view: View<'_>, mut f: impl FnMut(&RingPoint<f64>) -> f64) -> f64 {
        let frame = self.frame(view);
        let mut sum = 0.0;
        for (element, stations) in self.mesh.stations.iter().enumerate() {
            for station in stations {
                let (point, weight) = self.station_point(view, &frame, element, station);
                sum += weight * f(&point);
            }
        }
        sum
    }

    /// Energies (6), (17).
    #[must_use]
    pub fn energy(&self, view: View<'_>) -> Energy {
        let half = |stiffness: f64, measure: f64| 0.5 * stiffness * measure * measure;
        let ring = &self.ring;
        Energy {
            kinetic: self.integrate(view, |p| half(ring.mass_per_length, p.velocity().norm())),
            membrane: self.integrate(view, |p| half(ring.axial_stiffness, p.strain())),
            bending: self.integrate(view, |p| half(ring.bending_stiffness, ale::curvature(p))),
        }
    }

    /// Mass matrix M(q) = ∫ m_r PᵀP dξ (16), dense, nothing locked. The columns of P are the velocities at unit rates.
    #[must_use]
    pub fn mass_matrix(&self, q: &[f64]) -> DMatrix<f64> {
        let n = q.len();
        let mut mass = DMatrix::zeros(n, n);
        let (mut unit, zeros) = (vec![0.0; n], vec![0.0; n]);
        let frame = self.curve.frame(q[self.theta()]);
        for (element, stations) in self.mesh.stations.iter().enumerate() {
            let at = self.directions(element);
            for station in stations {
                let column = |i: usize| {
                    unit[i] = 1.0;
                    let view = View {
                        y: &unit,
                        y_dot: &zeros,
                        q,
                    };
                    let (point, weight) = self.station_point(view, &frame, element, station);
                    unit[i] = 0.0;
                    (point.velocity(), weight * self.ring.mass_per_length)
                };
                let p = at.map(column);
                for (i, (p_i, weight)) in at.iter().zip(&p) {
                    for (j, (p_j, _)) in at.iter().zip(&p) {
                        mass[(*i, *j)] += weight * p_i.dot(p_j);
                    }
                }
            }
        }
        mass
    }

    /// Balance of an element in the order of its directions.
    fn balance<T: Real<Constant = f64>>(
        &self,
        element: usize,
        frame: &C::Frame<T>,
        (overlay, motion): &(ElementMotion<T>, ReferenceMotion<T>),
    ) -> [T; DIRECTIONS] {
        let length = overlay.length;
        let growth = length.d / length.v;
        let mut sum = ElementLoad::zero();
        for station in &self.mesh.stations[element] {
            let reference = C::point(frame, self.mesh.elements[element].segment, station.fraction);
            let point = RingPoint::new(reference, &station.shape, overlay, motion);
            let mut load = Load::zero();
            match self.inertia {
                Inertia::Pointwise => ale::add_inertia(&self.ring, &point, &mut load),
                Inertia::Conservative => {
                    ale::add_conservative_inertia(&self.ring, &point, growth, motion.theta.rate, &mut load);
                }
            }
            ale::add_elasticity(&self.ring, &point, growth, &mut load);
            sum.add(&load, &point, &station.shape, overlay, length.v * station.weight);
        }
        let ([left, right], theta) = sum.nodes(overlay);
        [
            left.a.x, left.b.x, left.a.y, left.b.y, right.a.x, right.b.x, right.a.y, right.b.y, sum.s, theta,
        ]
    }
}

impl<C: ReferenceCurve> System for RingSystem<C> {
    fn shape(&self) -> Shape {
        Shape {
            blocks: self.mesh.elements.len(),
            block: BLOCK,
            border: 2,
        }
    }

    fn has_position(&self) -> &[bool] {
        &self.has_position
    }

    fn residual(&mut self, view: View<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let frame = self.frame(view);
        for element in 0..self.mesh.elements.len() {
            let motion = self.motion(view, element, &frame, [0.0; 2], |value, _, _| value);
            let rows = self.balance(element, &frame, &motion);
            for (i, row) in self.directions(element).into_iter().zip(rows) {
                out[i] += row;
            }
        }
        for &i in &self.locked {
            out[i] = view.y[i];
        }
    }

    fn jacobian(&mut self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        out.clear();
        let seed = |value: f64, direction: usize, slope: f64| {
            let mut eps = SVector::<f64, DIRECTIONS>::zeros();
            eps[direction] = slope;
            DualSVec64::new(value, Derivative::some(eps))
        };
        let frame = self.curve.frame(seed(view.q[self.theta()], DIRECTIONS - 1, beta));
        for element in 0..self.mesh.elements.len() {
            let motion = self.motion(view, element, &frame, [alpha, beta], seed);
            let rows = self.balance(element, &frame, &motion);
            let at = self.directions(element);
            for (&i, row) in at.iter().zip(&rows) {
                for (&j, &slope) in at.iter().zip(row.eps.0.iter().flatten()) {
                    out.add(i, j, slope);
                }
            }
        }
        for &i in &self.locked {
            out.set_unit_row(i, 1.0);
        }
    }

    fn newton_scale(&self, beta: f64, out: &mut [f64]) {
        let length = self.curve.length();
        // Errors of velocity add up over many short steps: their measure is the slowest bending wave, not the step.
        let wave = (self.ring.bending_stiffness / self.ring.mass_per_length).sqrt() * (TAU / length).powi(2);
        let rate = if wave > 0.0 { wave.min(1.0 / beta) } else { 1.0 / beta };
        for (i, scale) in out.iter_mut().enumerate() {
            let size = if self.is_length(i) { length } else { 1.0 };
            *scale = NEWTON_ACCURACY * size * rate;
        }
    }
}

impl<C: ReferenceCurve> Evolution for RingSystem<C> {
    fn error_norm(&self, _view: View<'_>, _y_error: &[f64], q_error: &[f64]) -> f64 {
        let length = self.curve.length();
        let sum: f64 = q_error
            .iter()
            .enumerate()
            .map(|(i, error)| if self.is_length(i) { error / length } else { *error })
            .map(|error| error * error)
            .sum();
        (sum / q_error.len() as f64).sqrt() / self.tolerance
    }

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, h: f64) {
        let viscosity = self.ring.axial_stiffness * self.ring.damping;
        if viscosity != 0.0 {
            for view in [before, after] {
                self.dissipated += 0.5 * h * self.integrate(view, |p| viscosity * p.strain_rate().powi(2));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference_curve::TwoPulley;

    /// Positive and negative numbers without a pattern, within ±0.5.
    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    #[test]
    fn jacobian_matches_differences() {
        let ring = Ring {
            mass_per_length: 0.24,
            axial_stiffness: 5.57e3,
            bending_stiffness: 0.0159,
            damping: 2.0e-4,
        };
        let mesh = RingMesh::even(&[1, 1, 2, 1, 1], 3);
        let mut system = RingSystem::flexible(ring, TwoPulley::new(0.168, 0.703), mesh);
        let mut state = system.rest(0.2);
        let n = state.y.len();
        let mut random = noise(3);
        for i in 0..n {
            state.q[i] += 0.02 * random();
            state.y[i] = 3.0 * random();
            state.y_dot[i] = 100.0 * random();
        }
        let (alpha, beta) = (300.0, 0.01);
        let mut matrix = Arrow::new(system.shape());
        system.jacobian(state.view(), alpha, beta, &mut matrix);
        let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
        for j in 0..n {
            unit[j] = 1.0;
            matrix.multiply(&unit, &mut column);
            unit[j] = 0.0;
            let h = 1.0e-4;
            let mut shifted = |h: f64| {
                let mut s = state.clone();
                s.y[j] += h;
                s.y_dot[j] += alpha * h;
                s.q[j] += beta * h;
                let mut r = vec![0.0; n];
                system.residual(s.view(), &mut r);
                r
            };
            let (plus, minus) = (shifted(h), shifted(-h));
            let scale = column.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for i in 0..n {
                let difference = (plus[i] - minus[i]) / (2.0 * h);
                assert!(
                    (difference - column[i]).abs() < 1e-6 * scale,
                    "row {i} column {j}: {} {difference}",
                    column[i]
                );
            }
        }
    }
}
