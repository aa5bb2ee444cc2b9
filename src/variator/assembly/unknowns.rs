//! The unknowns of a cell by their directions, its motion, and the rows of its balance.

use crate::ring::kinematics::{Motion, Node};
use crate::scalar::Real;
use crate::variator::cell::directions::{Directions, MOST, MOST_ROWS};
use crate::variator::law::place::{CellBalance, CellMotion};
use crate::variator::rings::ring::RingForces;
use nalgebra::SVector;
use num_traits::Zero;

/// Unknowns of a cell, or of one in each lane, for each [`Part`] by their directions.
#[derive(Clone, Debug)]
pub struct Unknowns<L>(pub(crate) [[L; MOST]; 3]);

impl<L: Zero + Copy> Unknowns<L> {
    /// All zero.
    pub(crate) fn zero() -> Self {
        Self([[L::zero(); MOST]; 3])
    }
}

impl<L: Copy> Unknowns<L> {
    /// The unknown of direction `k`.
    #[inline(always)]
    pub fn read(&self, part: Part, k: usize) -> L {
        self.0[part as usize][k]
    }
}

/// Position, value or rate of an unknown.
#[derive(Clone, Copy, Debug)]
pub enum Part {
    /// The position q.
    Position,
    /// The unknown y.
    Value,
    /// Its rate ẏ.
    Rate,
}

/// Motion of the nodes (`ALE`).
#[inline(always)]
pub fn nodes<T: Real, const D: usize>(
    unknowns: &Unknowns<T::Constant>,
    [alpha, beta]: [f64; 2],
    seed: impl Fn(T::Constant, usize, f64) -> T,
) -> [Motion<Node<T, D>>; 2] {
    [0, 2 * D].map(|first| {
        let node = |part: Part, slope: f64| {
            let seeded = |k: usize| seed(unknowns.read(part, first + k), first + k, slope);
            Node {
                a: SVector::from_fn(|k, _| seeded(2 * k)),
                b: SVector::from_fn(|k, _| seeded(2 * k + 1)),
            }
        };
        Motion {
            value: node(Part::Position, beta),
            rate: node(Part::Value, 1.0),
            acceleration: node(Part::Rate, alpha),
        }
    })
}

/// Ring tension at the faces (`ALE0`), N.
#[inline(always)]
pub(crate) fn tensions<T: Real>(
    unknowns: &Unknowns<T::Constant>,
    seed: impl Fn(T::Constant, usize, f64) -> T,
) -> [T; 2] {
    [3, 4].map(|k| seed(unknowns.read(Part::Value, k), k, 1.0))
}

/// Motion of a cell; `seed` makes a scalar from a value, its direction and its derivative.
#[inline(always)]
pub(crate) fn motion<T: Real, K: Directions>(
    unknowns: &Unknowns<T::Constant>,
    [alpha, beta]: [f64; 2],
    seed: impl Fn(T::Constant, usize, f64) -> T,
) -> CellMotion<T> {
    let value = |k: usize| seed(unknowns.read(Part::Value, k), k, 1.0);
    let rate = |k: usize| seed(unknowns.read(Part::Rate, k), k, alpha);
    let position = |k: usize| seed(unknowns.read(Part::Position, k), k, beta);
    let mut motion = CellMotion::of_directions([K::NODES, K::DRIFT, K::SHEAVE], position, value, rate);
    if K::COORDINATES > 1 {
        // The curve holds derivatives along the motion, so time replaces Θ.
        (motion.reference.theta.rate, motion.reference.theta.acceleration) = (T::one(), T::zero());
    }
    motion
}

/// Rows of the balance in the order of the directions, then the resultant of the contact forces. The row of the content is
/// zero; its balance is that of the fluxes.
#[inline(always)]
pub(crate) fn rows<T: Real, K: Directions, const D: usize>(
    b: &CellBalance<T>,
    ring: &RingForces<T, D>,
) -> [T; MOST_ROWS] {
    let mut rows = [T::zero(); MOST_ROWS];
    let g = K::DRIFT;
    if K::TENSIONS == 0 {
        for (i, node) in ring.nodes.iter().enumerate() {
            for k in 0..D {
                rows[2 * (D * i + k)] = node.a[k];
                rows[2 * (D * i + k) + 1] = node.b[k];
            }
        }
        rows[4 * D] = b.speed[0];
        rows[4 * D + 1] = b.speed[1];
    } else {
        rows[0] = b.speed[0];
        rows[1] = b.speed[1];
        rows[3] = ring.tension;
    }
    rows[g] = ring.drift;
    rows[g + 1] = ring.theta;
    for (k, centre) in ring.centres.into_iter().enumerate().take(K::COORDINATES - 1) {
        rows[g + 2 + k] = centre;
    }
    let g = K::SHEAVE;
    rows[g] = b.pulley.axial;
    rows[g + 1] = -b.pulley.tilting[0];
    rows[g + 2] = -b.pulley.tilting[1];
    rows[g + 3] = -b.pulley.torque;
    rows[K::COUNT] = b.pulley.resultant[0];
    rows[K::COUNT + 1] = b.pulley.resultant[1];
    rows
}
