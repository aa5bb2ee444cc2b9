//! Forces at a point, and generalised forces of an element.

use super::{ElementMotion, Hermite, Node, RingPoint, RingVariation, embed, in_plane};
use crate::reference_curve::ReferencePoint;
use crate::scalar::{Real, zero_vector};
use nalgebra::SVector;

/// Forces per length conjugate to the virtual motions of a mesh point. Sign: residual = inertia − forces.
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
        let bend_theta = reference.n * reference.kappa_theta - reference.t * (reference.kappa * reference.chi_theta);
        self.theta + in_plane(&self.position).dot(&reference.r_theta) - self.drift * reference.xi.d
            + in_plane(&self.slope).dot(&reference.n) * reference.chi_theta
            + in_plane(&self.bend).dot(&bend_theta)
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
        let overlay = [
            point.slope - embed(reference.t),
            point.bend - embed(reference.n * reference.kappa),
        ];
        let of_length = self.add_to_overlay(load, overlay, shape, element, weight);
        self.theta += (load.on_curve(reference) - of_length) * weight;
    }

    /// Adds the forces on the overlay, whose u' and u'' are given. Returns the force on Θ by the length of the element, N·m/m.
    #[inline(always)]
    pub fn add_to_overlay(
        &mut self,
        load: &LineLoad<T, D>,
        [slope, bend]: [SVector<T, D>; 2],
        shape: &Hermite<T::Constant>,
        element: &ElementMotion<T, D>,
        weight: T,
    ) -> T {
        let g = element.length.v.recip() * 2.0;
        let dilation = element.length.d * g * 0.5;
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
        (load.slope.dot(&slope) + load.bend.dot(&bend) * 2.0) * dilation
    }

    /// Adds the variation of the force on Θ of [`ElementLoad::add`] where the point varies and the load does not.
    #[inline(always)]
    pub fn add_varied(
        &mut self,
        load: &LineLoad<T, D>,
        variation: &RingVariation<T, D>,
        element: &ElementMotion<T, D>,
        weight: T,
    ) {
        let dilation = element.length.d * element.length.v.recip();
        self.theta -= (load.slope.dot(&variation.slope) + load.bend.dot(&variation.bend) * 2.0) * dilation * weight;
    }

    /// The variation of the force on Θ of [`ElementLoad::nodes`] where component `k` of a node's slope varies by `by` and
    /// the loads do not.
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
        let of_slopes = self.d[1].dot(&element.slopes[0]) + self.d[3].dot(&element.slopes[1]);
        ([node(0), node(1)], self.theta + of_slopes * l.d)
    }
}
