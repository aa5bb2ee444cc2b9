//! The part of the laws in the derivatives of a pack of cells: kept as L, S, R ([`laws`](crate::variator::cell::laws)), so that new
//! slopes S make derivatives of now from those of before.

use crate::scalar::Lanes;
use crate::variator::assembly::unknowns::rows;
use crate::variator::cell::directions::{Directions, MOST, MOST_ROWS, RESULTANT};
use crate::variator::cell::laws::{Arguments, Extent, LawForce, LawSlopes, STACK_FORCES};
use crate::variator::cell::flank_variation::FLANK_FORCES;
use crate::variator::cell::variation::Linearised;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::VaryingRing;
use num_traits::Zero;

/// Most forces of a cell's laws: in space, with both flanks at each station.
const MOST_FORCES: usize = STATIONS * (2 * FLANK_FORCES + 1) + STACK_FORCES;

/// L and R of a pack of cells, and the derivatives that have the slopes S.
#[derive(Clone, Debug)]
pub(crate) struct LawPart {
    extent: Extent,
    /// L: for each force, its rows as in the block of derivatives.
    left: Vec<Lanes>,
    /// R: for each argument, the directions.
    right: Vec<Lanes>,
    slopes: LawSlopes,
    /// The block of derivatives with these slopes.
    base: Vec<Lanes>,
}

impl LawPart {
    /// Memory for the laws of a pack with so many stations in D components.
    pub fn new<K: Directions, const D: usize>(stations: usize) -> Self {
        let extent = Extent::new(stations, D);
        let zeros = |len| vec![Lanes::zero(); len];
        Self {
            left: zeros(extent.forces() * height::<K>()),
            right: zeros(extent.arguments() * K::COUNT),
            slopes: LawSlopes::zero(),
            base: zeros(height::<K>() * K::COUNT),
            extent,
        }
    }

    /// Records how the arguments of the laws vary in direction `k`.
    #[inline(always)]
    pub fn record<K: Directions>(&mut self, k: usize, by: &Arguments<Lanes>) {
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

    /// Records how the forces of the laws act, the slopes, and the derivatives that have them.
    #[inline(always)]
    pub fn keep<K: Directions, R: VaryingRing<Lanes, D>, const D: usize>(
        &mut self,
        linear: &Linearised<'_, R, D>,
        block: &[Lanes],
    ) {
        self.base.copy_from_slice(block);
        self.slopes = linear.slopes();
        let Extent { stations, flanks } = self.extent;
        let mut left = self.left.chunks_exact_mut(height::<K>());
        let mut record = |force: LawForce| {
            let (b, ring) = linear.vary_law(force);
            if let Some(to) = left.next() {
                let rows = rows::<_, K, D>(&b, &ring);
                to.iter_mut().zip(in_block::<K>(&rows)).for_each(|(to, row)| *to = *row);
            }
        };
        for station in 0..stations {
            for flank in 0..flanks {
                for force in 0..FLANK_FORCES {
                    record(LawForce::Flank { station, flank, force });
                }
            }
            record(LawForce::Ring { station });
        }
        record(LawForce::Push);
        record(LawForce::Collision);
    }

    /// The derivatives with new slopes, into `block`.
    #[inline(never)]
    pub fn renew<K: Directions>(&self, slopes: &LawSlopes, block: &mut [Lanes]) {
        let Extent { stations, flanks } = self.extent;
        // (S_new − S) R, of the forces whose slopes have changed.
        let mut through = [[Lanes::zero(); MOST]; MOST_FORCES];
        let mut changed = [0; MOST_FORCES];
        let (mut count, mut force, mut argument) = (0, 0, 0);
        let mut add = |now: &[&[Lanes]], then: &[&[Lanes]]| {
            for (now, then) in now.iter().zip(then) {
                if now != then {
                    let to = &mut through[count][..K::COUNT];
                    for (k, (now, then)) in now.iter().zip(*then).enumerate() {
                        let by = *now - *then;
                        let right = &self.right[(argument + k) * K::COUNT..][..K::COUNT];
                        to.iter_mut().zip(right).for_each(|(to, right)| *to += by * *right);
                    }
                    changed[count] = force;
                    count += 1;
                }
                force += 1;
            }
            argument += now[0].len();
        };
        for (now, then) in slopes.stations.iter().zip(&self.slopes.stations).take(stations) {
            for (now, then) in now.flanks.iter().zip(&then.flanks).take(flanks) {
                add(&now.each_ref().map(|of| &of[..]), &then.each_ref().map(|of| &of[..]));
            }
            add(&[&now.ring], &[&then.ring]);
        }
        let [now, then] = [&slopes.stack, &self.slopes.stack];
        add(&now.each_ref().map(|of| &of[..]), &then.each_ref().map(|of| &of[..]));
        let through = &through[..count];
        let rows = block.chunks_exact_mut(K::COUNT).zip(self.base.chunks_exact(K::COUNT));
        for (row, (to, base)) in rows.enumerate() {
            to.copy_from_slice(base);
            for (through, &force) in through.iter().zip(&changed) {
                let left = self.left[force * height::<K>() + row];
                to.iter_mut().zip(through).for_each(|(to, through)| *to += left * *through);
            }
        }
    }
}

/// Rows of the block of a pack's derivatives.
const fn height<K: Directions>() -> usize {
    K::COUNT - 1 + RESULTANT
}

/// Those rows of a balance: the amount's is left out.
#[inline(always)]
pub(crate) fn in_block<K: Directions>(rows: &[Lanes; MOST_ROWS]) -> impl Iterator<Item = &Lanes> {
    let (before, after) = rows[..K::COUNT + RESULTANT].split_at(K::AMOUNT);
    before.iter().chain(&after[1..])
}
