//! The laws' part L S R of the derivatives of a pack of cells ([`laws`](crate::variator::cell::laws)).

use crate::scalar::{Lanes, along};
use crate::variator::assembly::unknowns::rows;
use crate::variator::cell::directions::{Directions, RESULTANT};
use crate::variator::cell::laws::{FLANK_ARGUMENTS, FLANK_FORCES, LawTangents, RING_ARGUMENTS, STACK_ARGUMENTS};
use crate::variator::law::place::CellBalance;
use crate::variator::rings::ring::RingForces;
use num_traits::Zero;
use std::slice::{ChunksExact, ChunksExactMut};

/// L and R of a pack of cells.
#[derive(Clone, Debug)]
pub(crate) struct LawPart {
    stations: usize,
    /// Distinct flanks at a station: in the plane both are equal.
    flanks: usize,
    /// L: for each force, the rows of the block of derivatives.
    pub left: Vec<Lanes>,
    /// R: for each argument, a row of this number of directions.
    pub width: usize,
    pub right: Vec<Lanes>,
}

impl LawPart {
    /// Memory for the laws of a pack with this number of stations in D components.
    pub fn new<K: Directions, const D: usize>(stations: usize) -> Self {
        let flanks = D - 1;
        let arguments = STACK_ARGUMENTS + stations * (flanks * FLANK_ARGUMENTS + RING_ARGUMENTS);
        Self {
            left: vec![Lanes::zero(); forces(stations, flanks) * height::<K>()],
            right: vec![Lanes::zero(); arguments * K::COUNT],
            width: K::COUNT,
            stations,
            flanks,
        }
    }

    /// Records the rows of the unit force number `k`.
    #[inline(always)]
    pub fn record<K: Directions, const D: usize>(
        &mut self,
        k: usize,
        b: &CellBalance<Lanes>,
        ring: &RingForces<Lanes, D>,
    ) {
        let rows = rows::<_, K, D>(b, ring);
        let to = &mut self.left[k * height::<K>()..][..height::<K>()];
        to.iter_mut().zip(in_block::<K>()).for_each(|(to, row)| *to = rows[row]);
    }

    /// Adds what the tangents change from `then` to `now` to the derivatives in `block`.
    #[inline(never)]
    pub fn add_changes<K: Directions>(
        &self,
        [now, then]: [&LawTangents; 2],
        block: &mut [Lanes],
        LawWork { through, forces }: &mut LawWork,
    ) {
        forces.clear();
        let mut changes = Changes {
            right: self.right.chunks_exact(K::COUNT),
            through: through.chunks_exact_mut(K::COUNT),
            forces,
            next: 0,
        };
        changes.add(&[now.stack], &[then.stack]);
        for station in 0..self.stations {
            for flank in 0..self.flanks {
                changes.add(&now.flanks[station][flank], &then.flanks[station][flank]);
            }
            changes.add(&[now.ring[station]], &[then.ring[station]]);
        }
        let through = &through[..forces.len() * K::COUNT];
        let left = |force: usize, row: usize| self.left[forces[force] * height::<K>() + row];
        // Four forces at a time, so that an entry is read and written once for all of them.
        let fours = through.chunks_exact(4 * K::COUNT);
        let (last, first_of_last) = (fours.remainder(), 4 * fours.len());
        for (row, to) in block.chunks_exact_mut(K::COUNT).enumerate() {
            for (four, through) in fours.clone().enumerate() {
                let by: [Lanes; 4] = std::array::from_fn(|k| left(4 * four + k, row));
                let through: [&[Lanes]; 4] = std::array::from_fn(|k| &through[k * K::COUNT..][..K::COUNT]);
                for (column, to) in to.iter_mut().enumerate() {
                    *to += (by[0] * through[0][column] + by[1] * through[1][column])
                        + (by[2] * through[2][column] + by[3] * through[3][column]);
                }
            }
            for (k, through) in last.chunks_exact(K::COUNT).enumerate() {
                let by = left(first_of_last + k, row);
                to.iter_mut()
                    .zip(through)
                    .for_each(|(to, through)| *to += by * *through);
            }
        }
    }
}

/// Collects (S_now − S_then) R of forces with changed tangents.
struct Changes<'a> {
    right: ChunksExact<'a, Lanes>,
    through: ChunksExactMut<'a, Lanes>,
    /// Numbers of these forces, and the number of the next force.
    forces: &'a mut Vec<usize>,
    next: usize,
}

impl Changes<'_> {
    /// Adds the forces of a law with A arguments.
    #[inline(always)]
    fn add<const A: usize>(&mut self, now: &[[Lanes; A]], then: &[[Lanes; A]]) {
        let right: [&[Lanes]; A] = std::array::from_fn(|_| self.right.next().unwrap_or_default());
        for (now, then) in now.iter().zip(then) {
            if now != then {
                let by: [Lanes; A] = std::array::from_fn(|k| now[k] - then[k]);
                let to = self.through.next().into_iter().flatten();
                to.enumerate()
                    .for_each(|(column, to)| *to = along(&by, &right.map(|right| right[column])));
                self.forces.push(self.next);
            }
            self.next += 1;
        }
    }
}

/// Number of forces of the laws of a cell.
const fn forces(stations: usize, flanks: usize) -> usize {
    1 + stations * (flanks * FLANK_FORCES + 1)
}

/// Working memory of [`LawPart::add_changes`].
#[derive(Clone, Debug)]
pub(crate) struct LawWork {
    /// Changes of S R, and the numbers of their forces.
    through: Vec<Lanes>,
    forces: Vec<usize>,
}

impl LawWork {
    /// For packs of cells with this number of stations in D components.
    pub fn new<K: Directions, const D: usize>(stations: usize) -> Self {
        Self {
            through: vec![Lanes::zero(); forces(stations, D - 1) * K::COUNT],
            forces: Vec::with_capacity(forces(stations, D - 1)),
        }
    }
}

/// Rows of the block of a pack's derivatives.
pub(crate) const fn height<K: Directions>() -> usize {
    K::COUNT - 1 + RESULTANT
}

/// Rows of the balance in the block: all but that of the amount.
#[inline(always)]
pub(crate) fn in_block<K: Directions>() -> impl Iterator<Item = usize> {
    (0..K::AMOUNT).chain(K::AMOUNT + 1..K::COUNT + RESULTANT)
}
