//! Derivatives of a pack of cells: geometry, and the part of the constitutive laws as L, S, R
//! ([`laws`](crate::variator::cell::laws)). With updated tangents S they are those of the current
//! state.

use super::rows::rows;
use crate::scalar::{Lanes, along};
use crate::stack::Transport;
use crate::variator::cell::laws::{ARGUMENTS, Arguments, FORCES, OfLaws, Tangents, argument_count};
use crate::variator::cell::variation::{Direction, Linearised};
use crate::variator::rings::{Degrees, MOST, MOST_ROWS, RingKind, VaryingRing};
use num_traits::Zero;

#[derive(Clone, Debug)]
pub(crate) struct Derivatives {
    /// Direction by direction for each row of the balance.
    block: Vec<Lanes>,
    /// L: for each force, the rows of the block. R: for each argument, the directions.
    force_rows: Vec<Lanes>,
    right: Vec<Lanes>,
    /// S of the block.
    block_tangents: Vec<Tangents>,
    /// The current S.
    tangents: Vec<Tangents>,
    /// Direction by direction for each transport quantity.
    pub transport: Transport<[Lanes; MOST]>,
}

impl Derivatives {
    /// Memory for a pack with this number of laws.
    pub fn new(degrees: &Degrees, laws: usize) -> Self {
        let zeros = |len| vec![Lanes::zero(); len];
        Self {
            block: zeros(degrees.rows * degrees.count),
            force_rows: zeros(laws * FORCES * degrees.rows),
            right: zeros(laws * ARGUMENTS * degrees.count),
            block_tangents: vec![Tangents::default(); laws],
            tangents: vec![Tangents::default(); laws],
            transport: Transport::default().map(|()| [Lanes::zero(); MOST]),
        }
    }

    /// Sets the current tangents; those of the block too unless `update`.
    #[inline(always)]
    pub fn set_tangents(&mut self, tangents: &OfLaws<Tangents>, update: bool) {
        let laws = self.tangents.len();
        self.tangents.copy_from_slice(&tangents[..laws]);
        if !update {
            self.block_tangents.copy_from_slice(&self.tangents);
        }
    }

    /// The derivatives with the current tangents.
    #[inline(never)]
    pub fn current<'a, K: RingKind<D>, const D: usize>(&'a self, work: &'a mut UpdateWork) -> &'a [Lanes] {
        let (then, now) = (&self.block_tangents, &self.tangents);
        if now == then {
            return &self.block;
        }
        let width = K::DEGREES.count;
        let (changes, out) = (work.changes.as_flattened_mut(), &mut work.out);
        let mut count = 0;
        let laws = now.iter().zip(then).zip(self.right.chunks_exact(ARGUMENTS * width));
        for (law, ((now, then), right)) in laws.enumerate() {
            let right: [&[Lanes]; ARGUMENTS] = std::array::from_fn(|k| &right[k * width..][..width]);
            for (force, (now, then)) in
                now.iter().zip(then).enumerate().filter(|(_, (now, then))| now != then)
            {
                let by: Arguments<Lanes> = std::array::from_fn(|k| now[k] - then[k]);
                let change = &mut changes[count];
                change.force = law * FORCES + force;
                for (column, to) in change.through[..width].iter_mut().enumerate() {
                    *to = along(&by, &right.map(|right| right[column]));
                }
                count += 1;
            }
        }
        let force_rows = |force: usize, row: usize| self.force_rows[force * K::DEGREES.rows + row];
        // Four forces at a time, so that an entry is read and written once for all of them.
        let fours = changes[..count].chunks_exact(4);
        let rows = out.chunks_exact_mut(width).zip(self.block.chunks_exact(width));
        for (row, (to, block)) in rows.enumerate() {
            to.copy_from_slice(block);
            for four in fours.clone() {
                let by: [Lanes; 4] = std::array::from_fn(|k| force_rows(four[k].force, row));
                let through: [&[Lanes]; 4] = std::array::from_fn(|k| &four[k].through[..width]);
                for (column, to) in to.iter_mut().enumerate() {
                    *to += (by[0] * through[0][column] + by[1] * through[1][column])
                        + (by[2] * through[2][column] + by[3] * through[3][column]);
                }
            }
            for Change { force, through } in fours.remainder() {
                let by = force_rows(*force, row);
                to.iter_mut()
                    .zip(through)
                    .for_each(|(to, through)| *to += by * *through);
            }
        }
        out
    }

    /// Records the derivatives of balance, transport quantities and arguments of the laws in a
    /// direction: the `value` of each.
    #[inline(always)]
    pub(super) fn record<K: RingKind<D>, T: Copy, const D: usize>(
        &mut self,
        direction: usize,
        rows: &[T; MOST_ROWS],
        transport: &Transport<T>,
        arguments: &OfLaws<Arguments<T>>,
        value: impl Fn(T) -> Lanes,
    ) {
        let width = K::DEGREES.count;
        for (row, block) in rows.iter().zip(self.block.chunks_exact_mut(width)) {
            block[direction] = value(*row);
        }
        self.transport.flow[direction] = value(transport.flow);
        self.transport.density[direction] = value(transport.density);
        let laws = self.tangents.len();
        for (law, right) in self.right.chunks_exact_mut(ARGUMENTS * width).enumerate() {
            // The other arguments are zero, and remain so.
            let count = argument_count::<D>(law, laws);
            for (argument, right) in arguments[law][..count].iter().zip(right.chunks_exact_mut(width)) {
                right[direction] = value(*argument);
            }
        }
    }

    /// Records the derivatives by hand in the directions of the cells' own unknowns and of the
    /// pulley, and L.
    #[inline(always)]
    pub(super) fn record_by_hand<K: RingKind<D>, R: VaryingRing<Lanes, D>, const D: usize>(
        &mut self,
        linear: &Linearised<'_, R, D>,
    ) {
        let degrees = K::DEGREES;
        let mut arguments = OfLaws::<Arguments<Lanes>>::default();
        for k in (0..degrees.drift).chain(degrees.sheave..degrees.count) {
            let direction = Direction::from_index(&degrees, k);
            let (b, ring) = match direction {
                Direction::Ring(_) if R::MOVES => linear.vary::<true>(direction, &mut arguments),
                _ => linear.vary::<false>(direction, &mut arguments),
            };
            let rows = rows::<_, K, D>(&b, &ring);
            self.record::<K, _, D>(k, &rows, &b.transport, &arguments, |value| value);
        }
        let force_rows = &mut self.force_rows;
        linear.for_each_force(|force, b, ring| {
            let rows = rows::<_, K, D>(&b, &ring);
            force_rows[force * degrees.rows..][..degrees.rows].copy_from_slice(&rows[..degrees.rows]);
        });
    }
}

/// A force with changed tangents, and its (S_new − S) R.
#[derive(Clone, Copy, Debug)]
struct Change {
    force: usize,
    through: [Lanes; MOST],
}

#[derive(Clone, Debug)]
pub(crate) struct UpdateWork {
    changes: Box<OfLaws<[Change; FORCES]>>,
    out: Vec<Lanes>,
}

impl UpdateWork {
    pub fn new(degrees: &Degrees) -> Self {
        let unchanged = Change {
            force: 0,
            through: [Lanes::zero(); MOST],
        };
        Self {
            changes: Box::new([[unchanged; FORCES]; _]),
            out: vec![Lanes::zero(); degrees.rows * degrees.count],
        }
    }
}
