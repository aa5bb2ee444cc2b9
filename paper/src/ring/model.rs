//! The trait of a ring model: the law of one element as a function of its unknowns.
//!
//! Unknowns are in blocks around the loop, one block per ring element: its left node, then unknowns
//! of the element alone. The border holds the drift s and Θ. An element depends on N unknowns:
//! those of its own block, the next block's node, s and Θ; N = 10 in the plane. From their motion a
//! model computes the ring's [`Particle`]s and the balance of inertia and elasticity, and it maps
//! forces on particles to forces on unknowns. Particles have D = 2 components, or 3 in space.
//!
//! | model | mesh | block | s | Θ |
//! |---|---|---|---|---|
//! | [`AleRing`](super::ale_ring::AleRing) | fixed in space, material flows through | a_x, b_x, a_y, b_y: overlay and its slope | unknown of the motion | unknown of the motion |
//! | the same in space, N = 14 | the same | a_x, b_x, a_y, b_y, a_z, b_z | the same | the same |
//! | the same with q_f = 0 (`ALE0`) | the same | locked | the same | the same |
//! | [`Ancf`](super::ancf::Ancf) | travels with the ring | x, x', y, y' | follows: mean drift | held |
//! | [`Rcm`](super::rcm::Rcm) | travels with the ring | x, y, φ, c_L, c_R | follows: mean drift | held |

pub use super::Energy;
use super::Ring;
use super::kinematics::Motion;
use super::particle::{Particle, ParticleLoad};
use crate::scalar::{Lanes, Real};
use nalgebra::SVector;

/// Unknowns that an element of a planar ring depends on: eight of its block and the next node, then
/// s and Θ.
pub const DIRECTIONS: usize = 10;
/// Number of the [`DIRECTIONS`] that belong to blocks.
pub const NODAL: usize = 8;
/// Index of s among the [`DIRECTIONS`].
pub const DRIFT: usize = 8;

/// Motion of the unknowns that an element depends on.
pub type Coordinates<T, const N: usize = DIRECTIONS> = [Motion<T>; N];

/// Shape of a ring: (r, r') at ξ.
pub type RingShape<'a, const D: usize = 2> = &'a dyn Fn(f64) -> [SVector<f64, D>; 2];

/// A place in an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementPlace {
    /// The element.
    pub element: usize,
    /// Local coordinate from −1 to 1.
    pub x: f64,
}

/// A ring model on its mesh, with D components and N unknowns per element; s and Θ are the last
/// two.
pub trait RingFormulation<const D: usize = 2, const N: usize = DIRECTIONS>: Clone + std::fmt::Debug {
    /// Unknowns in a block.
    const BLOCK: usize;

    /// Whether the mesh travels with the ring. If so, its unknowns are positions, s follows from
    /// the mean drift and Θ is held; otherwise s and Θ are coordinates of the motion.
    const LAGRANGIAN: bool;

    /// Quantities that depend on Θ alone, computed once for all elements.
    type Frame<T: Real>: Clone;

    /// The parameters of the beam.
    fn ring(&self) -> &Ring;

    /// Mutable parameters of the beam.
    fn ring_mut(&mut self) -> &mut Ring;

    /// Unstretched length L, m.
    fn length(&self) -> f64;

    /// Number of elements.
    fn elements(&self) -> usize;

    /// Quadrature points of an element: local coordinate x ∈ [−1, 1], weight (of sum 2).
    fn quadrature(&self) -> &'static [(f64, f64)];

    /// Whether unknown `k` of a block is a length, m; otherwise it is an angle or a slope.
    fn is_length(&self, k: usize) -> bool;

    /// Indices of the unknowns that are held.
    fn held(&self) -> Vec<usize>;

    /// The frame at Θ.
    fn frame<T: Real>(&self, theta: T) -> Self::Frame<T>;

    /// Element and local coordinate x of the particle that is at ξ when the ring has drifted by s.
    fn locate(&self, frame: &Self::Frame<f64>, s: f64, xi: f64) -> ElementPlace;

    /// Sets the unknowns `q` so that the nodes are on a shape at s = 0; `q[Θ]` is given.
    fn place_on(&self, shape: RingShape<'_, D>, q: &mut [f64]);

    /// Sets the unknowns `q` so that the nodes are on the reference curve; `q[Θ]` is given.
    fn place_on_curve(&self, q: &mut [f64]);

    /// The particle at the local coordinate x of an element.
    fn particle<T: Real<Constant = f64>>(
        &self,
        frame: &Self::Frame<T>,
        element: usize,
        x: f64,
        motion: &Coordinates<T, N>,
    ) -> Particle<T, D>;

    /// Half the unstretched length of an element, m: dξ per dx.
    fn half_length<T: Real<Constant = f64>>(&self, frame: &Self::Frame<T>, element: usize) -> T;

    /// Generalised forces of a load on the particle at x, N: the transpose of
    /// [`RingFormulation::particle`]'s velocities.
    fn project<T: Real<Constant = f64>>(
        &self,
        frame: &Self::Frame<T>,
        element: usize,
        x: f64,
        motion: &Coordinates<T, N>,
        load: &ParticleLoad<T, D>,
    ) -> [T; N];

    /// Balance of an element, inertia less forces, in the order of the directions.
    fn balance<T: Real<Constant = f64>>(
        &self,
        frame: &Self::Frame<T>,
        element: usize,
        motion: &Coordinates<T, N>,
    ) -> [T; N];

    /// [`RingFormulation::balance`] of an element in each lane; `None` if elements differ by more
    /// than their unknowns.
    #[inline(always)]
    fn balance_of_many<T: Real<Constant = Lanes>>(&self, _motion: &Coordinates<T, N>) -> Option<[T; N]> {
        None
    }

    /// Energies of an element.
    fn energy(&self, frame: &Self::Frame<f64>, element: usize, motion: &Coordinates<f64, N>) -> Energy;

    /// Power that damping dissipates in an element, W.
    fn dissipation(&self, frame: &Self::Frame<f64>, element: usize, motion: &Coordinates<f64, N>) -> f64;

    /// Indices of the unknowns of an element.
    fn directions(&self, element: usize) -> [usize; N] {
        let blocks = self.elements() * Self::BLOCK;
        std::array::from_fn(|k| match k {
            k if k < N - 2 => (element * Self::BLOCK + k) % blocks,
            _ => blocks + k + 2 - N,
        })
    }
}
