//! The free ring and its unknowns.

use super::packs::{ElementPack, coordinates, shape};
use pushbelt::scalar::Real;
use pushbelt::solver::View;
use pushbelt_paper::ring::model::{Coordinates, DIRECTIONS, RingFormulation};

/// Default tolerance of the position error of a step, in units of L.
const TOLERANCE: f64 = 1.0e-5;

/// A ring without stack, contact and pulleys.
#[derive(Clone, Debug)]
pub struct RingSystem<M, const D: usize = 2, const N: usize = DIRECTIONS> {
    /// The ring model on its mesh.
    pub model: M,
    /// Tolerance of the position error of a step, in units of L (deflection, drift) and 1 (slope,
    /// Θ). If infinite, every step is accepted and the step size is the largest step of the
    /// integrator.
    pub tolerance: f64,
    /// Unknowns held at zero rate.
    pub held: Vec<usize>,
    /// Energy that damping has dissipated since the start, J.
    pub dissipated: f64,
    pub(super) has_position: Vec<bool>,
    pub(super) packs: Vec<ElementPack<N>>,
}

impl<M: RingFormulation<D, N>, const D: usize, const N: usize> RingSystem<M, D, N> {
    /// A free ring of this model.
    ///
    /// # Panics
    /// With fewer than three elements.
    #[must_use]
    pub fn new(model: M) -> Self {
        assert!(model.elements() >= 3, "a ring needs three elements");
        let held = model.held();
        let mut system = Self {
            packs: ElementPack::all(&model),
            model,
            tolerance: TOLERANCE,
            held,
            dissipated: 0.0,
            has_position: Vec::new(),
        };
        system.has_position = vec![true; shape(&system.model).len()];
        system
    }

    /// Index of component `k` of a block; block numbers are taken modulo the number of elements.
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

    /// Number of degrees of freedom: unknowns that are neither held nor determined by the others.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        shape(&self.model).len() - self.held.len() - usize::from(M::LAGRANGIAN)
    }

    /// Whether an unknown is the rate of a length.
    #[must_use]
    pub fn is_length(&self, i: usize) -> bool {
        i == self.drift() || (i < self.drift() && self.model.is_length(i % M::BLOCK))
    }

    /// Motion of an element's unknowns.
    pub(super) fn motion<T: Real>(
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
}
