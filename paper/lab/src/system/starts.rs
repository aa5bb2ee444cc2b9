//! Start states.

use super::free_ring::RingSystem;
use crate::motion::advance;
use nalgebra::SVector;
use pushbelt::solver::arrow::{Arrow, ArrowLu, Singular};
use pushbelt::solver::sdirk::{Sdirk, Stalled};
use pushbelt::solver::{State, System};
use pushbelt_paper::ring::model::{RingFormulation, RingShape};
use pushbelt_paper::ring::particle::ParticleLoad;

impl<M: RingFormulation<D, N>, const D: usize, const N: usize> RingSystem<M, D, N> {
    /// At rest on the reference curve at Θ.
    #[must_use]
    pub fn rest(&self, theta: f64) -> State {
        self.at_rest(theta, |model, q| model.place_on_curve(q))
    }

    /// At rest on a shape: (r, r') at ξ. Nodes are on it exactly, the inside of an element
    /// approximately.
    #[must_use]
    pub fn rest_on(&self, theta: f64, shape: RingShape<'_, D>) -> State {
        self.at_rest(theta, |model, q| model.place_on(shape, q))
    }

    fn at_rest(&self, theta: f64, lay: impl Fn(&M, &mut [f64])) -> State {
        let mut state = State::zero(self.shape().len());
        state.q[self.theta()] = theta;
        lay(&self.model, &mut state.q);
        state
    }

    /// Sets the velocities of a ring to the least-squares fit of v(ξ), m/s: M q̇ = ∫m_r Pᵀv dξ.
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
        self.jacobian(0.0, state.view(), 1.0, 0.0, &mut mass);
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
                let scale = self.model.half_length(&frame, element);
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

    /// Relaxes a ring at rest towards equilibrium by `count` implicit steps of size `step`, s, each
    /// followed by zero velocities. Modes that are stiff for `step` relax; soft modes hardly move.
    /// This removes the stretch of cubic elements after [`RingSystem::rest_on`].
    ///
    /// # Errors
    /// The step size fell below the integrator's smallest.
    pub fn settle(&self, state: &mut State, step: f64, count: usize) -> Result<(), Stalled> {
        let mut system = self.clone();
        system.tolerance = f64::INFINITY;
        let mut integrator = Sdirk::new(&system, step, step);
        for _ in 0..count {
            advance(&mut integrator, &mut system, state, [0.0, step])?;
            state.y.fill(0.0);
            state.y_dot.fill(0.0);
        }
        Ok(())
    }
}
