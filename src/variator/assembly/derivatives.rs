//! Derivatives of a pack of cells: geometry, and the part of the constitutive laws as L, S, R
//! ([`laws`](crate::variator::cell::laws)). With updated tangents S they are those of the current state.

use crate::chain::Transport;
use crate::scalar::{Lanes, along};
use crate::variator::assembly::unknowns::rows;
use crate::variator::cell::directions::{Directions, MOST, MOST_ROWS, RESULTANT};
use crate::variator::cell::flank_variation::{FLANK_ARGUMENTS, FLANK_FORCES};
use crate::variator::cell::laws::{ARGUMENTS, LawArguments, LawTangents};
use crate::variator::cell::variation::{Direction, Evaluated, Linearised};
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::VaryingRing;
use num_traits::Zero;

/// Largest number of forces of a cell's laws: in space, with both flanks at each station.
const MOST_FORCES: usize = STATIONS * (2 * FLANK_FORCES + 1) + 1;

/// Derivatives of a pack of cells.
#[derive(Clone, Debug)]
pub(crate) struct Derivatives {
    /// Direction by direction for each row: rows of the balance without that of the content, then the resultant of the contact
    /// forces.
    block: Vec<Lanes>,
    /// Numbers of stations and of distinct flanks of a cell.
    stations: usize,
    flanks: usize,
    /// L: for each force, the rows of the block. R: for each argument, the directions. Both are empty without derivatives by hand.
    left: Vec<Lanes>,
    right: Vec<Lanes>,
    /// S of the block, and the current one.
    tangents: [LawTangents; 2],
}

impl Derivatives {
    /// Memory for a pack with this number of stations in D components, and for an update of tangents if `by_hand`.
    pub fn new<K: Directions, const D: usize>(stations: usize, by_hand: bool) -> Self {
        let flanks = D - 1;
        let forces = stations * (flanks * FLANK_FORCES + 1) + 1;
        let arguments = stations * (flanks * FLANK_ARGUMENTS + ARGUMENTS) + ARGUMENTS;
        let zeros = |len| vec![Lanes::zero(); len];
        let [left, right] = [forces * height::<K>(), arguments * K::COUNT];
        Self {
            block: zeros(height::<K>() * K::COUNT),
            stations,
            flanks,
            left: zeros(if by_hand { left } else { 0 }),
            right: zeros(if by_hand { right } else { 0 }),
            tangents: Default::default(),
        }
    }

    /// Sets the current tangents; those of the block too unless `update`.
    #[inline(always)]
    pub fn set_tangents(&mut self, tangents: &LawTangents, update: bool) {
        self.tangents[1] = *tangents;
        if !update {
            self.tangents[0] = *tangents;
        }
    }

    /// Records L.
    #[inline(always)]
    fn record_forces<K: Directions, R: VaryingRing<Lanes, D>, const D: usize>(
        &mut self,
        linear: &Linearised<'_, R, D>,
    ) {
        let mut left = self.left.chunks_exact_mut(height::<K>());
        linear.for_each_force(|b, ring| {
            if let Some(to) = left.next() {
                let rows = rows::<_, K, D>(&b, &ring);
                to.iter_mut()
                    .zip(in_block::<K, _>(&rows))
                    .for_each(|(to, row)| *to = *row);
            }
        });
    }

    /// The derivatives with the current tangents.
    #[inline(never)]
    pub fn current<'a, K: Directions>(&'a self, work: &'a mut UpdateWork) -> &'a [Lanes] {
        let [then, now] = &self.tangents;
        if now == then {
            return &self.block;
        }
        let UpdateWork { through, out } = work;
        let mut changes = Changes {
            right: self.right.chunks_exact(K::COUNT),
            through,
            forces: [0; MOST_FORCES],
            count: 0,
            force: 0,
        };
        for (now, then) in now.stations.iter().zip(&then.stations).take(self.stations) {
            for (now, then) in now.flanks.iter().zip(&then.flanks).take(self.flanks) {
                changes.add::<K, FLANK_ARGUMENTS>(now, then);
            }
            changes.add::<K, ARGUMENTS>(&[now.ring], &[then.ring]);
        }
        changes.add::<K, ARGUMENTS>(&[now.stack], &[then.stack]);
        let Changes { forces, count, .. } = changes;
        let left = |force: usize, row: usize| self.left[force * height::<K>() + row];
        // Four forces at a time, so that an entry is read and written once for all of them.
        let fours = through[..count].chunks_exact(4).zip(forces.chunks_exact(4));
        let rest = count - count % 4;
        let rows = out.chunks_exact_mut(K::COUNT).zip(self.block.chunks_exact(K::COUNT));
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

/// The derivatives of some cells: those of a pack, and those of their transport quantities.
pub struct Columns<'a> {
    pub(super) cells: &'a [usize],
    pub(super) derivatives: &'a mut Derivatives,
    pub(super) transports: &'a mut [Transport<[f64; MOST]>],
}

impl Columns<'_> {
    /// Records the derivatives of balance, transport quantities and arguments of the laws in a direction: the `value` of each.
    #[inline(always)]
    pub(super) fn record<K: Directions, T: Copy>(
        &mut self,
        direction: usize,
        (rows, transport, arguments): (&[T; MOST_ROWS], &Transport<T>, &LawArguments<T>),
        value: impl Fn(T) -> Lanes,
    ) {
        let Derivatives {
            block,
            stations,
            flanks,
            right,
            ..
        } = &mut *self.derivatives;
        for (row, block) in in_block::<K, _>(rows).zip(block.chunks_exact_mut(K::COUNT)) {
            block[direction] = value(*row);
        }
        for (figure, slope) in transport.each().into_iter().enumerate() {
            for (&cell, slope) in self.cells.iter().zip(value(*slope).to_array()) {
                self.transports[cell].each_mut()[figure][direction] = slope;
            }
        }
        let mut right = right.iter_mut().skip(direction).step_by(K::COUNT);
        let mut put = |argument: &T| {
            if let Some(to) = right.next() {
                *to = value(*argument);
            }
        };
        for station in &arguments.stations[..*stations] {
            station.flanks[..*flanks].as_flattened().iter().for_each(&mut put);
            station.ring.iter().for_each(&mut put);
        }
        arguments.stack.iter().for_each(put);
    }

    /// Records the derivatives by hand in the directions of the cells' own unknowns and of the pulley, and L.
    #[inline(always)]
    pub(crate) fn record_by_hand<K: Directions, R: VaryingRing<Lanes, D>, const D: usize>(
        &mut self,
        ring: &R,
        evaluated: Evaluated<'_, D>,
    ) {
        let linear = Linearised::new(ring, evaluated);
        for k in (0..K::DRIFT).chain(K::SHEAVE..K::COUNT) {
            let mut arguments = LawArguments::zero();
            let (b, ring) = linear.vary(Direction::of::<K>(k), &mut arguments);
            let rows = rows::<_, K, D>(&b, &ring);
            self.record::<K, _>(k, (&rows, &b.transport, &arguments), |value| value);
        }
        self.derivatives.record_forces::<K, _, D>(&linear);
    }
}

/// Working memory of [`Derivatives::current`].
#[derive(Clone, Debug)]
pub(crate) struct UpdateWork {
    through: Box<Through>,
    out: Vec<Lanes>,
}

impl UpdateWork {
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
const fn height<K: Directions>() -> usize {
    K::COUNT - 1 + RESULTANT
}

/// The rows of a balance without that of the content.
#[inline(always)]
fn in_block<K: Directions, T>(rows: &[T; MOST_ROWS]) -> impl Iterator<Item = &T> {
    let (before, after) = rows[..K::COUNT + RESULTANT].split_at(K::CONTENT);
    before.iter().chain(&after[1..])
}
