//! A ring on a mesh that travels with it: Lagrangian elements of equal unstretched length l = L/n.
//!
//! The unknowns are positions, so s and Θ are not coordinates of the motion. s measures the
//! displacement of the mesh: the particle at ξ is at x̄ = ξ − s (1). s follows from the mean drift,
//! ṡ = ∮v·r' dx̄ / ∮r'·r' dx̄, the least-squares fit of ṡ r' to v. Θ determines only the stations
//! on the reference curve and is held.

use super::Ring;
use super::beam;
use super::kinematics::Motion;
use super::mesh::gauss;
use super::model::{Coordinates, DIRECTIONS, DRIFT, ElementPlace, Energy, NODAL, RingFormulation, RingShape};
use super::particle::{Particle, ParticleLoad};
use crate::reference_curve::ReferenceCurve;
use crate::scalar::{Lanes, Real};
use std::ops::Mul;

/// A Lagrangian beam element of unstretched length l.
pub trait LagrangianElement: Clone + std::fmt::Debug + Send + Sync + 'static {
    /// Unknowns in a block.
    const BLOCK: usize;

    /// Whether the membrane energy uses the mean strain of an element, or the strain at each point.
    const MEAN_STRAIN: bool;

    /// Shape functions at a place. `W` is a mesh constant, or the scalar itself where the mesh
    /// moves past a fixed place.
    type ShapeFunctions<W: Real>: Clone + std::fmt::Debug + Send + Sync;

    /// Motion of an element.
    type Motion<T: Real>;

    /// Generalised forces on an element.
    type Force<T: Real>;

    /// Whether unknown `k` of a block is a length.
    fn is_length(k: usize) -> bool;

    /// Shape functions at x ∈ [−1, 1].
    fn shape<W: Real>(x: W) -> Self::ShapeFunctions<W>;

    /// Sets the unknowns of the `block` of an element that begins at x̄ = `start` and is on
    /// `shape`.
    fn place_on(length: f64, start: f64, shape: RingShape<'_>, block: &mut [f64]);

    /// Motion of an element from its unknowns.
    fn motion<T: Real>(length: f64, unknowns: &[Motion<T>]) -> Self::Motion<T>;

    /// The particle at a place.
    fn particle<T: Real + Mul<W, Output = T>, W: Real>(
        motion: &Self::Motion<T>,
        shape: &Self::ShapeFunctions<W>,
    ) -> Particle<T>;

    /// No force.
    fn no_force<T: Real>() -> Self::Force<T>;

    /// Adds a load over the length `weight`, m.
    fn add<T: Real + Mul<W, Output = T>, W: Real>(
        motion: &Self::Motion<T>,
        shape: &Self::ShapeFunctions<W>,
        load: &ParticleLoad<T>,
        weight: f64,
        force: &mut Self::Force<T>,
    );

    /// Conjugates of the unknowns.
    fn conjugates<T: Real>(motion: &Self::Motion<T>, force: &Self::Force<T>) -> [T; NODAL];
}

/// A ring of Lagrangian elements.
#[derive(Clone, Debug)]
pub struct LagrangianRing<E: LagrangianElement, C> {
    ring: Ring,
    curve: C,
    elements: usize,
    quadrature: &'static [(f64, f64)],
    shapes: Vec<E::ShapeFunctions<f64>>,
}

impl<E: LagrangianElement, C: ReferenceCurve> LagrangianRing<E, C> {
    /// A ring of `elements` ≥ 3 elements with `points` Gauss points each (2 to 5), for a reference
    /// curve.
    #[must_use]
    pub fn new(ring: Ring, curve: C, elements: usize, points: usize) -> Self {
        let quadrature = gauss(points);
        Self {
            ring,
            curve,
            elements,
            quadrature,
            shapes: quadrature.iter().map(|&(x, _)| E::shape(x)).collect(),
        }
    }

    /// Unstretched length of an element, m.
    #[must_use]
    pub fn element_length(&self) -> f64 {
        self.curve.length() / self.elements as f64
    }

    /// Motion of an element from its unknowns.
    #[inline(always)]
    pub fn motion<T: Real>(&self, motion: &[Motion<T>]) -> E::Motion<T> {
        E::motion(self.element_length(), &motion[..NODAL])
    }

    /// The particle at the local coordinate x of an element with these unknowns. x may have
    /// derivatives: a station fixed in space is at x̄ = ξ(Θ) − s, so x depends on s and Θ.
    #[inline(always)]
    pub fn particle_at<T: Real + Mul<W, Output = T>, W: Real>(
        &self,
        unknowns: &[Motion<T>],
        x: W,
    ) -> Particle<T> {
        E::particle(&self.motion(unknowns), &E::shape(x))
    }

    /// Generalised forces on those unknowns of a load on the particle at x, N.
    #[inline(always)]
    pub fn force<T: Real + Mul<W, Output = T>, W: Real>(
        &self,
        unknowns: &[Motion<T>],
        x: W,
        load: &ParticleLoad<T>,
    ) -> [T; NODAL] {
        let motion = self.motion(unknowns);
        let mut force = E::no_force();
        E::add(&motion, &E::shape(x), load, 1.0, &mut force);
        E::conjugates(&motion, &force)
    }

    /// Particles at the quadrature points, and their quadrature weights dx̄, m.
    #[inline(always)]
    fn particles<'a, T: Real>(
        &'a self,
        motion: &'a E::Motion<T>,
    ) -> impl Iterator<Item = (&'a E::ShapeFunctions<f64>, Particle<T>, f64)> {
        let half = 0.5 * self.element_length();
        self.shapes
            .iter()
            .zip(self.quadrature)
            .map(move |(shape, &(_, weight))| (shape, E::particle(motion, shape), weight * half))
    }

    /// Tension at the mean strain of an element with these unknowns, N.
    pub fn mean_tension<T: Real>(&self, unknowns: &[Motion<T>]) -> T {
        self.mean_tension_of(&self.motion(unknowns))
    }

    #[inline(always)]
    fn mean_tension_of<T: Real>(&self, element: &E::Motion<T>) -> T {
        let strain = self.mean(element, Particle::strain);
        beam::tension(
            &self.ring,
            strain,
            self.damped(|| self.mean(element, Particle::strain_rate)),
        )
    }

    /// A strain rate, or zero without damping.
    #[inline(always)]
    fn damped<T: Real>(&self, rate: impl FnOnce() -> T) -> T {
        if self.ring.damping == 0.0 { T::zero() } else { rate() }
    }

    /// Balance of an element with these unknowns, the same function for all elements.
    #[inline(always)]
    fn law<T: Real>(&self, motion: &Coordinates<T>) -> [T; DIRECTIONS] {
        let element = self.motion(motion);
        let mean = E::MEAN_STRAIN.then(|| self.mean_tension_of(&element));
        let mut force = E::no_force();
        let mut drift = T::zero();
        for (shape, particle, weight) in self.particles(&element) {
            let mut load = ParticleLoad::zero();
            beam::add_inertia(&self.ring, &particle, &mut load);
            beam::add_bending(&self.ring, &particle, &mut load);
            let tension = mean.unwrap_or_else(|| {
                let rate = self.damped(|| particle.strain_rate());
                beam::tension(&self.ring, particle.strain(), rate)
            });
            beam::add_tension(tension, &particle, &mut load);
            E::add(&element, shape, &load, weight, &mut force);
            let rest = particle.slope * motion[DRIFT].rate - particle.velocity;
            drift += rest.dot(&particle.slope) * weight;
        }
        let rows = E::conjugates(&element, &force);
        std::array::from_fn(|k| match k {
            0..NODAL => rows[k],
            DRIFT => drift,
            _ => T::zero(),
        })
    }

    /// Mean over an element.
    #[inline(always)]
    fn mean<T: Real>(&self, motion: &E::Motion<T>, of: impl Fn(&Particle<T>) -> T) -> T {
        let share = self.element_length().recip();
        self.particles(motion).fold(T::zero(), |sum, (_, particle, weight)| {
            sum + of(&particle) * (weight * share)
        })
    }
}

impl<E: LagrangianElement, C: ReferenceCurve + std::fmt::Debug> RingFormulation for LagrangianRing<E, C> {
    const BLOCK: usize = E::BLOCK;
    const LAGRANGIAN: bool = true;

    type Frame<T: Real> = ();

    fn ring(&self) -> &Ring {
        &self.ring
    }

    fn ring_mut(&mut self) -> &mut Ring {
        &mut self.ring
    }

    fn length(&self) -> f64 {
        self.curve.length()
    }

    fn elements(&self) -> usize {
        self.elements
    }

    fn quadrature(&self) -> &'static [(f64, f64)] {
        self.quadrature
    }

    fn is_length(&self, k: usize) -> bool {
        E::is_length(k)
    }

    fn held(&self) -> Vec<usize> {
        vec![self.elements * E::BLOCK + 1]
    }

    fn frame<T: Real>(&self, _theta: T) {}

    fn locate(&self, (): &(), s: f64, xi: f64) -> ElementPlace {
        let place = (xi - s).rem_euclid(self.length()) / self.element_length();
        let element = (place as usize).min(self.elements - 1);
        ElementPlace {
            element,
            x: 2.0 * (place - element as f64) - 1.0,
        }
    }

    fn place_on(&self, shape: RingShape<'_>, q: &mut [f64]) {
        let length = self.element_length();
        for (element, block) in q.chunks_exact_mut(E::BLOCK).take(self.elements).enumerate() {
            E::place_on(length, element as f64 * length, shape, block);
        }
    }

    fn place_on_curve(&self, q: &mut [f64]) {
        let frame = self.curve.frame(q[self.elements * E::BLOCK + 1]);
        self.place_on(
            &|xi| {
                let point = self.curve.at(&frame, xi);
                [point.r, point.t]
            },
            q,
        );
    }

    fn particle<T: Real<Constant = f64>>(
        &self,
        (): &(),
        _element: usize,
        x: f64,
        motion: &Coordinates<T>,
    ) -> Particle<T> {
        self.particle_at(motion, x)
    }

    fn half_length<T: Real<Constant = f64>>(&self, (): &(), _element: usize) -> T {
        T::from(0.5 * self.element_length())
    }

    fn project<T: Real<Constant = f64>>(
        &self,
        (): &(),
        _element: usize,
        x: f64,
        motion: &Coordinates<T>,
        load: &ParticleLoad<T>,
    ) -> [T; DIRECTIONS] {
        let rows = self.force(motion, x, load);
        std::array::from_fn(|k| if k < NODAL { rows[k] } else { T::zero() })
    }

    #[inline(always)]
    fn balance<T: Real<Constant = f64>>(
        &self,
        (): &(),
        _element: usize,
        motion: &Coordinates<T>,
    ) -> [T; DIRECTIONS] {
        self.law(motion)
    }

    #[inline(always)]
    fn balance_of_many<T: Real<Constant = Lanes>>(&self, motion: &Coordinates<T>) -> Option<[T; DIRECTIONS]> {
        Some(self.law(motion))
    }

    fn energy(&self, (): &(), _element: usize, motion: &Coordinates<f64>) -> Energy {
        let element = self.motion(motion);
        let length = self.element_length();
        let half = |stiffness: f64, square: f64| 0.5 * stiffness * length * square;
        let ring = &self.ring;
        let strain = if E::MEAN_STRAIN {
            self.mean(&element, Particle::strain).powi(2)
        } else {
            self.mean(&element, |p| p.strain().powi(2))
        };
        Energy {
            kinetic: half(ring.mass_per_length, self.mean(&element, |p| p.velocity.norm_squared())),
            membrane: half(ring.axial_stiffness, strain),
            bending: half(ring.bending_stiffness, self.mean(&element, |p| p.curvature().powi(2))),
        }
    }

    fn dissipation(&self, (): &(), _element: usize, motion: &Coordinates<f64>) -> f64 {
        let element = self.motion(motion);
        let rate = if E::MEAN_STRAIN {
            self.mean(&element, Particle::strain_rate).powi(2)
        } else {
            self.mean(&element, |p| p.strain_rate().powi(2))
        };
        self.ring.viscosity() * self.element_length() * rate
    }
}
