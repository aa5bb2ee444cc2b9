//! The unknowns of a cell by their directions, its motion, and the rows of its balance.

use crate::ring::kinematics::{Motion, Node};
use crate::scalar::Real;
use crate::variator::cell::degrees::{DegreesOfFreedom, MOST_ROWS};
use crate::variator::law::place::{CellBalance, CellMotion, Part};
use crate::variator::rings::ring::RingForces;
use nalgebra::SVector;

/// Motion of the nodes (`ALE`), from the `unknown` of a part and a direction.
#[inline(always)]
pub fn nodes<T: Real, const D: usize>(unknown: impl Fn(Part, usize) -> T) -> [Motion<Node<T, D>>; 2] {
    [0, 2 * D].map(|first| {
        let node = |part: Part| Node {
            a: SVector::from_fn(|k, _| unknown(part, first + 2 * k)),
            b: SVector::from_fn(|k, _| unknown(part, first + 2 * k + 1)),
        };
        Motion {
            value: node(Part::Position),
            rate: node(Part::Value),
            acceleration: node(Part::Rate),
        }
    })
}

/// Motion of a cell, from the `unknown` of a part and a direction.
#[inline(always)]
pub(crate) fn motion<T: Real, K: DegreesOfFreedom>(unknown: impl Fn(Part, usize) -> T) -> CellMotion<T> {
    let degrees = K::DEGREES;
    let mut motion = CellMotion::of_unknowns([degrees.nodes, degrees.drift, degrees.sheave], unknown);
    if degrees.coordinates > 1 {
        // The curve holds derivatives along the motion, so time replaces Θ.
        (motion.reference.theta.rate, motion.reference.theta.acceleration) = (T::one(), T::zero());
    }
    motion
}

/// Rows of the balance in the order of the directions, then the resultant of the contact forces. The row of the content is
/// zero; its balance is that of the fluxes.
#[inline(always)]
pub(crate) fn rows<T: Real, K: DegreesOfFreedom, const D: usize>(
    b: &CellBalance<T>,
    ring: &RingForces<T, D>,
) -> [T; MOST_ROWS] {
    let degrees = K::DEGREES;
    let mut rows = [T::zero(); MOST_ROWS];
    for (node, rows) in ring.nodes.iter().zip(rows[..degrees.nodes].chunks_exact_mut(2 * D)) {
        for k in 0..D {
            [rows[2 * k], rows[2 * k + 1]] = [node.a[k], node.b[k]];
        }
    }
    rows[degrees.nodes..][..2].copy_from_slice(&b.speed);
    if degrees.tensions > 0 {
        rows[degrees.content + 1] = ring.tension;
    }
    rows[degrees.drift] = ring.drift;
    rows[degrees.theta] = ring.theta;
    let centres = degrees.coordinates - 1;
    rows[degrees.theta + 1..][..centres].copy_from_slice(&ring.centres[..centres]);
    let of_pulley = [
        b.pulley.axial,
        -b.pulley.tilting[0],
        -b.pulley.tilting[1],
        -b.pulley.torque,
    ];
    rows[degrees.sheave..degrees.count].copy_from_slice(&of_pulley);
    rows[degrees.count..degrees.rows].copy_from_slice(&b.pulley.resultant);
    rows
}
