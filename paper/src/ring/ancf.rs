//! `ANCF`: planar absolute nodal coordinates, the gradient-deficient cable element of two nodes
//! (Shabana 1997, Multibody Syst. Dyn. 1, 339–348; elastic forces: Berzeri and Shabana 2000, J.
//! Sound Vib. 235, 539–565).
//!
//! The unknowns of a node are its position and its gradient r' = ∂r/∂x̄; the interpolation is by
//! cubic Hermite functions, as for the overlay of the ALE ring (paper 5.2). r is linear in the
//! unknowns, so the mass matrix is constant. Strain and curvature are those of `beam.rs`, with the
//! membrane strain at each quadrature point. Cubic position and pointwise strain make the membrane
//! of a thin curved element too stiff (locking), as observed in the paper's 5.4.

use super::kinematics::{Hermite, Motion, combine};
use super::lagrangian::{LagrangianElement, LagrangianRing};
use super::model::{NODAL, RingShape};
use super::particle::{Particle, ParticleLoad};
use crate::scalar::{Real, zero_vector};
use nalgebra::Vector2;
use std::ops::Mul;

/// A ring of ANCF elements.
pub type Ancf<C> = LagrangianRing<AncfElement, C>;

/// The ANCF element. A block holds x, x', y, y' of its left node.
#[derive(Clone, Debug)]
pub enum AncfElement {}

/// Motion of an element in d = (r₁, l r₁', r₂, l r₂').
#[derive(Clone, Copy, Debug)]
pub struct AncfMotion<T: Real> {
    length: f64,
    d: Motion<[Vector2<T>; 4]>,
}

impl LagrangianElement for AncfElement {
    const BLOCK: usize = 4;
    const MEAN_STRAIN: bool = false;

    type ShapeFunctions<W: Real> = Hermite<W>;
    type Motion<T: Real> = AncfMotion<T>;
    type Force<T: Real> = [Vector2<T>; 4];

    fn is_length(k: usize) -> bool {
        k.is_multiple_of(2)
    }

    fn shape<W: Real>(x: W) -> Hermite<W> {
        Hermite::new(x)
    }

    fn place_on(_length: f64, start: f64, shape: RingShape<'_>, block: &mut [f64]) {
        let [r, slope] = shape(start);
        block.copy_from_slice(&[r.x, slope.x, r.y, slope.y]);
    }

    #[inline(always)]
    fn motion<T: Real>(length: f64, unknowns: &[Motion<T>]) -> AncfMotion<T> {
        let d = |of: fn(&Motion<T>) -> T| {
            std::array::from_fn(|k| {
                let at = k / 2 * Self::BLOCK + k % 2;
                let scale = if k % 2 == 1 { length } else { 1.0 };
                Vector2::new(of(&unknowns[at]) * scale, of(&unknowns[at + 2]) * scale)
            })
        };
        AncfMotion {
            length,
            d: Motion {
                value: d(|m| m.value),
                rate: d(|m| m.rate),
                acceleration: d(|m| m.acceleration),
            },
        }
    }

    #[inline(always)]
    fn particle<T: Real + Mul<W, Output = T>, W: Real>(
        motion: &AncfMotion<T>,
        shape: &Hermite<W>,
    ) -> Particle<T> {
        let g = T::from(2.0 / motion.length);
        let d = &motion.d;
        Particle {
            r: combine(&shape.n, &d.value),
            slope: combine(&shape.dn, &d.value) * g,
            bend: combine(&shape.ddn, &d.value) * (g * g),
            velocity: combine(&shape.n, &d.rate),
            velocity_slope: combine(&shape.dn, &d.rate) * g,
            acceleration: combine(&shape.n, &d.acceleration),
        }
    }

    fn no_force<T: Real>() -> [Vector2<T>; 4] {
        [zero_vector(); 4]
    }

    #[inline(always)]
    fn add<T: Real + Mul<W, Output = T>, W: Real>(
        motion: &AncfMotion<T>,
        shape: &Hermite<W>,
        load: &ParticleLoad<T>,
        weight: f64,
        force: &mut [Vector2<T>; 4],
    ) {
        let g = 2.0 / motion.length;
        let (f0, f1, f2) = (
            load.position * T::from(weight),
            load.slope * T::from(g * weight),
            load.bend * T::from(g * g * weight),
        );
        for (k, sum) in force.iter_mut().enumerate() {
            let (n, dn, ddn) = (shape.n[k], shape.dn[k], shape.ddn[k]);
            sum.x += f0.x * n + f1.x * dn + f2.x * ddn;
            sum.y += f0.y * n + f1.y * dn + f2.y * ddn;
        }
    }

    #[inline(always)]
    fn conjugates<T: Real>(motion: &AncfMotion<T>, force: &[Vector2<T>; 4]) -> [T; NODAL] {
        let l = motion.length;
        let [r1, g1, r2, g2] = force;
        [r1.x, g1.x * l, r1.y, g1.y * l, r2.x, g2.x * l, r2.y, g2.y * l]
    }
}
