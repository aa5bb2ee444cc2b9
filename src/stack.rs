//! Push elements as an Eulerian continuum on finite volumes that move with the mesh.
//!
//! `docs/theory.md`, section 4, has the equations, and `docs/decisions.md` the reasons. A point of
//! the stack is at the ring's r, and the pitch line (rocking edge) is e inside it:
//!
//! - λ = |r'| − e κ_ref: pitch-line length per dξ,
//! - V: absolute speed of the elements along t̂ at the pitch line, linear between faces,
//! - J = V − t̂·ṙ + e χ̇: flow through the mesh, pitch-line length per time; in ξ: c = J/λ. It is
//!   continuous at a moving arc border, where κ_ref jumps,
//! - v_p = V t̂ + (n̂·ṙ) n̂, v_e = V |r'|/λ t̂ + (n̂·ṙ) n̂: velocity at pitch line and ring centre
//!   line,
//! - N = ∫νλ dξ: content of a cell, dN/dt = Φ_in − Φ_out with the [`flux`] Φ; ν = N/ℓ, ℓ = ∫λ dξ,
//! - Dν/Dt = −(ν/ℓ)(V_R − V_L − ∫κ̂ n̂·ṙ dξ): Q is conjugate to this shortening,
//! - a·t̂ = V̇ + cV' − Ω n̂·ṙ, a·n̂ = n̂·r̈ + c n̂·(r')˙ + Ω(V − t̂·ṙ), Ω = n̂·((r')˙ + c
//!   r'')/|r'|: acceleration at the pitch line, of the mass m_e νλ per dξ.
//!
//! Push force with ε = ν − 1, D = Dν/Dt, the gap g and φ = 1/(1 + g/δ_f):
//!
//! Q = k_e (⟨ε⟩₊ + d_e H D) + S(F), F = c (2⟨D⟩ + (D − ⟨D⟩) φ²) + d_s D φ³.
//!
//! Every part of F has the sign of D, so it dissipates, and rises with D: Newton's method fails
//! with a law that falls. In space every equation with n̂ holds for n̂ and b̂, and their
//! contributions add up.

use crate::ring::kinematics::{RingPoint, RingVariation, WithRate};
use crate::scalar::{PositivePart, Real, soft_plus_energy};
use nalgebra::SVector;

/// Parameters of the push elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PushElements {
    /// Distance e of the rocking edge (pitch line) inside the ring centre line, m.
    pub pitch_offset: f64,
    /// End play: pitch-line length of the unstretched ring less the thickness of all elements, m.
    pub play: f64,
    /// Mass m_e of the elements alone per pitch-line length, kg/m.
    pub mass_per_length: f64,
    /// Push stiffness k_e (force per strain of the stack), N.
    pub push_stiffness: f64,
    /// Damping time of the stack, acting in contact only, s.
    pub damping: f64,
    /// Roughness of the elements' faces, m: the distance over which neighbouring elements come into
    /// contact (see `contact.rs`), comparable to the standard deviation of the heights of
    /// asperities, 0.1 to 0.5 µm for ground steel.
    pub roughness: f64,
    /// Thickness of an element, m.
    pub element_thickness: f64,
    /// Moment of inertia of an element about its rocking edge, kg·m².
    pub element_inertia: f64,
    /// Gap δ_f over which the force of the oil decreases, m.
    pub film_thickness: f64,
    /// Viscosity c of the oily stack, N·s.
    pub film_damping: f64,
    /// Force d_s of squeezed oil per rate of strain, at zero gap, N·s.
    pub squeeze_damping: f64,
    /// Suction F_c at which oil between two faces cavitates, N.
    pub suction: f64,
}

impl PushElements {
    /// Strain of the stack over which neighbouring elements come into contact.
    #[must_use]
    pub fn contact_strain(&self) -> f64 {
        self.roughness / self.element_thickness
    }
}

/// Smoothing width of the upwind switch, m/s: far below any relevant creep speed.
pub const UPWIND_SMOOTHING: f64 = 1.0e-6;

/// Smoothing width w of the transition from separating to approaching elements, 1/s: a tenth of the
/// rates where gaps open and close.
pub const RATE_SMOOTHING: f64 = 0.3;

/// The stack at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct StackPoint<T> {
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
    /// n̂·ṙ, m/s.
    pub normal_speed: [T; 2],
    /// True curvature κ̂ = n̂·r''/|r'| of the ring per dξ, 1/m.
    pub curvature: [T; 2],
}

impl<T: Real> StackPoint<T> {
    /// The stack on a ring point, at the element speed `speed`.
    #[inline(always)]
    pub fn new<const D: usize>(pitch_offset: f64, point: &RingPoint<T, D>, theta_dot: T, speed: T) -> Self {
        let reference = &point.reference;
        let lambda = point.stretch - reference.kappa * pitch_offset;
        let (mut normal_speed, mut curvature) = ([T::zero(); 2], [T::zero(); 2]);
        for k in 0..D - 1 {
            normal_speed[k] = point.normals[k].dot(&point.r_dot);
            curvature[k] = point.normals[k].dot(&point.bend) * point.inverse_stretch;
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
            normal_speed,
            curvature,
        }
    }

    /// v_e·t̂, m/s.
    #[inline(always)]
    pub fn ring_line_speed(&self) -> T {
        self.speed * self.lead
    }

    /// Velocity of an element with the component `along` along t̂, m/s: V for v_p,
    /// [`Self::ring_line_speed`] for v_e.
    #[inline(always)]
    pub fn velocity<const D: usize>(&self, point: &RingPoint<T, D>, along: T) -> SVector<T, D> {
        let mut velocity = point.t * along;
        for k in 0..D - 1 {
            velocity += point.normals[k] * self.normal_speed[k];
        }
        velocity
    }

    /// Acceleration of an element; `speed_dot` = V̇, `speed_gradient` = ∂V/∂ξ.
    #[inline(always)]
    pub fn acceleration<const D: usize>(
        &self,
        point: &RingPoint<T, D>,
        speed_dot: T,
        speed_gradient: T,
    ) -> Acceleration<T> {
        let c = self.c;
        let passing = self.speed - point.t.dot(&point.r_dot);
        let mut along = speed_dot + c * speed_gradient;
        let [mut across, mut slope_rate, mut omega] = [[T::zero(); 2]; 3];
        for k in 0..D - 1 {
            let normal = &point.normals[k];
            slope_rate[k] = normal.dot(&point.slope_dot);
            omega[k] = slope_rate[k] * point.inverse_stretch + c * self.curvature[k];
            along -= omega[k] * self.normal_speed[k];
            across[k] = normal.dot(&point.r_ddot) + c * slope_rate[k] + omega[k] * passing;
        }
        Acceleration {
            along,
            across,
            slope_rate,
            omega,
            passing,
        }
    }
}

/// Components along t̂ and along the normals.
#[derive(Clone, Copy, Debug)]
pub struct Components<T> {
    /// Along t̂.
    pub along: T,
    /// Along the normals.
    pub across: [T; 2],
}

/// Acceleration of an element, and what its variation needs.
#[derive(Clone, Copy, Debug)]
pub struct Acceleration<T> {
    /// a·t̂, m/s².
    pub along: T,
    /// a along the normals, m/s².
    pub across: [T; 2],
    /// n̂·(r')˙, 1/s.
    pub slope_rate: [T; 2],
    /// Ω, rad/s.
    pub omega: [T; 2],
    /// V − t̂·ṙ, m/s.
    pub passing: T,
}

/// Derivatives of a [`StackPoint`] in a direction that does not change the reference curve.
#[derive(Clone, Copy, Debug, Default)]
pub struct StackVariation<T> {
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

impl<T: Real + Default> StackVariation<T> {
    /// The variation where V alone varies, by `speed`.
    #[inline(always)]
    pub fn from_speed(stack: &StackPoint<T>, speed: T) -> Self {
        Self {
            speed,
            flow: speed,
            c: speed * stack.inverse_lambda,
            ..Self::default()
        }
    }
}

/// Variation of ring and stack at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct PointVariation<T: Real, const D: usize> {
    /// That of the ring.
    pub ring: RingVariation<T, D>,
    /// That of the stack.
    pub stack: StackVariation<T>,
}

impl<T: Real> StackPoint<T> {
    /// Variation where the ring varies by `by` and V by `speed`. λ varies as |r'| does.
    #[inline(always)]
    pub fn vary<const D: usize>(
        &self,
        point: &RingPoint<T, D>,
        by: &RingVariation<T, D>,
        speed: T,
    ) -> StackVariation<T> {
        let (mut normal_speed, mut curvature) = ([T::zero(); 2], [T::zero(); 2]);
        for k in 0..D - 1 {
            let (normal, varied) = (&point.normals[k], &by.normals[k]);
            normal_speed[k] = varied.dot(&point.r_dot) + normal.dot(&by.r_dot);
            curvature[k] = (varied.dot(&point.bend) + normal.dot(&by.bend) - self.curvature[k] * by.stretch)
                * point.inverse_stretch;
        }
        let along = by.t.dot(&point.r_dot) + point.t.dot(&by.r_dot);
        let flow = speed - along;
        StackVariation {
            speed,
            along,
            flow,
            lead: by.stretch * (-self.lead + 1.0) * self.inverse_lambda,
            c: (flow - self.c * by.stretch) * self.inverse_lambda,
            normal_speed,
            curvature,
        }
    }

    /// Variation of [`StackPoint::acceleration`]; those of V̇ and ∂V/∂ξ have names with `d_`.
    #[inline(always)]
    pub fn vary_acceleration<const D: usize>(
        &self,
        point: &RingPoint<T, D>,
        base: &Acceleration<T>,
        PointVariation { ring: by, stack }: &PointVariation<T, D>,
        d_speed_dot: T,
        speed_gradient: T,
        d_speed_gradient: T,
    ) -> Components<T> {
        let c = self.c;
        let mut along = d_speed_dot + stack.c * speed_gradient + c * d_speed_gradient;
        let mut across = [T::zero(); 2];
        for (k, across) in across.iter_mut().enumerate().take(D - 1) {
            let (normal, varied) = (&point.normals[k], &by.normals[k]);
            let (slope_rate, omega) = (base.slope_rate[k], base.omega[k]);
            let d_slope_rate = varied.dot(&point.slope_dot) + normal.dot(&by.slope_dot);
            let d_omega = (d_slope_rate - slope_rate * point.inverse_stretch * by.stretch)
                * point.inverse_stretch
                + stack.c * self.curvature[k]
                + c * stack.curvature[k];
            along -= d_omega * self.normal_speed[k] + omega * stack.normal_speed[k];
            *across = varied.dot(&point.r_ddot)
                + normal.dot(&by.r_ddot)
                + stack.c * slope_rate
                + c * d_slope_rate
                + d_omega * base.passing
                + omega * (stack.speed - stack.along);
        }
        Components { along, across }
    }
}

/// Push force of a cell, and its damping part.
#[derive(Clone, Copy, Debug)]
pub struct Push<T> {
    /// Q, N.
    pub force: T,
    /// The damping part of Q, N.
    pub viscous: T,
}

impl<T: Real> Push<T> {
    /// No force.
    #[inline(always)]
    #[must_use]
    pub fn none() -> Self {
        let zero = T::zero();
        Self {
            force: zero,
            viscous: zero,
        }
    }
}

/// ⟨D⟩ over a width w, 1/s: D where elements approach, −w/2 where they separate, zero at rest.
#[inline(always)]
fn approach<T: Real>(rate: T, width: f64) -> T {
    rate.smooth_plus(width).value - 0.5 * width
}

/// Push force from the density ν of the elements and its material rate D, 1/s.
#[inline(always)]
pub fn push_force<T: Real>(belt: &PushElements, density: WithRate<T>) -> Push<T> {
    let WithRate { value: nu, rate } = density;
    let strain = nu - 1.0;
    let PositivePart {
        value: closed,
        slope: contact,
        ..
    } = strain.soft_plus(belt.contact_strain());
    let near = ((closed - strain) * (belt.element_thickness / belt.film_thickness) + 1.0).recip();
    let approaching = approach(rate, RATE_SMOOTHING);
    let oil = (approaching * 2.0 + (rate - approaching) * near * near) * belt.film_damping
        + rate * near * near * near * belt.squeeze_damping;
    let cavitating = (oil * oil * belt.suction.powi(-2) + 1.0).sqrt().recip();
    let viscous =
        contact * rate * (belt.push_stiffness * belt.damping) + oil.if_positive(oil, oil * cavitating);
    Push {
        force: closed * belt.push_stiffness + viscous,
        viscous,
    }
}

/// Elastic energy of the stack per pitch-line length, J/m: N ε(ν) with ε' = k_e⟨ν−1⟩₊/ν².
#[inline(always)]
#[must_use]
pub fn energy_density<T: Real>(belt: &PushElements, nu: T) -> T {
    // 1/ν² is expanded about contact: ν − 1 is below 1e-2 wherever force acts.
    let strain = nu - 1.0;
    soft_plus_energy(strain, belt.contact_strain()) * belt.push_stiffness
}

/// The quantities of a cell that determine the flux of elements.
#[derive(Clone, Copy, Debug, Default)]
pub struct Transport<T> {
    /// J at its left face, m/s.
    pub flow: T,
    /// ν.
    pub density: T,
}

impl<T> Transport<T> {
    /// Applies `f` to each quantity.
    pub fn map<U>(self, f: impl Fn(T) -> U) -> Transport<U> {
        Transport {
            flow: f(self.flow),
            density: f(self.density),
        }
    }

    /// The quantities.
    pub fn as_array(&self) -> [&T; 2] {
        [&self.flow, &self.density]
    }

    /// Mutable references to the quantities.
    pub fn as_mut_array(&mut self) -> [&mut T; 2] {
        [&mut self.flow, &mut self.density]
    }
}

/// Throughput of a face: J ν of the cell upstream.
#[inline(always)]
pub fn flux<T: Real>(before: &Transport<T>, after: &Transport<T>) -> T {
    let forward = after.flow.smooth_plus(UPWIND_SMOOTHING).value;
    let backward = (-after.flow).smooth_plus(UPWIND_SMOOTHING).value;
    forward * before.density - backward * after.density
}
