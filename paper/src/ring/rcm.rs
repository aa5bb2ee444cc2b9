//! `RCM`: the planar co-rotational ring in redundant coordinates.
//!
//! Source (the paper's [13, 14, 41, 43]; Zander and Ulbrich 2006, "Reference-free mixed FE-MBS
//! approach for beam structures with constraints", Nonlinear Dyn. 46, as the paper's program MBSim
//! has it in `FiniteElement1s21RCM`): the coordinates of an element are the positions and angles of
//! its two nodes and two inner bending coordinates, (x₁, y₁, φ₁, c_L, c_R, x₂, y₂, φ₂), five
//! unknowns per element of a ring. They determine a rigid-body motion of the element, one axial
//! strain, and a small bending deflection. Neighbours share position and tangent of their node.
//!
//! The formulation below is this project's own. The source's frame (at the middle of the element,
//! its halves along the end tangents) has much longer formulas for the same beam. With x = x̄/l ∈
//! [0, 1] and ⊥ a right turn (inwards):
//!
//! - frame: the chord g = (r₂ − r₁)/l; lengths along and across it, c_L and c_R included, are in
//!   units of |g|,
//! - bending: w(x) = l Σ p_k N_k(x) with N_k quintic, p = (θ₁, θ₂, c_L/l, c_R/l), so c_L and c_R
//!   are the deflections at the quarter points; end slopes are θ_i = t(φ_i)·g⊥/g², so that
//!   g⊥ w' across the chord is the sine of the angle between tangent and chord (up to the strain),
//! - the deflection shortens its projection: with u(x) = −½l [∫₀ˣ w'² − x∫₀¹ w'²], |r'| is uniform
//!   up to the order w'⁴,
//! - r = r₁ + g (x̄ + u) + g⊥ w.
//!
//! The equations contain φ in sine and cosine only, so rotations are unlimited. The energy is that
//! of `beam.rs` with the mean strain of the element: the deflection of an inextensible arc has no
//! membrane energy (no locking). Limits: an element must turn by less than about 1 rad; within an
//! element the stretch is uniform up to w'⁴/8.

use super::kinematics::Motion;
use super::lagrangian::{LagrangianElement, LagrangianRing};
use super::model::{NODAL, RingShape};
use super::particle::{Particle, ParticleLoad};
use crate::scalar::{Real, turn_right, zero_vector};
use nalgebra::Vector2;
use std::array::from_fn;
use std::ops::Mul;

/// A ring of co-rotational elements.
pub type Rcm<C> = LagrangianRing<RcmElement, C>;

/// The co-rotational element. A block holds x, y, φ of its left node, c_L and c_R.
#[derive(Clone, Debug)]
pub enum RcmElement {}

/// Coefficients of N_k in powers x¹ to x⁵: slope 1 at the left end, at the right end, value 1 at x
/// = ¼, at x = ¾; each is zero in the other three conditions and at both ends.
const BENDING: [[f64; 5]; 4] = [
    // x (1−x)² (x−¼)(x−¾)·16/3
    [1.0, -22.0 / 3.0, 17.0, -16.0, 16.0 / 3.0],
    // −x² (1−x)(x−¼)(x−¾)·16/3
    [0.0, -1.0, 19.0 / 3.0, -32.0 / 3.0, 16.0 / 3.0],
    // −x² (1−x)² (x−¾)·512/9
    [0.0, 128.0 / 3.0, -1280.0 / 9.0, 1408.0 / 9.0, -512.0 / 9.0],
    // x² (1−x)² (x−¼)·512/9
    [0.0, -128.0 / 9.0, 256.0 / 3.0, -128.0, 512.0 / 9.0],
];

/// Shape functions at a place.
#[derive(Clone, Copy, Debug)]
pub struct RcmShape<W> {
    x: W,
    /// N_k and two derivatives.
    n: [[W; 4]; 3],
    /// S_jk = ∫₀ˣ N_j'N_k' − x∫₀¹ N_j'N_k', so that u = −½l pᵀS p, and two derivatives.
    s: [[[W; 4]; 4]; 3],
}

/// Motion of an element.
#[derive(Clone, Copy, Debug)]
pub struct RcmMotion<T: Real> {
    length: f64,
    start: Motion<Vector2<T>>,
    g: Motion<Vector2<T>>,
    p: Motion<[T; 4]>,
    tangent: [Vector2<T>; 2],
    /// 1/g².
    inverse: T,
}

/// Generalised forces on an element.
#[derive(Clone, Copy, Debug)]
pub struct RcmForce<T: Real> {
    start: Vector2<T>,
    g: Vector2<T>,
    p: [T; 4],
}

/// Unit tangent (sin φ, cos φ) at the angle φ. Its derivative is its [`turn_right`].
fn tangent<T: Real>(phi: T) -> Vector2<T> {
    let (sin, cos) = phi.sin_cos();
    Vector2::new(sin, cos)
}

/// Σ weights·p.
#[inline(always)]
fn sum<T: Real + Mul<W, Output = T>, W: Copy>(weights: &[W; 4], p: &[T; 4]) -> T {
    p[0] * weights[0] + p[1] * weights[1] + p[2] * weights[2] + p[3] * weights[3]
}

/// a·b of vectors of four.
#[inline(always)]
fn dot<T: Real>(a: &[T; 4], b: &[T; 4]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// ∫₀ˣ N_j'N_k' dx as coefficients of x¹ to x⁹.
const PRODUCTS: [[[f64; 9]; 4]; 4] = {
    let mut out = [[[0.0; 9]; 4]; 4];
    let mut at = 0;
    // `at` counts j, k and the powers of N_j and N_k.
    while at < 4 * 4 * 5 * 5 {
        let (j, k, a, b) = (at / 100, at / 25 % 4, at / 5 % 5, at % 5);
        let slopes = BENDING[j][a] * (a + 1) as f64 * BENDING[k][b] * (b + 1) as f64;
        out[j][k][a + b] += slopes / (a + b + 1) as f64;
        at += 1;
    }
    out
};

/// ∫₀¹ N_j'N_k' dx.
const WHOLE: [[f64; 4]; 4] = {
    let mut out = [[0.0; 4]; 4];
    let mut at = 0;
    while at < 4 * 4 * 9 {
        let (j, k, i) = (at / 36, at / 9 % 4, at % 9);
        out[j][k] += PRODUCTS[j][k][i];
        at += 1;
    }
    out
};

/// A symmetric table.
fn symmetric<W: Real>(of: impl Fn(usize, usize) -> W) -> [[W; 4]; 4] {
    let half: [[W; 4]; 4] = from_fn(|j| from_fn(|k| if k <= j { of(j, k) } else { W::zero() }));
    from_fn(|j| from_fn(|k| half[j.max(k)][j.min(k)]))
}

/// Σ cᵢ xⁱ⁺¹.
fn polynomial<W: Real>(c: &[f64], x: W) -> W {
    c.iter().rev().fold(W::zero(), |sum, &c| (sum + c) * x)
}

impl LagrangianElement for RcmElement {
    const BLOCK: usize = 5;
    const MEAN_STRAIN: bool = true;

    type ShapeFunctions<W: Real> = RcmShape<W>;
    type Motion<T: Real> = RcmMotion<T>;
    type Force<T: Real> = RcmForce<T>;

    fn is_length(k: usize) -> bool {
        k != 2
    }

    fn shape<W: Real>(x: W) -> RcmShape<W> {
        let x = (x + 1.0) * 0.5;
        let n = from_fn(|k| polynomial(&BENDING[k], x));
        let dn: [W; 4] = from_fn(|k| {
            let [a, b, c, d, e] = BENDING[k];
            polynomial(&[2.0 * b, 3.0 * c, 4.0 * d, 5.0 * e], x) + a
        });
        let ddn: [W; 4] = from_fn(|k| {
            let [_, b, c, d, e] = BENDING[k];
            polynomial(&[6.0 * c, 12.0 * d, 20.0 * e], x) + 2.0 * b
        });
        RcmShape {
            x,
            n: [n, dn, ddn],
            s: [
                symmetric(|j, k| polynomial(&PRODUCTS[j][k], x) - x * WHOLE[j][k]),
                symmetric(|j, k| dn[j] * dn[k] - WHOLE[j][k]),
                symmetric(|j, k| ddn[j] * dn[k] + dn[j] * ddn[k]),
            ],
        }
    }

    fn place_on(length: f64, start: f64, shape: RingShape<'_>, block: &mut [f64]) {
        let [r, slope] = shape(start);
        let g = (shape(start + length)[0] - r) / length;
        let deflection = |x: f64| (shape(start + x * length)[0] - r).dot(&turn_right(g)) / g.norm_squared();
        block.copy_from_slice(&[r.x, r.y, slope.x.atan2(slope.y), deflection(0.25), deflection(0.75)]);
    }

    #[inline(always)]
    fn motion<T: Real>(length: f64, unknowns: &[Motion<T>]) -> RcmMotion<T> {
        let scale = T::from(length.recip());
        let node =
            |at: usize, of: fn(&Motion<T>) -> T| Vector2::new(of(&unknowns[at]), of(&unknowns[at + 1]));
        let chord = |of: fn(&Motion<T>) -> T| (node(5, of) - node(0, of)) * scale;
        let g = Motion {
            value: chord(|m| m.value),
            rate: chord(|m| m.rate),
            acceleration: chord(|m| m.acceleration),
        };
        let across = Motion {
            value: turn_right(g.value),
            rate: turn_right(g.rate),
            acceleration: turn_right(g.acceleration),
        };
        let (left, right) = (&unknowns[2], &unknowns[7]);
        let tangent = [tangent(left.value), tangent(right.value)];
        let inverse = g.value.dot(&g.value).recip();
        let square_rate = g.value.dot(&g.rate) * 2.0;
        let square_acceleration = (g.rate.dot(&g.rate) + g.value.dot(&g.acceleration)) * 2.0;
        let slope = |t: &Vector2<T>, phi: &Motion<T>| {
            let normal = turn_right(*t);
            let (along, over) = (t.dot(&across.value), normal.dot(&across.value));
            let along_rate = phi.rate * over + t.dot(&across.rate);
            let along_acceleration = phi.acceleration * over - phi.rate * phi.rate * along
                + phi.rate * normal.dot(&across.rate) * 2.0
                + t.dot(&across.acceleration);
            let value = along * inverse;
            let rate = (along_rate - value * square_rate) * inverse;
            Motion {
                value,
                rate,
                acceleration: (along_acceleration - rate * square_rate * 2.0 - value * square_acceleration)
                    * inverse,
            }
        };
        let ends = [slope(&tangent[0], left), slope(&tangent[1], right)];
        let p = |of: fn(&Motion<T>) -> T| {
            [
                of(&ends[0]),
                of(&ends[1]),
                of(&unknowns[3]) * scale,
                of(&unknowns[4]) * scale,
            ]
        };
        RcmMotion {
            length,
            start: Motion {
                value: node(0, |m| m.value),
                rate: node(0, |m| m.rate),
                acceleration: node(0, |m| m.acceleration),
            },
            g,
            p: Motion {
                value: p(|m| m.value),
                rate: p(|m| m.rate),
                acceleration: p(|m| m.acceleration),
            },
            tangent,
            inverse,
        }
    }

    #[inline(always)]
    fn particle<T: Real + Mul<W, Output = T>, W: Real>(
        motion: &RcmMotion<T>,
        shape: &RcmShape<W>,
    ) -> Particle<T> {
        let l = motion.length;
        let Motion {
            value: p,
            rate: p_dot,
            acceleration: p_ddot,
        } = &motion.p;
        let [s, ds, dds] = [0, 1, 2].map(|i| shape.s[i].map(|row| sum(&row, p)));
        let s_dot = shape.s[0].map(|row| sum(&row, p_dot));
        let [n, dn, ddn] = &shape.n;
        // Along and across the chord, in units of g: place, slope, bend.
        let x = T::from(l) * shape.x;
        let along = [
            x - dot(&s, p) * (0.5 * l),
            -(dot(&ds, p) * 0.5) + 1.0,
            -(dot(&dds, p) * (0.5 / l)),
        ];
        let across = [sum(n, p) * l, sum(dn, p), sum(ddn, p) * l.recip()];
        let along_dot = [-(dot(&s, p_dot) * l), -dot(&ds, p_dot)];
        let across_dot = [sum(n, p_dot) * l, sum(dn, p_dot)];
        let along_ddot = -((dot(&s_dot, p_dot) + dot(&s, p_ddot)) * l);
        let across_ddot = sum(n, p_ddot) * l;
        let Motion {
            value: g,
            rate: g_dot,
            acceleration: g_ddot,
        } = motion.g;
        let in_frame = |g: Vector2<T>, along: T, across: T| g * along + turn_right(g) * across;
        Particle {
            r: motion.start.value + in_frame(g, along[0], across[0]),
            slope: in_frame(g, along[1], across[1]),
            bend: in_frame(g, along[2], across[2]),
            velocity: motion.start.rate
                + in_frame(g_dot, along[0], across[0])
                + in_frame(g, along_dot[0], across_dot[0]),
            velocity_slope: in_frame(g_dot, along[1], across[1]) + in_frame(g, along_dot[1], across_dot[1]),
            acceleration: motion.start.acceleration
                + in_frame(g_ddot, along[0], across[0])
                + in_frame(g_dot, along_dot[0] * 2.0, across_dot[0] * 2.0)
                + in_frame(g, along_ddot, across_ddot),
        }
    }

    fn no_force<T: Real>() -> RcmForce<T> {
        RcmForce {
            start: zero_vector(),
            g: zero_vector(),
            p: [T::zero(); 4],
        }
    }

    #[inline(always)]
    fn add<T: Real + Mul<W, Output = T>, W: Real>(
        motion: &RcmMotion<T>,
        shape: &RcmShape<W>,
        load: &ParticleLoad<T>,
        weight: f64,
        force: &mut RcmForce<T>,
    ) {
        let l = motion.length;
        let (p, g) = (&motion.p.value, motion.g.value);
        let normal = turn_right(g);
        let [s, ds, dds] = [0, 1, 2].map(|i| shape.s[i].map(|row| sum(&row, p)));
        let [n, dn, ddn] = &shape.n;
        let loads = [load.position, load.slope, load.bend].map(|f| f * T::from(weight));
        let along = loads.map(|f| f.dot(&g));
        let across = loads.map(|f| f.dot(&normal));
        for (k, sum) in force.p.iter_mut().enumerate() {
            *sum += (across[0] * n[k] - along[0] * s[k]) * l
                + (across[1] * dn[k] - along[1] * ds[k])
                + (across[2] * ddn[k] - along[2] * dds[k]) * l.recip();
        }
        let x = T::from(l) * shape.x;
        let places = [
            (x - dot(&s, p) * (0.5 * l), sum(n, p) * l),
            (-(dot(&ds, p) * 0.5) + 1.0, sum(dn, p)),
            (-(dot(&dds, p) * (0.5 / l)), sum(ddn, p) * l.recip()),
        ];
        force.start += loads[0];
        for (f, (along, across)) in loads.iter().zip(places) {
            // Transpose of g ↦ g along + g⊥ across.
            force.g += *f * along - turn_right(*f) * across;
        }
    }

    #[inline(always)]
    fn conjugates<T: Real>(motion: &RcmMotion<T>, force: &RcmForce<T>) -> [T; NODAL] {
        let scale = T::from(motion.length.recip());
        let normal = turn_right(motion.g.value);
        let mut g = force.g;
        let mut turn = [T::zero(); 2];
        for (k, t) in motion.tangent.iter().enumerate() {
            let slope = force.p[k] * motion.inverse;
            g -= (turn_right(*t) + motion.g.value * (motion.p.value[k] * 2.0)) * slope;
            turn[k] = turn_right(*t).dot(&normal) * slope;
        }
        let end = g * scale;
        let start = force.start - end;
        [
            start.x,
            start.y,
            turn[0],
            force.p[2] * scale,
            force.p[3] * scale,
            end.x,
            end.y,
            turn[1],
        ]
    }
}
