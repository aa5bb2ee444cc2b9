//! `ALE` and `ALE0` as a ring model, with the kinematics and the beam law of the variator.
//!
//! r = R(ξ, Θ) + Σ A_i S_i q_fi (10). A_i is the identity, or [t, n]_ref, see
//! [`OverlayDirections`]. s and Θ duplicate motions of q_f, so node 0 is locked to the reference
//! curve: along the curve because of s, across it because of Θ. A curve without a ratio has the
//! first lock only; a second would constrain the free ring. `ALE0` locks every node, so the ring
//! has s and Θ alone.
//!
//! In space (D = 3) nodes also deflect along z, without locks: s and Θ do not move along z.

use super::Ring;
use super::ale::{self, RingDensity};
use super::kinematics::{
    ElementLoad, ElementMotion, LineLoad, Motion, Node, ReferenceMotion, RingPoint, embed, in_plane,
};
use super::mesh::{self, RingMesh, Station};
use super::model::{Coordinates, DIRECTIONS, ElementPlace, Energy, RingFormulation, RingShape};
use super::particle::{Particle, ParticleLoad, load_of_particle};
use super::rotated::{RotatedElement, rotated_load, rotated_point};
use crate::reference_curve::{CurvePlace, Jet, ReferenceCurve, ReferencePoint};
use crate::scalar::Real;
use nalgebra::{SVector, Vector2};

/// Implemented for D components and N = 4D + 2, the number of unknowns of an element: deflection
/// and slope of two nodes, s and Θ.
pub trait UnknownCount<const N: usize> {}
/// A deflection with D components.
#[derive(Debug)]
pub enum Deflection<const D: usize> {}
impl UnknownCount<DIRECTIONS> for Deflection<2> {}
impl UnknownCount<14> for Deflection<3> {}

/// Form in which the inertia is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inertia {
    /// Conserves energy and drift momentum of the discrete ring exactly
    /// (`add_conservative_inertia`).
    Conservative,
    /// The force of inertia at each point (`ale::add_inertia`).
    Pointwise,
}

/// Directions of the overlay: the matrices A_i of (10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OverlayDirections {
    /// A_i = identity: x and y. The paper's choice for the variator, and the default.
    #[default]
    Fixed,
    /// A_i = [t, n]_ref: along the reference curve and inwards. The deflection rotates with the
    /// curve as Θ changes. Slopes of nodes are those of the deflection itself, resolved in t and n,
    /// so that the ring's tangent is continuous where an arc meets a strand and A_i' jumps.
    Reference,
}

/// A ring in the Eulerian view on a reference curve; its deflection has D components.
#[derive(Clone, Debug)]
pub struct AleRing<C, const D: usize = 2> {
    /// Parameters of the beam.
    pub ring: Ring,
    /// The reference curve of the overlay.
    pub curve: C,
    /// Division of the curve into elements.
    pub mesh: RingMesh,
    /// Form of the inertia; conservative unless changed.
    pub inertia: Inertia,
    /// Directions of the overlay; fixed unless changed.
    pub directions: OverlayDirections,
    flexible: bool,
}

/// Motion of an element and of the reference curve.
struct ElementState<T: Real, const D: usize> {
    /// Overlay: in x and y, or along t and n; in space along z too.
    element: ElementMotion<T, D>,
    reference: ReferenceMotion<T>,
    /// Ends of an element with [`OverlayDirections::Reference`].
    rotated: Option<RotatedElement<T>>,
}

impl<C: ReferenceCurve> AleRing<C> {
    /// A ring that deflects in the plane (`ALE`).
    #[must_use]
    pub fn flexible(ring: Ring, curve: C, mesh: RingMesh) -> Self {
        Self::new(ring, curve, mesh, true)
    }

    /// A ring that follows the reference curve, `q_f` = 0 (`ALE0`).
    #[must_use]
    pub fn rigid(ring: Ring, curve: C, mesh: RingMesh) -> Self {
        Self::new(ring, curve, mesh, false)
    }
}

impl<C: ReferenceCurve> AleRing<C, 3> {
    /// A ring that deflects in the plane and along z.
    #[must_use]
    pub fn spatial(ring: Ring, curve: C, mesh: RingMesh) -> Self {
        Self::new(ring, curve, mesh, true)
    }
}

impl<C: ReferenceCurve, const D: usize> AleRing<C, D> {
    /// Node unknowns.
    const BLOCK: usize = 2 * D;

    fn new(ring: Ring, curve: C, mesh: RingMesh, flexible: bool) -> Self {
        Self {
            ring,
            curve,
            mesh,
            inertia: Inertia::Conservative,
            directions: OverlayDirections::Fixed,
            flexible,
        }
    }

    fn parts<T: Real<Constant = f64>>(
        &self,
        frame: &C::Frame<T>,
        element: usize,
        motion: &[Motion<T>],
    ) -> ElementState<T, D> {
        let (drift, theta) = (&motion[2 * Self::BLOCK], motion[2 * Self::BLOCK + 1]);
        let reference = ReferenceMotion {
            theta,
            s_dot: drift.rate,
            s_ddot: drift.acceleration,
        };
        let place = &self.mesh.elements[element];
        let length = self.element_length(frame, element);
        let node = |i: usize, of: fn(&Motion<T>) -> T| {
            let unknown = |k: usize| if self.flexible { of(&motion[k]) } else { T::zero() };
            Node {
                a: SVector::from_fn(|k, _| unknown(Self::BLOCK * i + 2 * k)),
                b: SVector::from_fn(|k, _| unknown(Self::BLOCK * i + 2 * k + 1)),
            }
        };
        let mut nodes = [0, 1].map(|i| Motion {
            value: node(i, |m| m.value),
            rate: node(i, |m| m.rate),
            acceleration: node(i, |m| m.acceleration),
        });
        let rotated = match self.directions {
            OverlayDirections::Fixed => None,
            OverlayDirections::Reference => {
                let curvature = [place.start, place.start + place.length]
                    .map(|fraction| C::tangent_angle(frame, place.segment, fraction).kappa);
                Some(RotatedElement::new(curvature, &reference.theta, &mut nodes))
            }
        };
        ElementState {
            element: ElementMotion::new(length, &reference.theta, &nodes),
            reference,
            rotated,
        }
    }

    fn element_length<T: Real<Constant = f64>>(&self, frame: &C::Frame<T>, element: usize) -> Jet<T> {
        let element = &self.mesh.elements[element];
        Jet::constant(0.0).plus_scaled(C::segment_length(frame, element.segment), element.length)
    }

    fn reference_point<T: Real<Constant = f64>>(
        &self,
        frame: &C::Frame<T>,
        element: usize,
        station: &Station,
    ) -> ReferencePoint<T> {
        C::point(frame, self.mesh.elements[element].segment, station.fraction)
    }

    fn point<T: Real<Constant = f64>>(
        &self,
        frame: &C::Frame<T>,
        element: usize,
        station: &Station,
        parts: &ElementState<T, D>,
    ) -> RingPoint<T, D> {
        let reference = self.reference_point(frame, element, station);
        if parts.rotated.is_none() {
            return RingPoint::new(reference, &station.shape, &parts.element, &parts.reference);
        }
        let segment = self.mesh.elements[element].segment;
        let angle = C::tangent_angle(frame, segment, station.fraction);
        rotated_point(reference, &angle, &station.shape, &parts.element, &parts.reference)
    }

    /// γ' in the damping: its mean over an element, 1/m. Zero without damping.
    fn strain_gradient<T: Real<Constant = f64>>(
        &self,
        frame: &C::Frame<T>,
        element: usize,
        parts: &ElementState<T, D>,
    ) -> T {
        if self.ring.damping == 0.0 {
            return T::zero();
        }
        // The weights of an element sum to one.
        self.mesh.stations[element].iter().fold(T::zero(), |sum, station| {
            sum + self.point(frame, element, station, parts).strain_gradient * station.weight
        })
    }

    /// Adds a load over the length `weight`, m, on the ring at a station.
    fn add<T: Real<Constant = f64>>(
        station: &Station,
        parts: &ElementState<T, D>,
        point: &RingPoint<T, D>,
        load: &LineLoad<T, D>,
        weight: T,
        sum: &mut ElementLoad<T, D>,
    ) {
        if parts.rotated.is_none() {
            sum.add(load, point, &station.shape, &parts.element, weight);
        } else {
            rotated_load(load, point, &station.shape, &parts.element, weight, sum);
        }
    }

    fn rows<T: Real<Constant = f64>, const N: usize>(
        &self,
        sum: &ElementLoad<T, D>,
        parts: &ElementState<T, D>,
    ) -> [T; N] {
        let ([mut left, mut right], mut theta) = sum.nodes(&parts.element);
        if let Some(rotated) = &parts.rotated {
            rotated.nodes([&mut left, &mut right], &mut theta);
        }
        let nodes = [left, right];
        std::array::from_fn(|k| match k.checked_sub(2 * Self::BLOCK) {
            None if !self.flexible => T::zero(),
            None => {
                let (node, k) = (&nodes[k / Self::BLOCK], k % Self::BLOCK);
                if k.is_multiple_of(2) {
                    node.a[k / 2]
                } else {
                    node.b[k / 2]
                }
            }
            Some(0) => sum.s,
            Some(_) => theta,
        })
    }

    /// The ring at the mesh point that is at the local coordinate x of an element.
    #[must_use]
    pub fn mesh_point(
        &self,
        frame: &C::Frame<f64>,
        element: usize,
        x: f64,
        motion: &[Motion<f64>],
    ) -> RingPoint<f64, D> {
        let station = self.mesh.elements[element].station(x, 0.0, 0.0);
        self.point(frame, element, &station, &self.parts(frame, element, motion))
    }

    fn integrate(
        &self,
        frame: &C::Frame<f64>,
        element: usize,
        motion: &[Motion<f64>],
        mut f: impl FnMut(RingDensity<f64>, f64),
    ) {
        let parts = self.parts(frame, element, motion);
        let strain_gradient = self.strain_gradient(frame, element, &parts);
        for station in &self.mesh.stations[element] {
            let mut point = self.point(frame, element, station, &parts);
            point.strain_gradient = strain_gradient;
            f(
                ale::density(&self.ring, &point),
                parts.element.length.v * station.weight,
            );
        }
    }
}

impl<C: ReferenceCurve + std::fmt::Debug, const D: usize, const N: usize> RingFormulation<D, N>
    for AleRing<C, D>
where
    Deflection<D>: UnknownCount<N>,
{
    const BLOCK: usize = Self::BLOCK;
    const LAGRANGIAN: bool = false;

    type Frame<T: Real> = C::Frame<T>;

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
        self.mesh.elements.len()
    }

    fn quadrature(&self) -> &'static [(f64, f64)] {
        self.mesh.quadrature
    }

    fn is_length(&self, k: usize) -> bool {
        k.is_multiple_of(2)
    }

    fn held(&self) -> Vec<usize> {
        let blocks = self.elements() * Self::BLOCK;
        let ratio = self.curve.has_ratio();
        // At ξ = 0, the leftmost point, y is along the curve and x across it.
        let (along, across) = match self.directions {
            OverlayDirections::Fixed => (2, 0),
            OverlayDirections::Reference => (0, 2),
        };
        let mut held = match (self.flexible, ratio) {
            (false, _) => (0..blocks).collect(),
            (true, true) => vec![along, across],
            (true, false) => vec![along],
        };
        if !ratio {
            held.push(blocks + 1);
        }
        held
    }

    fn frame<T: Real>(&self, theta: T) -> C::Frame<T> {
        self.curve.frame(theta)
    }

    fn locate(&self, frame: &C::Frame<f64>, _s: f64, xi: f64) -> ElementPlace {
        let CurvePlace { segment, fraction } = self.curve.locate(frame, xi);
        let (element, along) = mesh::find(&self.mesh.elements, segment, fraction);
        ElementPlace {
            element,
            x: 2.0 * along - 1.0,
        }
    }

    fn place_on(&self, shape: RingShape<'_, D>, q: &mut [f64]) {
        let frame = self.curve.frame(q[self.elements() * Self::BLOCK + 1]);
        for (block, element) in q.chunks_exact_mut(Self::BLOCK).zip(&self.mesh.elements) {
            let point = C::point::<f64>(&frame, element.segment, element.start);
            let [r, slope] = shape(point.xi.v);
            let (mut a, mut b) = (r - embed(point.r), slope - embed(point.t));
            if self.directions == OverlayDirections::Reference {
                for v in [&mut a, &mut b] {
                    let planar: Vector2<f64> = in_plane(v);
                    (v[0], v[1]) = (planar.dot(&point.t), planar.dot(&point.n));
                }
            }
            for k in 0..D {
                (block[2 * k], block[2 * k + 1]) = (a[k], b[k]);
            }
        }
    }

    fn place_on_curve(&self, q: &mut [f64]) {
        q[..self.elements() * Self::BLOCK].fill(0.0);
    }

    fn particle<T: Real<Constant = f64>>(
        &self,
        frame: &C::Frame<T>,
        element: usize,
        x: f64,
        motion: &Coordinates<T, N>,
    ) -> Particle<T, D> {
        let station = self.mesh.elements[element].station(x, 0.0, 0.0);
        let parts = self.parts(frame, element, motion);
        let point = self.point(frame, element, &station, &parts);
        Particle::from(&point)
    }

    fn half_length<T: Real<Constant = f64>>(&self, frame: &C::Frame<T>, element: usize) -> T {
        self.element_length(frame, element).v * 0.5
    }

    fn project<T: Real<Constant = f64>>(
        &self,
        frame: &C::Frame<T>,
        element: usize,
        x: f64,
        motion: &Coordinates<T, N>,
        load: &ParticleLoad<T, D>,
    ) -> [T; N] {
        let station = self.mesh.elements[element].station(x, 0.0, 0.0);
        let parts = self.parts(frame, element, motion);
        let point = self.point(frame, element, &station, &parts);
        let mut sum = ElementLoad::zero();
        Self::add(
            &station,
            &parts,
            &point,
            &load_of_particle(load, &point),
            T::one(),
            &mut sum,
        );
        self.rows(&sum, &parts)
    }

    fn balance<T: Real<Constant = f64>>(
        &self,
        frame: &C::Frame<T>,
        element: usize,
        motion: &Coordinates<T, N>,
    ) -> [T; N] {
        let parts = self.parts(frame, element, motion);
        let length = parts.element.length;
        let dilation = length.d / length.v;
        let strain_gradient = self.strain_gradient(frame, element, &parts);
        let mut sum = ElementLoad::zero();
        for station in &self.mesh.stations[element] {
            let mut point = self.point(frame, element, station, &parts);
            point.strain_gradient = strain_gradient;
            let mut load = LineLoad::zero();
            match self.inertia {
                Inertia::Pointwise => ale::add_inertia(&self.ring, &point, &mut load),
                Inertia::Conservative => {
                    let rate = parts.reference.theta.rate;
                    add_conservative_inertia(&self.ring, &point, dilation, rate, &mut load);
                }
            }
            ale::add_elasticity(&self.ring, &point, dilation, &mut load);
            Self::add(station, &parts, &point, &load, length.v * station.weight, &mut sum);
        }
        self.rows(&sum, &parts)
    }

    fn energy(&self, frame: &C::Frame<f64>, element: usize, motion: &Coordinates<f64, N>) -> Energy {
        let mut sum = Energy::default();
        self.integrate(frame, element, motion, |density, weight| {
            sum += Energy {
                kinetic: weight * density.kinetic,
                membrane: weight * density.membrane,
                bending: weight * density.bending,
            };
        });
        sum
    }

    fn dissipation(&self, frame: &C::Frame<f64>, element: usize, motion: &Coordinates<f64, N>) -> f64 {
        let mut sum = 0.0;
        self.integrate(frame, element, motion, |density, weight| {
            sum += weight * density.viscous
        });
        sum
    }
}

/// Adds inertia as d/dt ∂T/∂q̇ − ∂T/∂q with the transport w v integrated by parts onto δr':
///
/// m_r [(∂v/∂t|_η + λ v)·δv + v·(r')˙ δw − w v·δr' − ½ λ_Θ v² δΘ],
///
/// λ = λ_Θ Θ̇ the rate at which dξ grows; `dilation` = λ_Θ = (∂l/∂Θ)/l of the element, `theta_rate`
/// = Θ̇.
#[inline(always)]
fn add_conservative_inertia<T: Real, const D: usize>(
    ring: &Ring,
    point: &RingPoint<T, D>,
    dilation: T,
    theta_rate: T,
    load: &mut LineLoad<T, D>,
) {
    let mass = ring.mass_per_length;
    let velocity = point.velocity();
    let local = point.r_ddot + point.slope * point.w_dot + point.slope_dot * point.w;
    let force = (local + velocity * (dilation * theta_rate)) * T::from(mass);
    load.position += force;
    load.drift += force.dot(&point.slope) + velocity.dot(&point.slope_dot) * mass;
    load.slope -= velocity * (point.w * mass);
    load.theta -= velocity.dot(&velocity) * dilation * (0.5 * mass);
}
