//! The ring alone, free in the plane or in space, as an implicit system: no chain, contact or pulleys (paper 5.3).
//!
//! ∫ m_r Pᵀ Dv/Dt dξ + ∂V/∂q + damping = 0 (25) for any [`RingModel`]. Unknowns are the rates: blocks of the model
//! around the loop, then ṡ and Θ̇ in the border, so the Jacobian is an arrow matrix whatever the model.

use super::kinematics::Motion;
use super::model::{Coordinates, DIRECTIONS, Energy, RingModel, Shape};
use super::particle::{Particle, ParticleLoad};
use crate::scalar::{LANES, Lanes, Real, Tangent};
use crate::solver::arrow::{Arrow, ArrowLu, Shape as MatrixShape, Singular};
use crate::solver::sdirk::{Evolution, Sdirk, Stalled};
use crate::solver::{State, System, View};
use nalgebra::{DMatrix, SVector};
use num_dual::{Derivative, DualSVec64};
use std::array;
use std::f64::consts::TAU;

/// Change of the shape that does not matter to Newton's method, in units of the length L. Thin rings leave no smaller
/// one: rounding in the tension bends them by 1e-16·EA L²/EI.
const NEWTON_ACCURACY: f64 = 1.0e-9;

/// Directions differentiated in one pass over a pack of elements.
const PASS: usize = 5;

/// A free ring.
#[derive(Clone, Debug)]
pub struct RingSystem<M, const D: usize = 2, const N: usize = DIRECTIONS> {
    /// Ring model on its mesh.
    pub model: M,
    /// Position error of a step that is tolerated, in units of L (deflection, drift) and 1 (slope, Θ). Infinite:
    /// every step is accepted, so the longest step of the integrator is the step.
    pub tolerance: f64,
    /// Unknowns held at zero rate.
    pub held: Vec<usize>,
    /// Energy that damping took since the start, J.
    pub dissipated: f64,
    has_position: Vec<bool>,
    packs: Vec<Pack<N>>,
}

fn shape<M: RingModel<D, N>, const D: usize, const N: usize>(model: &M) -> MatrixShape {
    MatrixShape {
        blocks: model.elements(),
        block: M::BLOCK,
        border: 2,
    }
}

/// Motion of an element's unknowns: `read` finds unknown k of the element in a vector, `seed` makes a scalar of a value,
/// its direction and its slope.
#[inline(always)]
fn coordinates<W, T: Real, const N: usize>(
    view: View<'_>,
    [alpha, beta]: [f64; 2],
    read: impl Fn(&[f64], usize) -> W,
    seed: impl Fn(W, usize, f64) -> T,
) -> Coordinates<T, N> {
    array::from_fn(|k| Motion {
        value: seed(read(view.q, k), k, beta),
        rate: seed(read(view.y, k), k, 1.0),
        acceleration: seed(read(view.y_dot, k), k, alpha),
    })
}

/// Neighbouring elements, one in each lane of a register.
#[derive(Clone, Debug)]
struct Pack<const N: usize> {
    /// The first element.
    first: usize,
    /// Unknowns of each element.
    elements: Vec<[usize; N]>,
    /// Places in the matrix of each element's derivatives.
    entries: Vec<[[usize; N]; N]>,
    /// Those that fill the lanes: where elements are missing, the first stands again.
    lanes: [[usize; LANES]; N],
}

impl<const N: usize> Pack<N> {
    fn all<M: RingModel<D, N>, const D: usize>(model: &M) -> Vec<Self> {
        let shape = shape::<M, D, N>(model);
        let elements: Vec<_> = (0..model.elements()).map(|element| model.directions(element)).collect();
        let entry = |i, j| shape.index(i, j).expect("an entry in the band");
        let chunks = elements.chunks(LANES).enumerate();
        chunks
            .map(|(k, elements)| Self {
                first: k * LANES,
                elements: elements.to_vec(),
                entries: elements.iter().map(|at| at.map(|i| at.map(|j| entry(i, j)))).collect(),
                lanes: array::from_fn(|i| array::from_fn(|lane| elements.get(lane).unwrap_or(&elements[0])[i])),
            })
            .collect()
    }

    /// Motion of its unknowns.
    #[inline(always)]
    fn motion<T: Real>(
        &self,
        view: View<'_>,
        slopes: [f64; 2],
        seed: impl Fn(Lanes, usize, f64) -> T,
    ) -> Coordinates<T, N> {
        coordinates(view, slopes, |of, k| Lanes::new(self.lanes[k].map(|i| of[i])), seed)
    }

    /// Adds its derivatives to the matrix; false if the model's elements go one by one.
    fn add_slopes<M: RingModel<D, N>, const D: usize>(
        &self,
        model: &M,
        view: View<'_>,
        slopes: [f64; 2],
        out: &mut Arrow,
    ) -> bool {
        for first in (0..N).step_by(PASS) {
            let seed =
                |value, direction: usize, slope| Tangent::<PASS>::seed(value, direction.wrapping_sub(first), slope);
            let Some(rows) = model.balance_of_many(&self.motion(view, slopes, seed)) else {
                return false;
            };
            for (i, row) in rows.iter().enumerate() {
                for (j, slopes) in (first..N).zip(row.eps) {
                    for (entries, slope) in self.entries.iter().zip(slopes.to_array()) {
                        out.add_at(entries[i][j], slope);
                    }
                }
            }
        }
        true
    }
}

impl<M: RingModel<D, N>, const D: usize, const N: usize> RingSystem<M, D, N> {
    /// A free ring of this model.
    ///
    /// # Panics
    /// With fewer than three elements.
    #[must_use]
    pub fn new(model: M) -> Self {
        assert!(model.elements() >= 3, "a ring needs three elements");
        let held = model.held();
        let mut system = Self {
            packs: Pack::all(&model),
            model,
            tolerance: 1.0e-5,
            held,
            dissipated: 0.0,
            has_position: Vec::new(),
        };
        system.has_position = vec![true; system.shape().len()];
        system
    }

    /// Index of component `k` of a block; blocks count around the loop.
    #[must_use]
    pub fn node(&self, node: usize, k: usize) -> usize {
        node % self.model.elements() * M::BLOCK + k
    }

    /// Index of the drift s.
    #[must_use]
    pub fn drift(&self) -> usize {
        self.model.elements() * M::BLOCK
    }

    /// Index of Θ.
    #[must_use]
    pub fn theta(&self) -> usize {
        self.drift() + 1
    }

    /// Number of degrees of freedom: unknowns that are neither held nor follow from the others.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        self.shape().len() - self.held.len() - usize::from(M::LAGRANGIAN)
    }

    /// At rest on the reference curve at Θ.
    #[must_use]
    pub fn rest(&self, theta: f64) -> State {
        self.at_rest(theta, |model, q| model.lay_on_curve(q))
    }

    /// At rest on a shape: (r, r') at ξ. Nodes stand on it exactly, what is between them as the model can.
    #[must_use]
    pub fn rest_on(&self, theta: f64, shape: Shape<'_, D>) -> State {
        self.at_rest(theta, |model, q| model.lay(shape, q))
    }

    fn at_rest(&self, theta: f64, lay: impl Fn(&M, &mut [f64])) -> State {
        let mut state = State::zero(self.shape().len());
        state.q[self.theta()] = theta;
        lay(&self.model, &mut state.q);
        state
    }

    /// Gives a ring the velocities v(ξ), m/s, in the sense of least squares: M q̇ = ∫m_r Pᵀv dξ.
    ///
    /// # Errors
    /// The mass matrix is singular: the ring has no mass, or too few unknowns are held.
    pub fn set_in_motion(
        &mut self,
        state: &mut State,
        velocity: impl Fn(f64) -> SVector<f64, D>,
    ) -> Result<(), Singular> {
        state.y.fill(0.0);
        let mut mass = Arrow::new(self.shape());
        self.jacobian(state.view(), 1.0, 0.0, &mut mass);
        let mut factors = ArrowLu::new(self.shape());
        factors.factor(&mass)?;
        let frame = self.frame(state.view());
        let density = self.model.ring().mass_per_length;
        let mut momentum = vec![0.0; state.y.len()];
        let mut xi = 0.0;
        for element in 0..self.model.elements() {
            let motion = self.values(state.view(), element);
            let mut length = 0.0;
            for &(x, weight) in self.model.quadrature() {
                let (_, scale) = self.model.particle(&frame, element, x, &motion);
                let load = ParticleLoad {
                    position: velocity(xi + scale * (1.0 + x)) * (density * scale * weight),
                    ..ParticleLoad::zero()
                };
                length += scale * weight;
                let rows = self.model.project(&frame, element, x, &motion, &load);
                for (i, row) in self.model.directions(element).into_iter().zip(rows) {
                    momentum[i] += row;
                }
            }
            xi += length;
        }
        self.held.iter().for_each(|&i| momentum[i] = 0.0);
        factors.solve(&mut momentum);
        state.y.copy_from_slice(&momentum);
        Ok(())
    }

    /// Lets a ring at rest that is nearly in balance find it: `count` implicit steps of size `step`, s, whose
    /// velocities are forgotten. What is stiff against `step` settles, what is soft hardly moves: so the stretch goes
    /// that cubic elements have when they are laid on a shape.
    ///
    /// # Errors
    /// The step size fell below the integrator's smallest.
    pub fn settle(&self, state: &mut State, step: f64, count: usize) -> Result<(), Stalled> {
        let mut system = self.clone();
        system.tolerance = f64::INFINITY;
        let mut integrator = Sdirk::new(&system, step, step);
        for _ in 0..count {
            integrator.advance(&mut system, state, 0.0, step)?;
            state.y.fill(0.0);
            state.y_dot.fill(0.0);
        }
        Ok(())
    }

    /// Whether an unknown is the rate of a length.
    fn is_length(&self, i: usize) -> bool {
        i == self.drift() || (i < self.drift() && self.model.is_length(i % M::BLOCK))
    }

    /// Motion of an element's unknowns.
    fn motion<T: Real>(
        &self,
        view: View<'_>,
        element: usize,
        slopes: [f64; 2],
        seed: impl Fn(f64, usize, f64) -> T,
    ) -> Coordinates<T, N> {
        let at = self.model.directions(element);
        coordinates(view, slopes, |of, k| of[at[k]], seed)
    }

    /// Motion of an element's unknowns.
    #[must_use]
    pub fn values(&self, view: View<'_>, element: usize) -> Coordinates<f64, N> {
        self.motion(view, element, [0.0; 2], |value, _, _| value)
    }

    /// The model's frame at the Θ of a state.
    #[must_use]
    pub fn frame(&self, view: View<'_>) -> M::Frame<f64> {
        self.model.frame(view.q[self.theta()])
    }

    /// The particle at the local coordinate x ∈ [−1, 1] of an element.
    #[must_use]
    pub fn particle(&self, view: View<'_>, element: usize, x: f64) -> Particle<f64, D> {
        let motion = self.values(view, element);
        self.model.particle(&self.frame(view), element, x, &motion).0
    }

    /// The particle at the place ξ, m, wherever the mesh stands: x̄ = ξ − s (1).
    #[must_use]
    pub fn particle_at(&self, view: View<'_>, xi: f64) -> Particle<f64, D> {
        let (element, x) = self.model.locate(&self.frame(view), view.q[self.drift()], xi);
        self.particle(view, element, x)
    }

    /// ∫ `f` dξ over the ring.
    pub fn integrate(&self, view: View<'_>, mut f: impl FnMut(&Particle<f64, D>) -> f64) -> f64 {
        let frame = self.frame(view);
        let mut sum = 0.0;
        for element in 0..self.model.elements() {
            let motion = self.values(view, element);
            for &(x, weight) in self.model.quadrature() {
                let (particle, scale) = self.model.particle(&frame, element, x, &motion);
                sum += weight * scale * f(&particle);
            }
        }
        sum
    }

    /// Energies (6), (17).
    #[must_use]
    pub fn energy(&self, view: View<'_>) -> Energy {
        let frame = self.frame(view);
        let mut sum = Energy::default();
        for element in 0..self.model.elements() {
            sum += self.model.energy(&frame, element, &self.values(view, element));
        }
        sum
    }

    /// Power that damping takes, W.
    #[must_use]
    pub fn dissipation(&self, view: View<'_>) -> f64 {
        let frame = self.frame(view);
        (0..self.model.elements())
            .map(|element| self.model.dissipation(&frame, element, &self.values(view, element)))
            .sum()
    }

    /// Mass matrix M(q) = ∫ m_r PᵀP dξ (16), dense, nothing held. The columns of P are the velocities at unit rates.
    #[must_use]
    pub fn mass_matrix(&self, q: &[f64]) -> DMatrix<f64> {
        let n = q.len();
        let mut mass = DMatrix::zeros(n, n);
        let (mut unit, zeros) = (vec![0.0; n], vec![0.0; n]);
        let frame = self.model.frame(q[self.theta()]);
        for element in 0..self.model.elements() {
            let at = self.model.directions(element);
            for &(x, weight) in self.model.quadrature() {
                let column = |i: usize| {
                    unit[i] = 1.0;
                    let view = View {
                        y: &unit,
                        y_dot: &zeros,
                        q,
                    };
                    let motion = self.values(view, element);
                    unit[i] = 0.0;
                    let (particle, scale) = self.model.particle(&frame, element, x, &motion);
                    (particle.velocity, weight * scale * self.model.ring().mass_per_length)
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
}

impl<M: RingModel<D, N>, const D: usize, const N: usize> System for RingSystem<M, D, N> {
    fn shape(&self) -> MatrixShape {
        shape(&self.model)
    }

    fn has_position(&self) -> &[bool] {
        &self.has_position
    }

    fn residual(&mut self, view: View<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let frame = self.frame(view);
        for pack in &self.packs {
            if let Some(rows) = self
                .model
                .balance_of_many(&pack.motion(view, [0.0; 2], |value, _, _| value))
            {
                let rows = rows.map(Lanes::to_array);
                for (lane, at) in pack.elements.iter().enumerate() {
                    at.iter().zip(&rows).for_each(|(&i, row)| out[i] += row[lane]);
                }
                continue;
            }
            for (element, at) in (pack.first..).zip(&pack.elements) {
                let rows = self.model.balance(&frame, element, &self.values(view, element));
                at.iter().zip(rows).for_each(|(&i, row)| out[i] += row);
            }
        }
        for &i in &self.held {
            out[i] = view.y[i];
        }
    }

    fn jacobian(&mut self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        out.clear();
        let slopes = [alpha, beta];
        let seed = |value: f64, direction: usize, slope: f64| {
            let mut eps = SVector::<f64, N>::zeros();
            eps[direction] = slope;
            DualSVec64::new(value, Derivative::some(eps))
        };
        let frame = self.model.frame(seed(view.q[self.theta()], N - 1, beta));
        for pack in &self.packs {
            if pack.add_slopes(&self.model, view, slopes, out) {
                continue;
            }
            for (element, entries) in (pack.first..).zip(&pack.entries) {
                let motion = self.motion(view, element, slopes, seed);
                let rows = self.model.balance(&frame, element, &motion);
                for (entries, row) in entries.iter().zip(&rows) {
                    for (&entry, &slope) in entries.iter().zip(row.eps.0.iter().flatten()) {
                        out.add_at(entry, slope);
                    }
                }
            }
        }
        for &i in &self.held {
            out.set_unit_row(i, 1.0);
        }
    }

    fn newton_scale(&self, beta: f64, out: &mut [f64]) {
        let length = self.model.length();
        let ring = self.model.ring();
        // Errors of velocity add up over many short steps: their measure is the slowest bending wave, not the step.
        let wave = (ring.bending_stiffness / ring.mass_per_length).sqrt() * (TAU / length).powi(2);
        let rate = if wave > 0.0 { wave.min(1.0 / beta) } else { 1.0 / beta };
        for (i, scale) in out.iter_mut().enumerate() {
            let size = if self.is_length(i) { length } else { 1.0 };
            *scale = NEWTON_ACCURACY * size * rate;
        }
    }
}

impl<M: RingModel<D, N>, const D: usize, const N: usize> Evolution for RingSystem<M, D, N> {
    fn error_norm(&self, _view: View<'_>, _y_error: &[f64], q_error: &[f64]) -> f64 {
        let length = self.model.length();
        let sum: f64 = q_error
            .iter()
            .enumerate()
            .map(|(i, error)| if self.is_length(i) { error / length } else { *error })
            .map(|error| error * error)
            .sum();
        (sum / q_error.len() as f64).sqrt() / self.tolerance
    }

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, h: f64) {
        if self.model.ring().damping != 0.0 {
            for view in [before, after] {
                self.dissipated += 0.5 * h * self.dissipation(view);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference_curve::TwoPulley;
    use crate::ring::Ring;
    use crate::ring::ale_ring::{AleRing, Directions};
    use crate::ring::ancf::Ancf;
    use crate::ring::mesh::RingMesh;
    use crate::ring::rcm::Rcm;
    use crate::solver::differences::compare;
    use pushbelt_lab::noise;

    fn jacobian_matches_differences<const D: usize, const N: usize>(model: impl RingModel<D, N>) {
        let mut system = RingSystem::new(model);
        let mut state = system.rest(0.2);
        let n = state.y.len();
        let mut random = noise(3);
        for i in 0..n {
            let size = if i < system.drift() && system.is_length(i) {
                0.004
            } else {
                0.02
            };
            state.q[i] += size * random();
            state.y[i] = 3.0 * random();
            state.y_dot[i] = 100.0 * random();
        }
        compare(
            &mut system,
            &state,
            [300.0, 0.01],
            |_| 1.0e-4,
            |entry| {
                assert!(
                    (entry.difference - entry.exact).abs() < 1e-6 * entry.largest,
                    "row {}: {entry:?}",
                    entry.row
                );
            },
        );
    }

    /// A soft ring, so that no stiffness drowns the rest.
    fn ring() -> Ring {
        Ring {
            mass_per_length: 0.24,
            axial_stiffness: 5.57e3,
            bending_stiffness: 0.0159,
            lateral_bending_stiffness: 0.031,
            damping: 2.0e-4,
        }
    }

    #[test]
    fn jacobians_match_differences() {
        let ring = ring();
        let curve = TwoPulley::new(0.168, 0.703);
        let mesh = RingMesh::even(&[1, 1, 2, 1, 1], 3);
        for directions in [Directions::Fixed, Directions::Reference] {
            let mut planar = AleRing::flexible(ring.clone(), curve.clone(), mesh.clone());
            planar.directions = directions;
            jacobian_matches_differences(planar);
            let mut spatial = AleRing::spatial(ring.clone(), curve.clone(), mesh.clone());
            spatial.directions = directions;
            jacobian_matches_differences(spatial);
        }
        jacobian_matches_differences(Ancf::new(ring.clone(), curve.clone(), 8, 3));
        jacobian_matches_differences(Rcm::new(ring, curve, 9, 5));
    }

    /// Elements that don't fill the last pack.
    #[test]
    fn packs_are_the_sum_of_their_elements() {
        let mut system = RingSystem::new(Ancf::new(ring(), TwoPulley::new(0.168, 0.703), 11, 3));
        let mut state = system.rest(0.2);
        let mut random = noise(4);
        for i in 0..state.y.len() {
            state.q[i] += 0.01 * random();
            state.y[i] = random();
            state.y_dot[i] = random();
        }
        let (mut packed, mut summed) = (vec![0.0; state.y.len()], vec![0.0; state.y.len()]);
        system.residual(state.view(), &mut packed);
        for element in 0..11 {
            let rows = system
                .model
                .balance(&(), element, &system.values(state.view(), element));
            for (i, row) in system.model.directions(element).into_iter().zip(rows) {
                summed[i] += row;
            }
        }
        let largest = summed.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, (a, b)) in packed.iter().zip(&summed).enumerate() {
            assert!(
                system.held.contains(&i) || (a - b).abs() < 1e-12 * largest,
                "row {i}: {a}, {b}"
            );
        }
    }
}
