//! The laws' part of the derivatives of a pack of cells, stored as L, S, R ([`laws`](crate::variator::cell::laws)). An
//! update of the tangents S yields the derivatives at the current state.

use crate::scalar::{Lanes, along};
use crate::variator::assembly::unknowns::rows;
use crate::variator::cell::directions::{Directions, MOST, MOST_ROWS, RESULTANT};
use crate::variator::cell::flank_variation::{FLANK_ARGUMENTS, FLANK_FORCES};
use crate::variator::cell::laws::{ARGUMENTS, Extent, LawArguments, LawTangents};
use crate::variator::cell::variation::Linearised;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::VaryingRing;
use num_traits::Zero;

/// Largest number of forces of a cell's laws: in space, with both flanks at each station.
const MOST_FORCES: usize = STATIONS * (2 * FLANK_FORCES + 1) + 1;

/// L and R of a pack of cells, and the tangents S of its cached derivatives.
#[derive(Clone, Debug)]
pub(crate) struct LawPart {
    extent: Extent,
    /// L: for each force, the rows of the block of derivatives.
    left: Vec<Lanes>,
    /// R: for each argument, the directions.
    right: Vec<Lanes>,
    slopes: LawTangents,
}

impl LawPart {
    /// Memory for the laws of a pack with this number of stations in D components.
    pub fn new<K: Directions, const D: usize>(stations: usize) -> Self {
        let extent = Extent::new(stations, D);
        let zeros = |len| vec![Lanes::zero(); len];
        Self {
            left: zeros(extent.forces() * height::<K>()),
            right: zeros(extent.arguments() * K::COUNT),
            slopes: LawTangents::zero(),
            extent,
        }
    }

    /// Records the variation of the arguments of the laws in direction `k`.
    #[inline(always)]
    pub fn record<K: Directions>(&mut self, k: usize, by: &LawArguments<Lanes>) {
        let Extent { stations, flanks } = self.extent;
        let mut to = self.right.iter_mut().skip(k).step_by(K::COUNT);
        let mut put = |value: Lanes| {
            if let Some(to) = to.next() {
                *to = value;
            }
        };
        for station in &by.stations[..stations] {
            station.flanks[..flanks].iter().flatten().for_each(|value| put(*value));
            station.ring.iter().for_each(|value| put(*value));
        }
        by.stack.iter().for_each(|value| put(*value));
    }

    /// Records L and the tangents of the laws.
    #[inline(always)]
    pub fn keep<K: Directions, R: VaryingRing<Lanes, D>, const D: usize>(
        &mut self,
        linear: &Linearised<'_, R, D>,
        slopes: &LawTangents,
    ) {
        self.slopes = *slopes;
        let mut left = self.left.chunks_exact_mut(height::<K>());
        linear.for_each_force(|b, ring| {
            if let Some(to) = left.next() {
                let rows = rows::<_, K, D>(&b, &ring);
                to.iter_mut().zip(in_block::<K>(&rows)).for_each(|(to, row)| *to = *row);
            }
        });
    }

    /// The derivatives with updated tangents, from the cached `block`.
    #[inline(never)]
    pub fn with_tangents<'a, K: Directions>(
        &self,
        slopes: &LawTangents,
        block: &[Lanes],
        work: &'a mut LawWork,
    ) -> &'a [Lanes] {
        let LawWork { through, out } = work;
        let Extent { stations, flanks } = self.extent;
        let mut changes = Changes {
            right: self.right.chunks_exact(K::COUNT),
            through,
            forces: [0; MOST_FORCES],
            count: 0,
            force: 0,
        };
        for (now, then) in slopes.stations.iter().zip(&self.slopes.stations).take(stations) {
            for (now, then) in now.flanks.iter().zip(&then.flanks).take(flanks) {
                changes.add::<K, FLANK_ARGUMENTS>(now, then);
            }
            changes.add::<K, ARGUMENTS>(&[now.ring], &[then.ring]);
        }
        changes.add::<K, ARGUMENTS>(&[slopes.stack], &[self.slopes.stack]);
        let Changes { forces, count, .. } = changes;
        let left = |force: usize, row: usize| self.left[force * height::<K>() + row];
        // Four forces at a time, so that an entry is read and written once for all of them.
        let fours = through[..count].chunks_exact(4).zip(forces.chunks_exact(4));
        let rest = count - count % 4;
        let rows = out.chunks_exact_mut(K::COUNT).zip(block.chunks_exact(K::COUNT));
        for (row, (to, block)) in rows.enumerate() {
            to.copy_from_slice(block);
            for (through, forces) in fours.clone() {
                let by: [Lanes; 4] = std::array::from_fn(|k| left(forces[k], row));
                let through: [&[Lanes]; 4] = std::array::from_fn(|k| &through[k][..K::COUNT]);
                for (column, to) in to.iter_mut().enumerate() {
                    *to += (by[0] * through[0][column] + by[1] * through[1][column])
                        + (by[2] * through[2][column] + by[3] * through[3][column]);
                }
            }
            for (through, &force) in through[rest..count].iter().zip(&forces[rest..]) {
                let by = left(force, row);
                to.iter_mut()
                    .zip(through)
                    .for_each(|(to, through)| *to += by * *through);
            }
        }
        out
    }
}

/// Working memory of [`LawPart::with_tangents`].
#[derive(Clone, Debug)]
pub(crate) struct LawWork {
    through: Box<Through>,
    /// The derivatives.
    out: Vec<Lanes>,
}

impl LawWork {
    /// For the packs of a ring.
    pub fn new<K: Directions>() -> Self {
        Self {
            through: Box::new([[Lanes::zero(); MOST]; MOST_FORCES]),
            out: vec![Lanes::zero(); height::<K>() * K::COUNT],
        }
    }
}

/// (S_new − S) R of forces with changed tangents.
type Through = [[Lanes; MOST]; MOST_FORCES];

/// Collects the forces with changed tangents.
struct Changes<'a, R> {
    right: R,
    through: &'a mut Through,
    forces: [usize; MOST_FORCES],
    count: usize,
    /// Number of the next force.
    force: usize,
}

impl<'a, R: Iterator<Item = &'a [Lanes]>> Changes<'_, R> {
    /// Adds the forces of a law with A arguments.
    #[inline(always)]
    fn add<K: Directions, const A: usize>(&mut self, now: &[[Lanes; A]], then: &[[Lanes; A]]) {
        let right: [&[Lanes]; A] = std::array::from_fn(|_| self.right.next().unwrap_or_default());
        for (now, then) in now.iter().zip(then) {
            if now != then {
                let by: [Lanes; A] = std::array::from_fn(|k| now[k] - then[k]);
                for (column, to) in self.through[self.count][..K::COUNT].iter_mut().enumerate() {
                    *to = along(&by, &right.map(|right| right[column]));
                }
                self.forces[self.count] = self.force;
                self.count += 1;
            }
            self.force += 1;
        }
    }
}

/// Rows of the block of a pack's derivatives.
pub(crate) const fn height<K: Directions>() -> usize {
    K::COUNT - 1 + RESULTANT
}

/// The rows of a balance without that of the amount.
#[inline(always)]
pub(crate) fn in_block<K: Directions>(rows: &[Lanes; MOST_ROWS]) -> impl Iterator<Item = &Lanes> {
    let (before, after) = rows[..K::COUNT + RESULTANT].split_at(K::AMOUNT);
    before.iter().chain(&after[1..])
}
