//! Push elements as an Eulerian chain on finite volumes that move with the mesh.
//!
//! The elements are on the ring: a point of the chain is at the ring's r, and the rocking edge (pitch line) is e inside
//! it. Pitch-line length per dξ: λ = |r'| − e κ_ref, so a closed loop without stretch has the length L − 2πe for every Θ.
//!
//! Generalised velocity: V, the absolute speed of the elements along the tangent t̂ at the pitch line, linear between
//! faces. With dots at fixed mesh point η:
//!
//! - flow through the mesh, pitch-line length per time: J = V − t̂·ṙ + e χ̇; in ξ: c = J/λ,
//! - velocity at the pitch line v_p = V t̂ + (n̂·ṙ) n̂, at the ring centre line v_e = V |r'|/λ t̂ + (n̂·ṙ) n̂: an
//!   element on an arc turns about its centre. Friction between ring and elements therefore acts on the ring in full,
//!   on V with the factor |r'|/λ, and exerts no moment on the arc.
//!
//! J is the same on both sides of a moving arc border although κ_ref jumps there, because χ̇ (the turning of the
//! elements with the mesh point) is continuous.
//!
//! Amount: N = ∫νλ dξ per cell, dN/dt = Φ_in − Φ_out, ν = N/ℓ, ℓ = ∫λ dξ. Φ is J ν of the cell upstream ([`flux`]).
//!
//! Push force Q = k_e (⟨ν−1⟩₊ + d_e H Dν/Dt) + d_f Dν/Dt + d_s ⟨Dν/Dt⟩ / (1 + gap/δ_f)³, H the derivative of ⟨·⟩₊.
//! Damping of the stack acts in contact only. Damping of the oil between the elements also acts across gaps: d_f in
//! both directions, d_s where gaps close, decreasing with the width of the gap. With ε = ν − 1,
//!
//! k_e⟨ε⟩₊ = k_e δ ln(1 + e^{ε/δ}) + (q/ln 2) ln(1 + e^{ε/δ_f}).
//!
//! Across a gap wider than the roughness only the film acts, with the force q at ε = 0. The play is measured at ε = 0,
//! where the stack has half its stiffness.
//!
//! The material rate is Dν/Dt = −(ν/ℓ)(V_R − V_L − ∫κ̂ n̂·ṙ dξ), and Q is conjugate to this shortening. The ring is thus
//! loaded by Qκ̂ outward and the chain by −∂Q/∂ξ, and the power of Q is balanced.
//!
//! A ring in space has two normals, n̂ and b̂. Every equation with n̂ holds for both, and their contributions add up.
//!
//! Inertia: mass m_e νλ per dξ moves with v_p; a·t̂ = V̇ + cV' − Ω n̂·ṙ, a·n̂ = n̂·r̈ + c n̂·(r')˙ + Ω(V − t̂·ṙ), where
//! Ω = n̂·((r')˙ + c r'')/|r'| is the turning rate of t̂ along an element's path.

#![forbid(unsafe_code)]

use crate::ring::kinematics::{RingPoint, RingVariation};
use crate::scalar::{Real, Tangent, smooth_plus, soft_plus_energy};
use nalgebra::SVector;

/// Parameters of the push elements.
#[derive(Clone, Debug, PartialEq)]
pub struct PushElements {
    /// Distance e of the rocking edge (pitch line) inside the ring centre line, m.
    pub pitch_offset: f64,
    /// End play: pitch-line length of the unstretched ring less the stacked thickness of all elements, m.
    pub play: f64,
    /// Mass m_e of the elements alone per pitch-line length, kg/m.
    pub mass_per_length: f64,
    /// Push stiffness k_e (force per strain of the stack), N.
    pub push_stiffness: f64,
    /// Damping time of the stack, acting in contact only, s.
    pub damping: f64,
    /// Roughness of the elements' faces, m: the distance over which neighbouring elements come into contact. Asperities of
    /// the faces touch first, and the force between them decays exponentially with the gap, over a distance comparable to
    /// the standard deviation of their heights (Greenwood and Williamson 1966), 0.1 to 0.5 µm for ground steel.
    pub roughness: f64,
    /// Thickness of an element, m: a gap is divided by it to give a strain of the stack.
    pub element_thickness: f64,
    /// Moment of inertia of an element about its rocking edge, kg·m²: I + m d², with I about the centre of mass, which is d
    /// from the edge. It determines the loss by elements that start and stop turning; 0: no such loss.
    pub element_inertia: f64,
    /// Force between elements at ε = 0 by effects of longer range than the roughness, N: oil, waviness and rocking of the
    /// faces. Without it no waves run against the flow in a stack with gaps, and the play gathers where elements enter a
    /// pulley (`docs/sensitivity.md`).
    pub film_force: f64,
    /// Decay length of that force, m.
    pub film_thickness: f64,
    /// Force between elements per rate of strain by the oil between them, across gaps too, N·s. It spreads the braking of
    /// closing elements over several cells; at the rates of a steady state its power is negligible.
    pub film_damping: f64,
    /// Force per rate of strain by oil that is squeezed out of a closing gap, at zero gap, N·s. It decreases with the
    /// cube of the gap (Reynolds), over `film_thickness`.
    pub squeeze_damping: f64,
}

impl PushElements {
    /// The film with a share from 0 to 1 of a stiffer one of 100 N and 3 N·s, whose force closes the play: elements do not collide,
    /// and the laws are easier to solve.
    #[must_use]
    pub(crate) fn with_stiff_film(&self, share: f64) -> Self {
        let stiffer = |own: f64, stiff: f64| own + share * (stiff - own).max(0.0);
        Self {
            film_force: stiffer(self.film_force, 100.0),
            film_damping: stiffer(self.film_damping, 3.0),
            ..self.clone()
        }
    }

    /// Strain of the stack over which neighbouring elements come into contact.
    #[must_use]
    pub fn contact_strain(&self) -> f64 {
        self.roughness / self.element_thickness
    }

    /// Strain of the stack that corresponds to the decay length of the film's force.
    fn film_strain(&self) -> f64 {
        self.film_thickness / self.element_thickness
    }

    /// Contribution of the film to the push stiffness, N: its force at ε = 0 is `film_force`.
    fn film_stiffness(&self) -> f64 {
        self.film_force / (self.film_strain() * std::f64::consts::LN_2)
    }
}

/// Smoothing width of the upwind switch, m/s: far below any relevant creep speed.
pub const UPWIND_SMOOTHING: f64 = 1.0e-6;

/// Smoothing width of the transition from opening to closing, m/s, as a difference of V across a cell. Where gaps close
/// the difference is some 0.1 m/s.
pub const CLOSING_SMOOTHING: f64 = 1.0e-2;

/// Smoothing width of the squeezing law, as a rate of strain, 1/s. Where gaps open, the tension of the oil is limited
/// to that of half this rate, by cavitation.
pub const SQUEEZE_SMOOTHING: f64 = 0.3;

/// Flow below which [`collision_force`] is constant, m/s. At standstill it represents squeezed oil in place of collisions.
pub const SQUEEZE_SPEED: f64 = 1.0;

/// Flow far above which separating elements are independent of their neighbours' speed, m/s.
pub const FREE_FLOW: f64 = 3.0;

/// The chain at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct ChainPoint<T: Real, const D: usize = 2> {
    /// λ, pitch-line length per dξ.
    pub lambda: T,
    /// 1/λ.
    pub inverse_lambda: T,
    /// |r'|/λ: length along the ring centre line per length along the pitch line.
    pub lead: T,
    /// V, m/s.
    pub speed: T,
    /// J, flow through the mesh, m/s.
    pub flow: T,
    /// c = J/λ, m/s.
    pub c: T,
    /// Normals, D − 1 of them.
    pub normals: [SVector<T, D>; 2],
    /// n̂·ṙ, m/s.
    pub normal_speed: [T; 2],
    /// True curvature κ̂ = n̂·r''/|r'| of the ring per dξ, 1/m.
    pub curvature: [T; 2],
}

impl<T: Real, const D: usize> ChainPoint<T, D> {
    /// The chain on a ring point, at the element speed `speed`.
    #[inline(always)]
    pub fn new(pitch_offset: f64, point: &RingPoint<T, D>, theta_dot: T, speed: T) -> Self {
        let reference = &point.reference;
        let lambda = point.stretch - reference.kappa * pitch_offset;
        let normals = point.normals();
        let (mut normal_speed, mut curvature) = ([T::zero(); 2], [T::zero(); 2]);
        for k in 0..D - 1 {
            normal_speed[k] = normals[k].dot(&point.r_dot);
            curvature[k] = normals[k].dot(&point.bend) * point.inverse_stretch;
        }
        let flow = speed - point.t.dot(&point.r_dot) + reference.chi_theta * theta_dot * pitch_offset;
        let inverse_lambda = lambda.recip();
        Self {
            lambda,
            inverse_lambda,
            lead: point.stretch * inverse_lambda,
            speed,
            flow,
            c: flow * inverse_lambda,
            normals,
            normal_speed,
            curvature,
        }
    }

    /// v_p, velocity at the pitch line, m/s.
    #[inline(always)]
    pub fn pitch_velocity(&self, point: &RingPoint<T, D>) -> SVector<T, D> {
        self.velocity(point, self.speed)
    }

    /// v_e, velocity at the ring centre line, m/s.
    #[inline(always)]
    pub fn ring_line_velocity(&self, point: &RingPoint<T, D>) -> SVector<T, D> {
        self.velocity(point, self.ring_line_speed())
    }

    /// v_e·t̂, m/s.
    #[inline(always)]
    pub fn ring_line_speed(&self) -> T {
        self.speed * self.lead
    }

    /// The velocity with the component `along` along t̂ and the ring's normal components, m/s.
    #[inline(always)]
    fn velocity(&self, point: &RingPoint<T, D>, along: T) -> SVector<T, D> {
        let mut velocity = point.t * along;
        for k in 0..D - 1 {
            velocity += self.normals[k] * self.normal_speed[k];
        }
        velocity
    }

    /// a·t̂ of an element and a along the normals; `speed_dot` = V̇, `speed_gradient` = ∂V/∂ξ. m/s².
    #[inline(always)]
    pub fn acceleration(&self, point: &RingPoint<T, D>, speed_dot: T, speed_gradient: T) -> (T, [T; 2]) {
        let c = self.c;
        let mut along = speed_dot + c * speed_gradient;
        let mut across = [T::zero(); 2];
        for (k, across) in across.iter_mut().enumerate().take(D - 1) {
            let normal = &self.normals[k];
            let slope_rate = normal.dot(&point.slope_dot);
            let omega = slope_rate * point.inverse_stretch + c * self.curvature[k];
            along -= omega * self.normal_speed[k];
            *across = normal.dot(&point.r_ddot) + c * slope_rate + omega * (self.speed - point.t.dot(&point.r_dot));
        }
        (along, across)
    }
}

/// Derivatives of a [`ChainPoint`] in a direction that does not change the reference curve.
#[derive(Clone, Copy, Debug)]
pub struct ChainVariation<T: Real> {
    /// δV.
    pub speed: T,
    /// δ(t̂·ṙ).
    pub along: T,
    /// δJ.
    pub flow: T,
    /// δ(|r'|/λ).
    pub lead: T,
    /// δc.
    pub c: T,
    /// δ(n̂·ṙ).
    pub normal_speed: [T; 2],
    /// δκ̂.
    pub curvature: [T; 2],
}

impl<T: Real> ChainVariation<T> {
    /// No variation.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = T::zero();
        Self {
            speed: zero,
            along: zero,
            flow: zero,
            lead: zero,
            c: zero,
            normal_speed: [zero; 2],
            curvature: [zero; 2],
        }
    }

    /// The variation where V alone varies, by `speed`.
    #[inline(always)]
    pub fn of_speed<const D: usize>(chain: &ChainPoint<T, D>, speed: T) -> Self {
        Self {
            speed,
            flow: speed,
            c: speed * chain.inverse_lambda,
            ..Self::none()
        }
    }
}

/// Terms of [`ChainPoint::acceleration`] used by its variation.
#[derive(Clone, Copy, Debug)]
pub struct AccelerationTerms<T: Real> {
    /// t̂·ṙ, m/s.
    pub along: T,
    /// n̂·(r')˙, 1/s.
    pub slope_rate: [T; 2],
    /// Ω, rad/s.
    pub omega: [T; 2],
}

impl<T: Real, const D: usize> ChainPoint<T, D> {
    /// Terms of the acceleration used by its variation.
    #[inline(always)]
    pub fn acceleration_terms(&self, point: &RingPoint<T, D>) -> AccelerationTerms<T> {
        let (mut slope_rate, mut omega) = ([T::zero(); 2], [T::zero(); 2]);
        for k in 0..D - 1 {
            slope_rate[k] = self.normals[k].dot(&point.slope_dot);
            omega[k] = slope_rate[k] * point.inverse_stretch + self.c * self.curvature[k];
        }
        AccelerationTerms {
            along: point.t.dot(&point.r_dot),
            slope_rate,
            omega,
        }
    }

    /// The variation of the point where the ring varies by `by` and V by `speed`. λ varies as |r'| does.
    #[inline(always)]
    pub fn vary(&self, point: &RingPoint<T, D>, by: &RingVariation<T, D>, speed: T) -> ChainVariation<T> {
        let (mut normal_speed, mut curvature) = ([T::zero(); 2], [T::zero(); 2]);
        for k in 0..D - 1 {
            let (normal, varied) = (&self.normals[k], &by.normals[k]);
            normal_speed[k] = varied.dot(&point.r_dot) + normal.dot(&by.r_dot);
            curvature[k] = (varied.dot(&point.bend) + normal.dot(&by.bend) - self.curvature[k] * by.stretch)
                * point.inverse_stretch;
        }
        let along = by.t.dot(&point.r_dot) + point.t.dot(&by.r_dot);
        let flow = speed - along;
        ChainVariation {
            speed,
            along,
            flow,
            lead: by.stretch * (-self.lead + 1.0) * self.inverse_lambda,
            c: (flow - self.c * by.stretch) * self.inverse_lambda,
            normal_speed,
            curvature,
        }
    }

    /// Variation of [`ChainPoint::acceleration`]; `speed_dot` and `gradient` are the variations of V̇ and ∂V/∂ξ.
    #[inline(always)]
    pub fn vary_acceleration(
        &self,
        point: &RingPoint<T, D>,
        terms: &AccelerationTerms<T>,
        (by, chain): (&RingVariation<T, D>, &ChainVariation<T>),
        speed_dot: T,
        [speed_gradient, gradient]: [T; 2],
    ) -> (T, [T; 2]) {
        let c = self.c;
        let mut along = speed_dot + chain.c * speed_gradient + c * gradient;
        let mut across = [T::zero(); 2];
        for (k, across) in across.iter_mut().enumerate().take(D - 1) {
            let (normal, varied) = (&self.normals[k], &by.normals[k]);
            let (slope_rate, omega) = (terms.slope_rate[k], terms.omega[k]);
            let slope_rate_by = varied.dot(&point.slope_dot) + normal.dot(&by.slope_dot);
            let omega_by = (slope_rate_by - slope_rate * point.inverse_stretch * by.stretch) * point.inverse_stretch
                + chain.c * self.curvature[k]
                + c * chain.curvature[k];
            along -= omega_by * self.normal_speed[k] + omega * chain.normal_speed[k];
            *across = varied.dot(&point.r_ddot)
                + normal.dot(&by.r_ddot)
                + chain.c * slope_rate
                + c * slope_rate_by
                + omega_by * (self.speed - terms.along)
                + omega * (chain.speed - chain.along);
        }
        (along, across)
    }
}

/// Forces in the stack of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Stack<T> {
    /// Push force.
    pub push: Push<T>,
    /// [`collision_force`], N.
    pub collision: T,
    /// [`lag`], m/s.
    pub lag: T,
}

impl<T: Real> Stack<T> {
    /// No forces.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = T::zero();
        Self {
            push: Push {
                force: zero,
                viscous: zero,
                contact: zero,
            },
            collision: zero,
            lag: zero,
        }
    }

    /// Forces of a cell of density `nu`, material rate `nu_rate`, 1/s, mean flow `flow`, m/s, and `difference` of V across
    /// it, m/s.
    #[inline(always)]
    pub fn new(belt: &PushElements, [nu, nu_rate, flow, difference]: [T; 4]) -> Self {
        let push = push_force(belt, nu, nu_rate);
        let upwinding = upwinding(flow, difference);
        Self {
            push,
            collision: collision_force(belt, nu, flow, difference, upwinding),
            lag: lag(difference, push.contact, upwinding),
        }
    }
}

/// Push force of a cell, and its damping part.
#[derive(Clone, Copy, Debug)]
pub struct Push<T> {
    /// Q, N.
    pub force: T,
    /// The damping part of Q, N.
    pub viscous: T,
    /// H, from 0 (gaps) to 1 (contact).
    pub contact: T,
}

/// Push force from element density `nu` and its material rate `nu_rate`, 1/s.
#[inline(always)]
pub fn push_force<T: Real>(belt: &PushElements, nu: T, nu_rate: T) -> Push<T> {
    let touch = Touch::new(belt, nu);
    let [strain, contact] = touch.stack(belt);
    let (squeeze, squeezing) = (touch.squeeze(belt), squeezing(nu_rate));
    let viscous = (contact * (belt.push_stiffness * belt.damping) + belt.film_damping) * nu_rate + squeezing * squeeze;
    Push {
        force: strain * belt.push_stiffness + viscous,
        viscous,
        contact,
    }
}

/// Contact of neighbouring elements.
#[derive(Clone, Copy, Debug)]
struct Touch<T> {
    /// ε = ν − 1.
    strain: T,
    /// ⟨ε⟩₊ over the roughness, and its derivative.
    near: [T; 2],
}

impl<T: Real> Touch<T> {
    #[inline(always)]
    fn new(belt: &PushElements, nu: T) -> Self {
        let strain = nu - 1.0;
        let [near, slope, _] = strain.soft_plus(belt.contact_strain());
        Self {
            strain,
            near: [near, slope],
        }
    }

    /// ⟨ν−1⟩₊, the film included, and its derivative H.
    #[inline(always)]
    fn stack(&self, belt: &PushElements) -> [T; 2] {
        let far = self.strain.soft_plus(belt.film_strain());
        let share = belt.film_stiffness() / belt.push_stiffness;
        std::array::from_fn(|k| self.near[k] + far[k] * share)
    }

    /// Force per rate of strain of squeezed oil, d_s/(1 + gap/δ_f)³, N·s.
    ///
    /// Between flat faces it decreases with the cube of their distance (Reynolds): oil of 10 mPa·s that fills a gap of
    /// 4.5 µm between faces of 8 by 24 mm has 2 kN·s. Zero gap stands for the distance of two rough faces in contact.
    #[inline(always)]
    fn squeeze(&self, belt: &PushElements) -> T {
        let [closed, _] = self.near;
        let per_gap = belt.film_strain().recip();
        let share = ((closed - self.strain) * per_gap + 1.0).recip();
        share * share * share * belt.squeeze_damping
    }
}

/// Rate of strain that squeezes oil, 1/s: `nu_rate` where gaps close, small where they open, zero at rest. It has the
/// sign of `nu_rate`, so the force dissipates.
#[inline(always)]
fn squeezing<T: Real>(nu_rate: T) -> T {
    let [plus, ..] = nu_rate.smooth_plus(SQUEEZE_SMOOTHING);
    plus - 0.5 * SQUEEZE_SMOOTHING
}

/// Smoothed switch, 0 where gaps open and 1 where they close; `difference` is that of V across the cell, m/s.
#[inline(always)]
fn closing<T: Real>(difference: T) -> T {
    let [_, closing, _] = (-difference).smooth_plus(CLOSING_SMOOTHING);
    closing
}

/// Weight of upwind convection, from 0 to 1: 1 where gaps close and near standstill, 0 where they open in a fast flow.
#[inline(always)]
pub fn upwinding<T: Real>(flow: T, difference: T) -> T {
    let closing = closing(difference);
    let slow = (flow * flow * FREE_FLOW.powi(-2) + 1.0).recip();
    closing + (-closing + 1.0) * slow
}

/// Force that opposes a difference of V across a cell with closing gaps, N: ½ m_e ν |J| ΔV, with the weight of
/// [`upwinding`].
///
/// Free elements in gaps keep their speed until a faster one collides with the one ahead of it. Central differences of
/// J V′ alone have a sawtooth of V there; with this force the convection of V is upwind. Its power, ½ m_e ν |J| ΔV², is
/// that of inelastic collisions; it vanishes with the square of the cell length in a smooth field. Separating elements
/// do not touch, so no force opposes them.
#[inline(always)]
pub fn collision_force<T: Real>(belt: &PushElements, nu: T, flow: T, difference: T, upwinding: T) -> T {
    let size = (flow * flow + SQUEEZE_SPEED * SQUEEZE_SPEED).sqrt();
    nu * size * difference * upwinding * (0.5 * belt.mass_per_length)
}

/// Elastic energy of the stack per pitch-line length at density `nu`, J/m: N ε(ν) with ε' = k_e⟨ν−1⟩₊/ν².
#[inline(always)]
#[must_use]
pub fn energy_density<T: Real>(belt: &PushElements, nu: T) -> T {
    // 1/ν² is expanded about contact: ν − 1 is below 1e-2 wherever force acts.
    let strain = nu - 1.0;
    soft_plus_energy(strain, belt.contact_strain()) * belt.push_stiffness
        + soft_plus_energy(strain, belt.film_strain()) * belt.film_stiffness()
}

/// The quantities of a cell that determine the flux of elements.
#[derive(Clone, Copy, Debug, Default)]
pub struct Transport<T> {
    /// J at its left face, m/s.
    pub flow: T,
    /// ν.
    pub density: T,
    /// [`lag`], m/s: half the difference of V across the cell, where elements separate freely.
    pub lag: T,
}

impl<T> Transport<T> {
    /// Applies `f` to each quantity.
    pub fn map<U>(self, f: impl Fn(T) -> U) -> Transport<U> {
        Transport {
            flow: f(self.flow),
            density: f(self.density),
            lag: f(self.lag),
        }
    }

    /// The quantities.
    pub fn each(&self) -> [&T; 3] {
        [&self.flow, &self.density, &self.lag]
    }

    /// Mutable references to the quantities.
    pub fn each_mut(&mut self) -> [&mut T; 3] {
        [&mut self.flow, &mut self.density, &mut self.lag]
    }
}

impl Transport<f64> {
    /// Derivatives in N directions of a function with these derivatives with respect to the quantities; `slopes` are the
    /// derivatives of the quantities.
    #[inline(always)]
    #[must_use]
    pub fn along<const N: usize>(&self, slopes: &Transport<[f64; N]>) -> [f64; N] {
        let slope = |k: usize| self.flow * slopes.flow[k] + self.density * slopes.density[k] + self.lag * slopes.lag[k];
        std::array::from_fn(slope)
    }
}

/// Difference of J between the right face of a cell and its middle, m/s, and between its middle and its left face, where
/// elements separate freely; zero elsewhere.
///
/// In a steady state J ν is uniform around the loop. With J at the downstream face, ν is that of a point half a cell
/// upstream of the middle. This error is significant where elements leave a pulley: the push force falls to a few newtons
/// within 3 mm, the flow becomes as fast as waves in the stack, and the remaining force determines the gaps in the strand.
/// With J of the middle, ν is second-order accurate there. In contact, and with the weight of [`upwinding`], J of the face
/// is used, because J of the middle does not respond to a sawtooth of V.
#[inline(always)]
pub fn lag<T: Real>(difference: T, contact: T, upwinding: T) -> T {
    (-contact + 1.0) * (-upwinding + 1.0) * difference * 0.5
}

/// Amount per time through a face: J ν of the cell upstream.
#[inline(always)]
pub fn flux<T: Real>(before: &Transport<T>, after: &Transport<T>) -> T {
    let (forward, _) = smooth_plus(after.flow - before.lag, UPWIND_SMOOTHING);
    let (backward, _) = smooth_plus(-after.flow - after.lag, UPWIND_SMOOTHING);
    forward * before.density - backward * after.density
}

/// Derivatives of [`flux`] with respect to the quantities of both cells.
#[must_use]
pub fn flux_slopes<T: Real>(before: &Transport<T>, after: &Transport<T>) -> [Transport<T>; 2]
where
    Tangent<6, T>: Real,
{
    let seeded = |cell: &Transport<T>, first: usize| -> Transport<Tangent<6, T>> {
        Transport {
            flow: Tangent::seed(cell.flow, first, 1.0),
            density: Tangent::seed(cell.density, first + 1, 1.0),
            lag: Tangent::seed(cell.lag, first + 2, 1.0),
        }
    };
    let slopes = flux(&seeded(before, 0), &seeded(after, 3)).eps;
    [0, 3].map(|first| Transport {
        flow: slopes[first],
        density: slopes[first + 1],
        lag: slopes[first + 2],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    #[test]
    fn flux_slopes_match_forward_differentiation() {
        for flow in [-3.0, -1e-6, 0.0, 2e-6, 3.0] {
            let cells = [[0.4, 0.98, 0.03], [flow, 1.01, -0.02]];
            let [before, after] = cells.map(|[flow, density, lag]| Transport { flow, density, lag });
            let slopes = flux_slopes(&before, &after).map(|s| [s.flow, s.density, s.lag]);
            for k in 0..6 {
                let seeded = |cell: usize| {
                    let [flow, density, lag] =
                        std::array::from_fn(|i| Dual64::new(cells[cell][i], f64::from(u8::from(3 * cell + i == k))));
                    Transport { flow, density, lag }
                };
                let slope = flux(&seeded(0), &seeded(1)).eps;
                assert!(
                    (slope - slopes[k / 3][k % 3]).abs() < 1e-12,
                    "flow {flow}, argument {k}"
                );
            }
        }
    }
}
