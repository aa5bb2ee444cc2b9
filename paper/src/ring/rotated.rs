//! The overlay in directions that rotate with the reference curve: A_i = [t, n]_ref in (10). In
//! space the third column is e_z. b_ref = t × n = −e_z is also constant; with e_z the sign of w is
//! the same for both choices of A_i.
//!
//! With d = (d_t, d_n) along t and n, κ and χ of the reference curve, and J v = (v_n, −v_t):
//!
//! - u = A d, u' = A e, e = d' − κ J d, u'' = A (d'' − 2κ J d' − κ² d), since t' = κ n and n' = −κ
//!   t,
//! - u̇ = A (ḋ − χ̇ J d), ü = A (d̈ − 2χ̇ J ḋ − χ̈ J d − χ̇² d), (u')˙ = A (ė − χ̇ J e), dots at
//!   fixed η.
//!
//! d is interpolated by the same Hermite functions as with fixed directions. κ is constant on an
//! arc or strand and jumps at their borders, where a continuous d' would make the tangent of the
//! ring discontinuous. The nodal unknown is therefore e, and an element has d' = e + κ J d with the
//! curvature of its own side.

use super::kinematics::{
    ElementLoad, ElementMotion, Hermite, LineLoad, Motion, Node, PointMotion, ReferenceMotion, RingPoint,
    embed, in_plane,
};
use crate::reference_curve::{Jet, ReferencePoint, TangentAngle};
use crate::scalar::{Real, turn_right};
use nalgebra::{SVector, Vector2};

/// Conversion between the slopes e of the nodes and d' of an element.
#[derive(Debug)]
pub struct RotatedElement<T: Real> {
    curvature: [Jet<T>; 2],
    deflection: [Vector2<T>; 2],
}

impl<T: Real> RotatedElement<T> {
    /// Converts the slopes of `nodes` from e to d'. `curvature` is that of the reference curve at
    /// the two ends.
    pub fn new<const D: usize>(
        curvature: [Jet<T>; 2],
        theta: &Motion<T>,
        nodes: &mut [Motion<Node<T, D>>; 2],
    ) -> Self {
        let deflection = [in_plane(&nodes[0].value.a), in_plane(&nodes[1].value.a)];
        for (node, k) in nodes.iter_mut().zip(&curvature) {
            let Motion {
                rate, acceleration, ..
            } = theta.chain_rule(k);
            let [a, a_dot, a_ddot] =
                [node.value.a, node.rate.a, node.acceleration.a].map(|a| turn_right(in_plane(&a)));
            node.value.b += embed(a * k.v);
            node.rate.b += embed(a * rate + a_dot * k.v);
            node.acceleration.b += embed(a * acceleration + a_dot * (rate * 2.0) + a_ddot * k.v);
        }
        Self { curvature, deflection }
    }

    /// Converts conjugates of d' to those of the nodes' e and of Θ.
    pub fn nodes<const D: usize>(&self, nodes: [&mut Node<T, D>; 2], theta: &mut T) {
        for ((node, k), a) in nodes.into_iter().zip(&self.curvature).zip(&self.deflection) {
            let b = in_plane(&node.b);
            *theta += turn_right(*a).dot(&b) * k.d;
            node.a -= embed(turn_right(b) * k.v);
        }
    }
}

/// `v` with its in-plane components replaced.
fn turned<T: Real, const D: usize>(in_plane: Vector2<T>, v: &SVector<T, D>) -> SVector<T, D> {
    SVector::from_fn(|i, _| if i < 2 { in_plane[i] } else { v[i] })
}

/// Kinematics of an element with overlay d where its shape functions are `shape`.
pub fn rotated_point<T: Real, const D: usize>(
    reference: ReferencePoint<T>,
    angle: &TangentAngle<T>,
    shape: &Hermite<T::Constant>,
    element: &ElementMotion<T, D>,
    motion: &ReferenceMotion<T>,
) -> RingPoint<T, D> {
    let theta = &motion.theta;
    let d = element.overlay(shape);
    let chi = theta.chain_rule(&angle.chi);
    let kappa = reference.kappa;
    let kappa_dot = reference.kappa_theta * theta.rate;
    let PointMotion {
        r,
        r_dot,
        r_ddot,
        slope,
        slope_dot,
        bend,
        bend_dot,
    } = d.zip(d, |v, _| in_plane(&v));
    let e = slope - turn_right(r) * kappa;
    let h = bend - turn_right(slope) * (kappa * 2.0) - r * (kappa * kappa);
    let e_dot = slope_dot - turn_right(r) * kappa_dot - turn_right(r_dot) * kappa;
    let overlay = PointMotion {
        r,
        r_dot: r_dot - turn_right(r) * chi.rate,
        r_ddot: r_ddot
            - turn_right(r_dot) * (chi.rate * 2.0)
            - turn_right(r) * chi.acceleration
            - r * (chi.rate * chi.rate),
        slope: e,
        slope_dot: e_dot - turn_right(e) * chi.rate,
        bend: h,
        bend_dot: bend_dot
            - turn_right(slope_dot * kappa + slope * kappa_dot) * T::from(2.0)
            - (r_dot * kappa + r * (kappa_dot * 2.0)) * kappa
            - turn_right(h) * chi.rate,
    };
    let overlay = overlay.zip(d, |v, d| turned(reference.t * v.x + reference.n * v.y, &d));
    let curve = RingPoint::on_curve(&reference, theta);
    RingPoint::from_motion(reference, curve.zip(overlay, |curve, overlay| curve + overlay), motion)
}

/// Adds a load over the length `weight`, m, at a point of [`rotated_point`]: the transpose of its
/// velocities.
pub fn rotated_load<T: Real, const D: usize>(
    load: &LineLoad<T, D>,
    point: &RingPoint<T, D>,
    shape: &Hermite<T::Constant>,
    element: &ElementMotion<T, D>,
    weight: T,
    sum: &mut ElementLoad<T, D>,
) {
    let reference = &point.reference;
    let d = element.overlay(shape);
    let kappa = reference.kappa;
    let [r, slope, bend] = [d.r, d.slope, d.bend].map(|v| in_plane(&v));
    let e = slope - turn_right(r) * kappa;
    let h = bend - turn_right(slope) * (kappa * 2.0) - r * (kappa * kappa);
    let local = |v: &SVector<T, D>| {
        let v = in_plane(v);
        Vector2::new(v.dot(&reference.t), v.dot(&reference.n))
    };
    let [f, m, k] = [local(&load.position), local(&load.slope), local(&load.bend)];
    let by_chi = -(f.dot(&turn_right(r)) + m.dot(&turn_right(e)) + k.dot(&turn_right(h)));
    let by_kappa = -(m.dot(&turn_right(r)) + k.dot(&turn_right(slope)) * 2.0 + k.dot(&r) * kappa * 2.0);
    let mut of_curve = *load;
    of_curve.theta += by_chi * reference.chi_theta + by_kappa * reference.kappa_theta;
    sum.s += load.drift * weight;
    sum.theta += of_curve.on_curve(reference) * weight;
    let of_deflection = LineLoad {
        position: turned(f + turn_right(m) * kappa - k * (kappa * kappa), &load.position),
        slope: turned(m + turn_right(k) * (kappa * 2.0), &load.slope),
        bend: turned(k, &load.bend),
        drift: T::zero(),
        theta: T::zero(),
    };
    sum.add_to_overlay(&of_deflection, shape, element, weight);
    sum.theta += of_deflection.on_length(&d.slope, &d.bend, element) * weight;
}
