//! Rows of a cell's balance.

use crate::scalar::Real;
use crate::variator::law::arguments::CellBalance;
use crate::variator::rings::{MOST_ROWS, RingForces, RingKind};

/// Rows of the balance in the order of the directions, then the resultant of the contact forces.
/// The row of the content is zero; its balance is that of the fluxes.
#[inline(always)]
pub(super) fn rows<T: Real, K: RingKind<D>, const D: usize>(
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
    let of_curve = ring.curve.to_array();
    rows[degrees.theta..degrees.sheave].copy_from_slice(&of_curve[..degrees.coordinates]);
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
