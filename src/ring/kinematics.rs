//! Kinematics of the ALE ring on a mesh that moves with Θ (paper 3, eq. (10) to (12)), and the virtual power conjugate
//! to it.
//!
//! Position r = R(ξ, Θ) + B q_f (10) with A_i = identity and cubic Hermite functions (paper 5.2) on elements whose
//! borders stay on the arc borders. The reference curve is planar, the deflection has D components: x and y, and in
//! space w along z, the direction of the binormal. At fixed mesh point η:
//!
//! - ring velocity v = ṙ + w r', w = ṡ − ξ̇_η (12),
//! - ring acceleration Dv/Dt = r̈ + ẇ r' + 2w (r')˙ + w² r'',
//!
//! where a dot is ∂/∂t at fixed η. The nodal degrees of freedom are the deflection `a` and its slope `b` = ∂/∂ξ; the
//! element works with d = (a₁, l b₁, a₂, l b₂), whose shape functions do not depend on the element length l(Θ).

use crate::reference_curve::{Jet, ReferencePoint};
use crate::scalar::{Real, turn_right, zero_vector};
use nalgebra::{SVector, Vector2};
use std::ops::Mul;

/// Components in the plane of the drive.
#[inline(always)]
pub fn in_plane<T: Real, const D: usize>(v: &SVector<T, D>) -> Vector2<T> {
    Vector2::new(v[0], v[1])
}

/// A vector in the plane of the drive as one of D components.
#[inline(always)]
pub fn embed<T: Real, const D: usize>(v: Vector2<T>) -> SVector<T, D> {
    SVector::from_fn(|i, _| if i < 2 { v[i] } else { T::zero() })
}

/// a × b in space.
#[inline(always)]
fn cross<T: Real, const D: usize>(a: &SVector<T, D>, b: &SVector<T, D>) -> SVector<T, D> {
    SVector::from_fn(|i, _| {
        let (j, k) = ((i + 1) % D, (i + 2) % D);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// Inward normal n̂ of a curve of D components in the plane of the drive, ⊥ to the unit tangent `t`.
#[inline(always)]
pub fn inward_normal<T: Real, const D: usize>(t: &SVector<T, D>) -> SVector<T, D> {
    let n = turn_right(in_plane(t));
    embed(if D == 2 { n } else { n * n.dot(&n).sqrt().recip() })
}

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
pub struct Node<T: Real, const D: usize = 2> {
    /// Deflection, m.
    pub a: SVector<T, D>,
    /// Slope ∂/∂ξ of the deflection.
    pub b: SVector<T, D>,
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

impl<T: Real> ReferenceMotion<T> {
    /// Speed w = ṡ − ξ_Θ Θ̇ at which the material passes a mesh point, m/s, and its rate, m/s².
    #[inline(always)]
    pub fn passing(&self, xi: &Jet<T>) -> (T, T) {
        let (rate, acceleration) = (self.theta.rate, self.theta.acceleration);
        (
            self.s_dot - xi.d * rate,
            self.s_ddot - xi.d * acceleration - xi.dd * rate * rate,
        )
    }
}

/// An element's overlay in the length-free coordinates d, or none of it (`ALE0`).
#[derive(Clone, Copy, Debug)]
pub struct ElementMotion<T: Real, const D: usize = 2> {
    /// Element length l(Θ), m.
    pub length: Jet<T>,
    overlay: Option<Overlay<T, D>>,
}

#[derive(Clone, Copy, Debug)]
struct Overlay<T: Real, const D: usize> {
    d: [SVector<T, D>; 4],
    rate: [SVector<T, D>; 4],
    acceleration: [SVector<T, D>; 4],
    slope: [SVector<T, D>; 2],
}

impl<T: Real, const D: usize> ElementMotion<T, D> {
    /// An element that follows the reference curve.
    #[inline(always)]
    pub fn rigid(length: Jet<T>) -> Self {
        Self { length, overlay: None }
    }

    /// An element between two nodes.
    #[inline(always)]
    pub fn flexible(length: Jet<T>, theta: &Motion<T>, nodes: &[Motion<Node<T, D>>; 2]) -> Self {
        let l = length.v;
        let l_dot = length.d * theta.rate;
        let l_ddot = length.dd * theta.rate * theta.rate + length.d * theta.acceleration;
        let mut overlay = Overlay {
            d: [zero_vector(); 4],
            rate: [zero_vector(); 4],
            acceleration: [zero_vector(); 4],
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
pub(super) fn combine<T: Real + Mul<W, Output = T>, W: Copy, const D: usize>(
    weights: &[W; 4],
    d: &[SVector<T, D>; 4],
) -> SVector<T, D> {
    SVector::from_fn(|i, _| d[0][i] * weights[0] + d[1][i] * weights[1] + d[2][i] * weights[2] + d[3][i] * weights[3])
}

/// The ring at a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct RingPoint<T: Real, const D: usize = 2> {
    /// Reference curve there.
    pub reference: ReferencePoint<T>,
    /// Position r, m.
    pub r: SVector<T, D>,
    /// ṙ at fixed η, m/s.
    pub r_dot: SVector<T, D>,
    /// r̈ at fixed η, m/s².
    pub r_ddot: SVector<T, D>,
    /// r' = ∂r/∂ξ.
    pub slope: SVector<T, D>,
    /// (r')˙ at fixed η, 1/s.
    pub slope_dot: SVector<T, D>,
    /// r'', 1/m.
    pub bend: SVector<T, D>,
    /// |r'|.
    pub stretch: T,
    /// 1/|r'|.
    pub inverse_stretch: T,
    /// Tangent t̂ = r'/|r'|.
    pub t: SVector<T, D>,
    /// Inward normal n̂, in the plane of the drive.
    pub n: SVector<T, D>,
    /// Material speed through the mesh w = ṡ − ξ̇_η, m/s.
    pub w: T,
    /// ẇ at fixed η, m/s².
    pub w_dot: T,
    /// γ' as damping takes it, 1/m: at first that of the point; [`super::ale`] says why a mean takes its place.
    pub strain_gradient: T,
}

impl<T: Real> RingPoint<T> {
    /// Kinematics of a ring that keeps to the reference curve.
    #[inline(always)]
    pub fn guided(reference: ReferencePoint<T>, motion: &ReferenceMotion<T>) -> Self {
        let (rate, acceleration) = (motion.theta.rate, motion.theta.acceleration);
        let (w, w_dot) = motion.passing(&reference.xi);
        Self {
            reference,
            r: reference.r,
            r_dot: reference.r_theta * rate,
            r_ddot: reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration,
            slope: reference.t,
            slope_dot: reference.n * (reference.chi_theta * rate),
            bend: reference.n * reference.kappa,
            stretch: T::one(),
            inverse_stretch: T::one(),
            t: reference.t,
            n: reference.n,
            w,
            w_dot,
            strain_gradient: T::zero(),
        }
    }
}

impl<T: Real, const D: usize> RingPoint<T, D> {
    /// Kinematics at `shape` of an element.
    #[inline(always)]
    pub fn new(
        reference: ReferencePoint<T>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        motion: &ReferenceMotion<T>,
    ) -> Self {
        let (rate, acceleration) = (motion.theta.rate, motion.theta.acceleration);
        let mut r: SVector<T, D> = embed(reference.r);
        let mut r_dot: SVector<T, D> = embed(reference.r_theta * rate);
        let mut r_ddot: SVector<T, D> = embed(reference.r_theta2 * (rate * rate) + reference.r_theta * acceleration);
        let mut slope: SVector<T, D> = embed(reference.t);
        let mut slope_dot: SVector<T, D> = embed(reference.n * (reference.chi_theta * rate));
        let mut bend: SVector<T, D> = embed(reference.n * reference.kappa);
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
        let (stretch, inverse_stretch) = slope.dot(&slope).root_and_inverse();
        let t = slope * inverse_stretch;
        let (w, w_dot) = motion.passing(&reference.xi);
        Self {
            reference,
            r,
            r_dot,
            r_ddot,
            slope,
            slope_dot,
            bend,
            stretch,
            inverse_stretch,
            t,
            n: inward_normal(&t),
            w,
            w_dot,
            strain_gradient: t.dot(&bend),
        }
    }

    /// Normals of the ring: n̂, and in space b̂ = t̂ × n̂.
    #[inline(always)]
    pub fn normals(&self) -> [SVector<T, D>; 2] {
        let binormal = if D == 3 { cross(&self.t, &self.n) } else { zero_vector() };
        [self.n, binormal]
    }

    /// Ring velocity v (12), m/s.
    #[inline(always)]
    pub fn velocity(&self) -> SVector<T, D> {
        self.r_dot + self.slope * self.w
    }

    /// Ring acceleration Dv/Dt, m/s².
    #[inline(always)]
    pub fn acceleration(&self) -> SVector<T, D> {
        self.r_ddot + self.slope * self.w_dot + self.slope_dot * (self.w * 2.0) + self.bend * (self.w * self.w)
    }

    /// Axial strain γ = |r'| − 1 (20).
    #[inline(always)]
    pub fn strain(&self) -> T {
        self.stretch - 1.0
    }

    /// Material strain rate Dγ/Dt = γ̇|_η + w γ', 1/s.
    #[inline(always)]
    pub fn strain_rate(&self) -> T {
        self.t.dot(&self.slope_dot) + self.w * self.strain_gradient
    }
}

/// How the ring at a mesh point varies in a direction that leaves the reference curve where it is: the derivatives of a
/// [`RingPoint`].
#[derive(Clone, Copy, Debug)]
pub struct RingVariation<T: Real, const D: usize = 2> {
    /// δr.
    pub r: SVector<T, D>,
    /// δṙ.
    pub r_dot: SVector<T, D>,
    /// δr̈.
    pub r_ddot: SVector<T, D>,
    /// δr'.
    pub slope: SVector<T, D>,
    /// δ(r')˙.
    pub slope_dot: SVector<T, D>,
    /// δr''.
    pub bend: SVector<T, D>,
    /// δ|r'|.
    pub stretch: T,
    /// δt̂.
    pub t: SVector<T, D>,
    /// Of the [`RingPoint::normals`].
    pub normals: [SVector<T, D>; 2],
    /// δw.
    pub w: T,
    /// δẇ.
    pub w_dot: T,
    /// δγ'.
    pub strain_gradient: T,
}

impl<T: Real, const D: usize> RingVariation<T, D> {
    /// None.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = zero_vector();
        Self {
            r: zero,
            r_dot: zero,
            r_ddot: zero,
            slope: zero,
            slope_dot: zero,
            bend: zero,
            stretch: T::zero(),
            t: zero,
            normals: [zero; 2],
            w: T::zero(),
            w_dot: T::zero(),
            strain_gradient: T::zero(),
        }
    }

    /// Where component `k` of the nodal unknown with shape function `m` varies; `alpha` and `beta` are the factors of
    /// acceleration and position.
    #[inline(always)]
    pub fn of_node(
        point: &RingPoint<T, D>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        motion: &ReferenceMotion<T>,
        [m, k]: [usize; 2],
        [alpha, beta]: [f64; 2],
    ) -> Self {
        let l = element.length;
        let Motion { rate, acceleration, .. } = motion.theta;
        // d = b l for the slope of a node, d = a for its deflection.
        let (d, d_dot, d_ddot) = if m % 2 == 1 {
            let l_dot = l.d * rate;
            let l_ddot = l.dd * rate * rate + l.d * acceleration;
            (
                l.v * beta,
                l.v + l_dot * beta,
                l.v * alpha + l_dot * 2.0 + l_ddot * beta,
            )
        } else {
            (T::from(beta), T::one(), T::from(alpha))
        };
        let g = l.v.recip() * 2.0;
        let (n, dn, ddn) = (shape.n[m], shape.dn[m], shape.ddn[m]);
        let mut v = Self::none();
        let slope = d * dn * g;
        v.r[k] = d * n;
        v.r_dot[k] = d_dot * n;
        v.r_ddot[k] = d_ddot * n;
        v.slope[k] = slope;
        v.slope_dot[k] = d_dot * dn * g - slope * (l.d * rate * g * 0.5);
        v.bend[k] = d * ddn * (g * g);
        v.stretch = point.t[k] * slope;
        v.t = (v.slope - point.t * v.stretch) * point.inverse_stretch;
        v.strain_gradient = v.t.dot(&point.bend) + point.t.dot(&v.bend);
        v.turn_normals(point);
        v
    }

    /// From δt̂.
    #[inline(always)]
    fn turn_normals(&mut self, point: &RingPoint<T, D>) {
        let turned = turn_right(in_plane(&self.t));
        if D == 2 {
            self.normals[0] = embed(turned);
        } else {
            let (t, n) = (&point.t, in_plane(&point.n));
            let inverse = in_plane(t).dot(&in_plane(t)).sqrt().recip();
            self.normals[0] = embed((turned - n * n.dot(&turned)) * inverse);
            self.normals[1] = cross(&self.t, &point.n) + cross(t, &self.normals[0]);
        }
    }
}

/// Forces per length conjugate to the virtual motions of a mesh point. Sign: residual = inertia − forces.
#[derive(Clone, Copy, Debug)]
pub struct Load<T: Real, const D: usize = 2> {
    /// Conjugate to δr, N/m.
    pub position: SVector<T, D>,
    /// Conjugate to δr', N.
    pub slope: SVector<T, D>,
    /// Conjugate to δr'', N·m.
    pub bend: SVector<T, D>,
    /// Conjugate to δw, N/m.
    pub drift: T,
    /// Conjugate to δΘ beyond what the other entries carry, N·m/m.
    pub theta: T,
}

impl<T: Real, const D: usize> Load<T, D> {
    /// No load.
    #[inline(always)]
    pub fn zero() -> Self {
        Self {
            position: zero_vector(),
            slope: zero_vector(),
            bend: zero_vector(),
            drift: T::zero(),
            theta: T::zero(),
        }
    }
}

/// Generalised forces of an element.
#[derive(Clone, Copy, Debug)]
pub struct ElementLoad<T: Real, const D: usize = 2> {
    /// Conjugate to the length-free coordinates d.
    d: [SVector<T, D>; 4],
    /// Conjugate to Θ (the part through d excepted until [`ElementLoad::nodes`]).
    pub theta: T,
    /// Conjugate to s.
    pub s: T,
}

impl<T: Real, const D: usize> ElementLoad<T, D> {
    /// No load.
    #[inline(always)]
    pub fn zero() -> Self {
        Self {
            d: [zero_vector(); 4],
            theta: T::zero(),
            s: T::zero(),
        }
    }

    /// Adds a load over the length `weight`, m.
    #[inline(always)]
    pub fn add(
        &mut self,
        load: &Load<T, D>,
        point: &RingPoint<T, D>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        weight: T,
    ) {
        let reference = &point.reference;
        self.s += load.drift * weight;
        let bend_theta = reference.n * reference.kappa_theta - reference.t * (reference.kappa * reference.chi_theta);
        let mut theta = load.theta + in_plane(&load.position).dot(&reference.r_theta) - load.drift * reference.xi.d
            + in_plane(&load.slope).dot(&reference.n) * reference.chi_theta
            + in_plane(&load.bend).dot(&bend_theta);
        if element.overlay.is_some() {
            let g = element.length.v.recip() * 2.0;
            let growth = element.length.d * g * 0.5;
            let u_slope = point.slope - embed(reference.t);
            let u_bend = point.bend - embed(reference.n * reference.kappa);
            theta -= (load.slope.dot(&u_slope) + load.bend.dot(&u_bend) * 2.0) * growth;
            let (f0, f1, f2) = (
                load.position * weight,
                load.slope * (g * weight),
                load.bend * (g * g * weight),
            );
            for k in 0..4 {
                let (n, dn, ddn) = (shape.n[k], shape.dn[k], shape.ddn[k]);
                for i in 0..D {
                    self.d[k][i] += f0[i] * n + f1[i] * dn + f2[i] * ddn;
                }
            }
        }
        self.theta += theta * weight;
    }

    /// What [`ElementLoad::add`] gains on Θ where the point varies under a fixed load.
    #[inline(always)]
    pub fn add_varied(
        &mut self,
        load: &Load<T, D>,
        variation: &RingVariation<T, D>,
        element: &ElementMotion<T, D>,
        weight: T,
    ) {
        let growth = element.length.d * element.length.v.recip();
        self.theta -= (load.slope.dot(&variation.slope) + load.bend.dot(&variation.bend) * 2.0) * growth * weight;
    }

    /// What [`ElementLoad::nodes`] gains on Θ where the slope of a node varies by `by` in component `k` under fixed
    /// loads.
    #[inline(always)]
    pub fn slope_varied(&self, node: usize, k: usize, by: f64, element: &ElementMotion<T, D>) -> T {
        self.d[2 * node + 1][k] * element.length.d * by
    }

    /// Conjugates of the nodal degrees of freedom, and of Θ complete.
    #[inline(always)]
    pub fn nodes(&self, element: &ElementMotion<T, D>) -> ([Node<T, D>; 2], T) {
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
