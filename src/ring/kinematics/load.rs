//! Forces at a point, and generalised forces of an element.

use super::{ElementMotion, Hermite, Node, RingPoint, embed, in_plane};
use crate::reference_curve::ReferencePoint;
use crate::scalar::{Real, zero_vector};
use nalgebra::SVector;

/// Forces per length (inertia − forces) conjugate to the virtual motions of a mesh point.
#[derive(Clone, Copy, Debug)]
pub struct LineLoad<T: Real, const D: usize = 2> {
    /// Conjugate to δr, N/m.
    pub position: SVector<T, D>,
    /// Conjugate to δr', N.
    pub slope: SVector<T, D>,
    /// Conjugate to δr'', N·m.
    pub bend: SVector<T, D>,
    /// Conjugate to δw, N/m.
    pub drift: T,
    /// Conjugate to δΘ, the parts through the other entries excepted, N·m/m.
    pub theta: T,
}

impl<T: Real, const D: usize> LineLoad<T, D> {
    /// No force.
    #[inline(always)]
    #[must_use]
    pub fn zero() -> Self {
        Self {
            position: zero_vector(),
            slope: zero_vector(),
            bend: zero_vector(),
            drift: T::zero(),
            theta: T::zero(),
        }
    }

    /// Conjugate to δΘ where the ring follows the reference curve, N·m/m.
    #[inline(always)]
    pub fn on_curve(&self, reference: &ReferencePoint<T>) -> T {
        self.theta + in_plane(&self.position).dot(&reference.r_theta) - self.drift * reference.xi.d
            + in_plane(&self.slope).dot(&reference.n) * reference.chi_theta
            + in_plane(&self.bend).dot(&reference.bend_theta())
    }

    /// Conjugate to δΘ through the length of the element, where u' is `slope` and u'' `bend`,
    /// N·m/m.
    #[inline(always)]
    pub fn on_length(&self, slope: &SVector<T, D>, bend: &SVector<T, D>, element: &ElementMotion<T, D>) -> T {
        let dilation = element.length.d * element.length.v.recip();
        -((self.slope.dot(slope) + self.bend.dot(bend) * 2.0) * dilation)
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
    /// No force.
    #[inline(always)]
    #[must_use]
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
        load: &LineLoad<T, D>,
        point: &RingPoint<T, D>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        weight: T,
    ) {
        let reference = &point.reference;
        self.s += load.drift * weight;
        let slope = point.slope - embed(reference.t);
        let bend = point.bend - embed(reference.n * reference.kappa);
        self.theta += (load.on_curve(reference) + load.on_length(&slope, &bend, element)) * weight;
        self.add_to_overlay(load, shape, element, weight);
    }

    /// Adds the forces on the overlay.
    #[inline(always)]
    pub fn add_to_overlay(
        &mut self,
        load: &LineLoad<T, D>,
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        weight: T,
    ) {
        let g = element.length.v.recip() * 2.0;
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

    /// Variation of the conjugate of Θ where component `k` of a node's slope alone varies, by `by`.
    #[inline(always)]
    pub fn slope_varied(&self, node: usize, k: usize, by: f64, element: &ElementMotion<T, D>) -> T {
        self.d[2 * node + 1][k] * element.length.d * by
    }

    /// Conjugates of the nodal degrees of freedom, and the complete conjugate of Θ.
    #[inline(always)]
    pub fn nodes(&self, element: &ElementMotion<T, D>) -> ([Node<T, D>; 2], T) {
        let l = element.length;
        let node = |i: usize| Node {
            a: self.d[2 * i],
            b: self.d[2 * i + 1] * l.v,
        };
        let slope_theta = self.d[1].dot(&element.slopes[0]) + self.d[3].dot(&element.slopes[1]);
        ([node(0), node(1)], self.theta + slope_theta * l.d)
    }
}
