//! Particles, energies, the power of damping, and the mass matrix of a state.

use super::free_ring::RingSystem;
use nalgebra::DMatrix;
use pushbelt::solver::View;
use pushbelt_paper::ring::model::{ElementPlace, Energy, RingFormulation};
use pushbelt_paper::ring::particle::Particle;

impl<M: RingFormulation<D, N>, const D: usize, const N: usize> RingSystem<M, D, N> {
    /// The particle at the local coordinate x ∈ [−1, 1] of an element.
    #[must_use]
    pub fn particle(&self, view: View<'_>, element: usize, x: f64) -> Particle<f64, D> {
        let motion = self.values(view, element);
        self.model.particle(&self.frame(view), element, x, &motion)
    }

    /// The particle at the place ξ, m, for any drift of the mesh: x̄ = ξ − s (1).
    #[must_use]
    pub fn particle_at(&self, view: View<'_>, xi: f64) -> Particle<f64, D> {
        let ElementPlace { element, x } = self.model.locate(&self.frame(view), view.q[self.drift()], xi);
        self.particle(view, element, x)
    }

    /// ∫ `f` dξ over the ring.
    pub fn integrate(&self, view: View<'_>, mut f: impl FnMut(&Particle<f64, D>) -> f64) -> f64 {
        let frame = self.frame(view);
        let mut sum = 0.0;
        for element in 0..self.model.elements() {
            let motion = self.values(view, element);
            for &(x, weight) in self.model.quadrature() {
                let particle = self.model.particle(&frame, element, x, &motion);
                let scale = self.model.half_length(&frame, element);
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

    /// Power that damping dissipates, W.
    #[must_use]
    pub fn dissipation(&self, view: View<'_>) -> f64 {
        let frame = self.frame(view);
        (0..self.model.elements())
            .map(|element| self.model.dissipation(&frame, element, &self.values(view, element)))
            .sum()
    }

    /// Dense mass matrix M(q) = ∫ m_r PᵀP dξ (16), without held unknowns. The columns of P are the
    /// velocities at unit rates.
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
                    let particle = self.model.particle(&frame, element, x, &motion);
                    let scale = self.model.half_length(&frame, element);
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
