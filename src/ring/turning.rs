//! The overlay in directions that turn with the reference curve: A_i = [t, n]_ref in (10).
//!
//! With d = (d_t, d_n) along t and n, κ and χ of the reference curve, and J v = (v_n, −v_t):
//!
//! - u = A d, u' = A e, e = d' − κ J d, u'' = A (d'' − 2κ J d' − κ² d), since t' = κ n and n' = −κ t,
//! - u̇ = A (ḋ − χ̇ J d), ü = A (d̈ − 2χ̇ J ḋ − χ̈ J d − χ̇² d), (u')˙ = A (ė − χ̇ J e), dots at fixed η.
//!
//! d is interpolated on elements by the same Hermite functions as with fixed directions. κ is constant on an arc or strand
//! and jumps in between, so with d' continuous the tangent of the ring would not be: nodes hold e, and an element's
//! d' = e + κ J d with the curvature of its own side.

use super::kinematics::{ElementLoad, ElementMotion, Hermite, Load, Motion, Node, ReferenceMotion, RingPoint};
use crate::reference_curve::{Jet, ReferencePoint, Turning};
use crate::scalar::{Real, turn_right};
use nalgebra::Vector2;

/// What an element needs to change between the slopes e of its nodes and its own d'.
pub struct TurningElement<T: Real> {
    curvature: [Jet<T>; 2],
    deflection: [Vector2<T>; 2],
}

impl<T: Real> TurningElement<T> {
    /// Changes the slopes of `nodes` from e to d'; `curvature` of the reference curve at the two ends.
    pub fn new(curvature: [Jet<T>; 2], theta: &Motion<T>, nodes: &mut [Motion<Node<T>>; 2]) -> Self {
        let deflection = [nodes[0].value.a, nodes[1].value.a];
        for (node, k) in nodes.iter_mut().zip(&curvature) {
            let rate = k.d * theta.rate;
            let acceleration = k.dd * theta.rate * theta.rate + k.d * theta.acceleration;
            let [a, a_dot, a_ddot] = [node.value.a, node.rate.a, node.acceleration.a].map(turn_right);
            node.value.b += a * k.v;
            node.rate.b += a * rate + a_dot * k.v;
            node.acceleration.b += a * acceleration + a_dot * (rate * 2.0) + a_ddot * k.v;
        }
        Self { curvature, deflection }
    }

    /// Conjugates of the nodes' e and of Θ from those of d'.
    pub fn nodes(&self, nodes: [&mut Node<T>; 2], theta: &mut T) {
        for ((node, k), a) in nodes.into_iter().zip(&self.curvature).zip(&self.deflection) {
            *theta += turn_right(*a).dot(&node.b) * k.d;
            node.a -= turn_right(node.b) * k.v;
        }
    }
}

/// No reference curve: a mesh point on it is at the origin with zero slope, so that the point is d itself.
fn nowhere<T: Real>(reference: &ReferencePoint<T>) -> ReferencePoint<T> {
    let zero = Vector2::zeros();
    ReferencePoint {
        r: zero,
        r_theta: zero,
        r_theta2: zero,
        t: zero,
        n: zero,
        chi_theta: T::zero(),
        kappa: T::zero(),
        kappa_theta: T::zero(),
        xi: reference.xi,
    }
}

fn deflection<T: Real>(
    reference: &ReferencePoint<T>,
    shape: &Hermite<T::Constant>,
    element: &ElementMotion<T>,
    motion: &ReferenceMotion<T>,
) -> RingPoint<T> {
    RingPoint::new(nowhere(reference), shape, element, motion)
}

/// Kinematics at `shape` of an element whose overlay is d.
pub fn rotated_point<T: Real>(
    reference: ReferencePoint<T>,
    turning: &Turning<T>,
    shape: &Hermite<T::Constant>,
    element: &ElementMotion<T>,
    motion: &ReferenceMotion<T>,
) -> RingPoint<T> {
    let d = deflection(&reference, shape, element, motion);
    let theta = &motion.theta;
    let chi_dot = turning.chi.d * theta.rate;
    let chi_ddot = turning.chi.dd * theta.rate * theta.rate + turning.chi.d * theta.acceleration;
    let kappa = reference.kappa;
    let kappa_dot = reference.kappa_theta * theta.rate;
    let e = d.slope - turn_right(d.r) * kappa;
    let e_dot = d.slope_dot - turn_right(d.r) * kappa_dot - turn_right(d.r_dot) * kappa;
    let a = |c: Vector2<T>| reference.t * c.x + reference.n * c.y;
    let rigid = ElementMotion::rigid(element.length);
    let mut point = RingPoint::new(reference, shape, &rigid, motion);
    point.r += a(d.r);
    point.r_dot += a(d.r_dot - turn_right(d.r) * chi_dot);
    point.r_ddot +=
        a(d.r_ddot - turn_right(d.r_dot) * (chi_dot * 2.0) - turn_right(d.r) * chi_ddot - d.r * (chi_dot * chi_dot));
    point.slope += a(e);
    point.slope_dot += a(e_dot - turn_right(e) * chi_dot);
    point.bend += a(d.bend - turn_right(d.slope) * (kappa * 2.0) - d.r * (kappa * kappa));
    point.stretch = point.slope.dot(&point.slope).sqrt();
    point.t = point.slope * point.stretch.recip();
    point.n = turn_right(point.t);
    point
}

/// Adds a load over the length `weight`, m, at a point of [`rotated_point`]: its transpose.
pub fn rotated_load<T: Real>(
    load: &Load<T>,
    point: &RingPoint<T>,
    shape: &Hermite<T::Constant>,
    element: &ElementMotion<T>,
    motion: &ReferenceMotion<T>,
    weight: T,
    sum: &mut ElementLoad<T>,
) {
    let reference = &point.reference;
    let d = deflection(reference, shape, element, motion);
    let kappa = reference.kappa;
    let e = d.slope - turn_right(d.r) * kappa;
    let h = d.bend - turn_right(d.slope) * (kappa * 2.0) - d.r * (kappa * kappa);
    let local = |v: &Vector2<T>| Vector2::new(v.dot(&reference.t), v.dot(&reference.n));
    let [f, m, k] = [local(&load.position), local(&load.slope), local(&load.bend)];
    let by_chi = -(f.dot(&turn_right(d.r)) + m.dot(&turn_right(e)) + k.dot(&turn_right(h)));
    let by_kappa = -(m.dot(&turn_right(d.r)) + k.dot(&turn_right(d.slope)) * 2.0 + k.dot(&d.r) * kappa * 2.0);
    let mut of_curve = *load;
    of_curve.theta += by_chi * reference.chi_theta + by_kappa * reference.kappa_theta;
    sum.add(&of_curve, point, shape, &ElementMotion::rigid(element.length), weight);
    let of_deflection = Load {
        position: f + turn_right(m) * kappa - k * (kappa * kappa),
        slope: m + turn_right(k) * (kappa * 2.0),
        bend: k,
        drift: T::zero(),
        theta: T::zero(),
    };
    sum.add(&of_deflection, &d, shape, element, weight);
}
