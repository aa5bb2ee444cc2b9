//! Kinematics of the ALE ring on a mesh that moves with Θ (paper 3, eq. (10) to (12)), and the virtual power conjugate
//! to it.
//!
//! Position r = R(ξ, Θ) + B q_f (10) with A_i = identity and cubic Hermite functions (paper 5.2) on elements whose
//! borders stay on the arc borders. At fixed mesh point η:
//!
//! - ring velocity v = ṙ + w r', w = ṡ − ξ̇_η (12),
//! - ring acceleration Dv/Dt = r̈ + ẇ r' + 2w (r')˙ + w² r'',
//!
//! where a dot is ∂/∂t at fixed η. The nodal degrees of freedom are the deflection `a` and its slope `b` = ∂/∂ξ; the
//! element works with d = (a₁, l b₁, a₂, l b₂), whose shape functions do not depend on the element length l(Θ).

use super::particle::ParticleLoad;
use crate::reference_curve::{Jet, ReferencePoint};
use crate::scalar::{Real, turn_right};
use nalgebra::Vector2;
use std::ops::Mul;

/// Cubic Hermite functions of the element at a local coordinate x ∈ [−1, 1] (paper 5.2), and their x derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Hermite<L = f64> {
    /// Values.
    pub n: [L; 4],
    /// First derivatives.
    pub dn: [L; 4],
    /// Second derivatives.
    pub ddn: [L; 4],
}

impl<L: Real> Hermite<L> {
    /// Functions N₁, N₂/l, N₃, N₄/l at `x`. The paper prints N₄ with the opposite sign.
    #[must_use]
    pub fn at(x: L) -> Self {
        Self {
            n: [
                (-(x * 3.0) + 2.0 + x * x * x) * 0.25,
                (-x + 1.0 - x * x + x * x * x) * 0.125,
                (x * 3.0 + 2.0 - x * x * x) * 0.25,
                (-x - 1.0 + x * x + x * x * x) * 0.125,
            ],
            dn: [
                (x * x - 1.0) * 0.75,
                (-(x * 2.0) - 1.0 + x * 3.0 * x) * 0.125,
                (-(x * x) + 1.0) * 0.75,
                (x * 2.0 - 1.0 + x * 3.0 * x) * 0.125,
            ],
            ddn: [x * 1.5, (x * 3.0 - 1.0) * 0.25, -(x * 1.5), (x * 3.0 + 1.0) * 0.25],
        }
    }
}

/// Deflection and slope of a node, or a time derivative of them.
#[derive(Clone, Copy, Debug)]
pub struct Node<T: Real> {
    /// Deflection, m.
    pub a: Vector2<T>,
    /// Slope ∂/∂ξ of the deflection.
    pub b: Vector2<T>,
}

/// A quantity with its first and second time derivative at fixed η.
#[derive(Clone, Copy, Debug)]
pub struct Motion<T> {
    /// Value.
    pub value: T,
    /// First time derivative.
    pub rate: T,
    /// Second time derivative.
    pub acceleration: T,
}

/// Motion of the reference degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceMotion<T> {
    /// Θ, Θ̇, Θ̈.
    pub theta: Motion<T>,
    /// Drift rate ṡ, m/s.
    pub s_dot: T,
    /// s̈, m/s².
    pub s_ddot: T,
}

/// An element's overlay in the length-free coordinates d, or none of it (`ALE0`).
#[derive(Clone, Copy, Debug)]
pub struct ElementMotion<T: Real> {
    /// Element length l(Θ), m.
    pub length: Jet<T>,
    overlay: Option<Overlay<T>>,
}

#[derive(Clone, Copy, Debug)]
struct Overlay<T: Real> {
    d: [Vector2<T>; 4],
    rate: [Vector2<T>; 4],
    acceleration: [Vector2<T>; 4],
    slope: [Vector2<T>; 2],
}

impl<T: Real> ElementMotion<T> {
    /// An element that follows the reference curve.
    #[inline(always)]
    pub fn rigid(length: Jet<T>) -> Self {
        Self { length, overlay: None }
    }

    /// An element between two nodes.
    #[inline(always)]
    pub fn flexible(length: Jet<T>, theta: &Motion<T>, nodes: &[Motion<Node<T>>; 2]) -> Self {
        let l = length.v;
        let l_dot = length.d * theta.rate;
        let l_ddot = length.dd * theta.rate * theta.rate + length.d * theta.acceleration;
        let mut overlay = Overlay {
            d: [Vector2::zeros(); 4],
            rate: [Vector2::zeros(); 4],
            acceleration: [Vector2::zeros(); 4],
            slope: [nodes[0].value.b, nodes[1].value.b],
        };
        for (i, node) in nodes.iter().enumerate() {
            let (b, b_dot) = (node.value.b, node.rate.b);
            overlay.d[2 * i] = node.value.a;
            overlay.d[2 * i + 1] = b * l;
            overlay.rate[2 * i] = node.rate.a;
            overlay.rate[2 * i + 1] = b_dot * l + b * l_dot;
            overlay.acceleration[2 * i] = node.acceleration.a;
            overlay.acceleration[2 * i + 1] = node.acceleration.b * l + b_dot * (l_dot * 2.0) + b * l_ddot;
        }
        Self {
            length,
            overlay: Some(overlay),
        }
    }
}

/// Σ weights·d; the weights are mesh constants or, where the mesh moves under the place, numbers like d.
#[inline(always)]
pub(super) fn combine<T: Real + Mul<W, Output = T>, W: Copy>(weights: &[W; 4], d: &[Vector2<T>; 4]) -> Vector2<T> {
    let sum = |f: fn(&Vector2<T>) -> T| {
        f(&d[0]) * weights[0] + f(&d[1]) * weights[1] + f(&d[2]) * weights[2] + f(&d[3]) * weights[3]
    };
    Vector2::new(sum(|v| v.x), sum(|v| v.y))
}

/// The ring at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct RingPoint<T: Real> {
    /// Reference curve there.
    pub reference: ReferencePoint<T>,
    /// Position r, m.
    pub r: Vector2<T>,
    /// ṙ at fixed η, m/s.
    pub r_dot: Vector2<T>,
    /// r̈ at fixed η, m/s².
    pub r_ddot: Vector2<T>,
    /// r' = ∂r/∂ξ.
    pub slope: Vector2<T>,
    /// (r')˙ at fixed η, 1/s.
    pub slope_dot: Vector2<T>,
    /// r'', 1/m.
    pub bend: Vector2<T>,
    /// |r'|.
    pub stretch: T,
    /// Tangent t̂ = r'/|r'|.
    pub t: Vector2<T>,
    /// Inward normal n̂.
    pub n: Vector2<T>,
    /// Material speed through the mesh w = ṡ − ξ̇_η, m/s.
    pub w: T,
    /// ẇ at fixed η, m/s².
    pub w_dot: T,
}

impl<T: Real> RingPoint<T> {
    /// Kinematics at `shape` of an element.
    #[inline(always)]
    pub fn new(
        reference: ReferencePoint<T>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T>,
        motion: &ReferenceMotion<T>,
    ) -> Self {
        let (rate, acceleration) = (motion.theta.rate, motion.theta.acceleration);
        let mut r = reference.r;
        let mut r_dot = reference.r_theta * rate;
        let mut r_ddot = reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration;
        let mut slope = reference.t;
        let mut slope_dot = reference.n * (reference.chi_theta * rate);
        let mut bend = reference.n * reference.kappa;
        if let Some(overlay) = &element.overlay {
            let g = element.length.v.recip() * 2.0;
            let u_slope = combine(&shape.dn, &overlay.d) * g;
            r += combine(&shape.n, &overlay.d);
            r_dot += combine(&shape.n, &overlay.rate);
            r_ddot += combine(&shape.n, &overlay.acceleration);
            slope += u_slope;
            slope_dot += combine(&shape.dn, &overlay.rate) * g - u_slope * (element.length.d * rate * g * 0.5);
            bend += combine(&shape.ddn, &overlay.d) * (g * g);
        }
        let stretch = slope.dot(&slope).sqrt();
        let t = slope * stretch.recip();
        Self {
            reference,
            r,
            r_dot,
            r_ddot,
            slope,
            slope_dot,
            bend,
            stretch,
            t,
            n: turn_right(t),
            w: motion.s_dot - reference.xi.d * rate,
            w_dot: motion.s_ddot - reference.xi.d * acceleration - reference.xi.dd * rate * rate,
        }
    }

    /// Kinematics of a ring that keeps to the reference curve.
    #[inline(always)]
    pub fn guided(reference: ReferencePoint<T>, motion: &ReferenceMotion<T>) -> Self {
        let (rate, acceleration) = (motion.theta.rate, motion.theta.acceleration);
        Self {
            reference,
            r: reference.r,
            r_dot: reference.r_theta * rate,
            r_ddot: reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration,
            slope: reference.t,
            slope_dot: reference.n * (reference.chi_theta * rate),
            bend: reference.n * reference.kappa,
            stretch: T::one(),
            t: reference.t,
            n: reference.n,
            w: motion.s_dot - reference.xi.d * rate,
            w_dot: motion.s_ddot - reference.xi.d * acceleration - reference.xi.dd * rate * rate,
        }
    }

    /// Ring velocity v (12), m/s.
    #[inline(always)]
    pub fn velocity(&self) -> Vector2<T> {
        self.r_dot + self.slope * self.w
    }

    /// Ring acceleration Dv/Dt, m/s².
    #[inline(always)]
    pub fn acceleration(&self) -> Vector2<T> {
        self.r_ddot + self.slope * self.w_dot + self.slope_dot * (self.w * 2.0) + self.bend * (self.w * self.w)
    }

    /// Axial strain γ = |r'| − 1 (20).
    #[inline(always)]
    pub fn strain(&self) -> T {
        self.stretch - 1.0
    }

    /// γ' along ξ, 1/m.
    #[inline(always)]
    pub fn strain_gradient(&self) -> T {
        self.t.dot(&self.bend)
    }

    /// Material strain rate Dγ/Dt = γ̇|_η + w γ', 1/s.
    #[inline(always)]
    pub fn strain_rate(&self) -> T {
        self.t.dot(&self.slope_dot) + self.w * self.strain_gradient()
    }
}

/// Forces per length conjugate to the virtual motions of a mesh point. Sign: residual = inertia − forces.
#[derive(Clone, Copy, Debug)]
pub struct Load<T: Real> {
    /// Conjugate to δr, N/m.
    pub position: Vector2<T>,
    /// Conjugate to δr', N.
    pub slope: Vector2<T>,
    /// Conjugate to δr'', N·m.
    pub bend: Vector2<T>,
    /// Conjugate to δw, N/m.
    pub drift: T,
    /// Conjugate to δΘ beyond what the other entries carry, N·m/m.
    pub theta: T,
}

impl<T: Real> Load<T> {
    /// No load.
    #[inline(always)]
    pub fn zero() -> Self {
        Self {
            position: Vector2::zeros(),
            slope: Vector2::zeros(),
            bend: Vector2::zeros(),
            drift: T::zero(),
            theta: T::zero(),
        }
    }

    /// A load on the particle that passes a mesh point: virtual displacements at fixed x̄ are δr|_η + r' δσ, δσ the
    /// drift through the mesh. Of a load k on r'' the part in δσ is left out: a mesh point does not know r'''.
    #[inline(always)]
    pub fn of_particle(load: &ParticleLoad<T>, point: &RingPoint<T>) -> Self {
        Self {
            position: load.position,
            slope: load.slope,
            bend: load.bend,
            drift: load.position.dot(&point.slope) + load.slope.dot(&point.bend),
            theta: T::zero(),
        }
    }
}

/// Generalised forces of an element.
#[derive(Clone, Copy, Debug)]
pub struct ElementLoad<T: Real> {
    /// Conjugate to the length-free coordinates d.
    d: [Vector2<T>; 4],
    /// Conjugate to Θ (the part through d excepted until [`ElementLoad::nodes`]).
    pub theta: T,
    /// Conjugate to s.
    pub s: T,
}

impl<T: Real> ElementLoad<T> {
    /// No load.
    #[inline(always)]
    pub fn zero() -> Self {
        Self {
            d: [Vector2::zeros(); 4],
            theta: T::zero(),
            s: T::zero(),
        }
    }

    /// Adds a load over the length `weight`, m.
    #[inline(always)]
    pub fn add(
        &mut self,
        load: &Load<T>,
        point: &RingPoint<T>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T>,
        weight: T,
    ) {
        let reference = &point.reference;
        self.s += load.drift * weight;
        let bend_theta = reference.n * reference.kappa_theta - reference.t * (reference.kappa * reference.chi_theta);
        let mut theta = load.theta + load.position.dot(&reference.r_theta) - load.drift * reference.xi.d
            + load.slope.dot(&reference.n) * reference.chi_theta
            + load.bend.dot(&bend_theta);
        if element.overlay.is_some() {
            let g = element.length.v.recip() * 2.0;
            let growth = element.length.d * g * 0.5;
            let u_slope = point.slope - reference.t;
            let u_bend = point.bend - reference.n * reference.kappa;
            theta -= (load.slope.dot(&u_slope) + load.bend.dot(&u_bend) * 2.0) * growth;
            let (f0, f1, f2) = (
                load.position * weight,
                load.slope * (g * weight),
                load.bend * (g * g * weight),
            );
            for k in 0..4 {
                let (n, dn, ddn) = (shape.n[k], shape.dn[k], shape.ddn[k]);
                self.d[k].x += f0.x * n + f1.x * dn + f2.x * ddn;
                self.d[k].y += f0.y * n + f1.y * dn + f2.y * ddn;
            }
        }
        self.theta += theta * weight;
    }

    /// Conjugates of the nodal degrees of freedom, and of Θ complete.
    #[inline(always)]
    pub fn nodes(&self, element: &ElementMotion<T>) -> ([Node<T>; 2], T) {
        let l = element.length;
        let node = |i: usize| Node {
            a: self.d[2 * i],
            b: self.d[2 * i + 1] * l.v,
        };
        let mut theta = self.theta;
        if let Some(overlay) = &element.overlay {
            theta += (self.d[1].dot(&overlay.slope[0]) + self.d[3].dot(&overlay.slope[1])) * l.d;
        }
        ([node(0), node(1)], theta)
    }
}
