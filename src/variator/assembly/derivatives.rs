//! Derivatives of a pack of cells: geometry, and the part of the constitutive laws as L, S, R
//! ([`laws`](crate::variator::cell::laws)). With updated tangents S they are those of the current
//! state.

use crate::scalar::{Lanes, along};
use crate::stack::Transport;
use crate::variator::assembly::kinds::rows;
use crate::variator::cell::degrees::{DegreesOfFreedom, MOST, MOST_ROWS};
use crate::variator::cell::laws::{ARGUMENTS, Arguments, FORCES, OfLaws, Tangents, argument_count};
use crate::variator::cell::variation::{Direction, Linearised};
use crate::variator::rings::ring::VaryingRing;
use num_traits::Zero;

/// Derivatives of a pack of cells.
#[derive(Clone, Debug)]
pub(crate) struct Derivatives {
    /// Direction by direction for each row of the balance.
    block: Vec<Lanes>,
    /// L: for each force, the rows of the block. R: for each argument, the directions. Both are
    /// empty without derivatives by hand.
    force_rows: Vec<Lanes>,
    right: Vec<Lanes>,
    /// S of the block, and the current one.
    tangents: [Vec<Tangents>; 2],
}

impl Derivatives {
    /// Memory for a pack with this number of stations in D components, and for an update of
    /// tangents if `by_hand`.
    pub fn new<K: DegreesOfFreedom, const D: usize>(stations: usize, by_hand: bool) -> Self {
        let laws = if by_hand { stations * D + 1 } else { 0 };
        let zeros = |len| vec![Lanes::zero(); len];
        Self {
            block: zeros(K::DEGREES.rows * K::DEGREES.count),
            force_rows: zeros(laws * FORCES * K::DEGREES.rows),
            right: zeros(laws * ARGUMENTS * K::DEGREES.count),
            tangents: [0, 1].map(|_| vec![Tangents::default(); laws]),
        }
    }

    /// Sets the current tangents; those of the block too unless `update`.
    #[inline(always)]
    pub fn set_tangents(&mut self, tangents: &OfLaws<Tangents>, update: bool) {
        let [then, now] = &mut self.tangents;
        let laws = now.len();
        now.copy_from_slice(&tangents[..laws]);
        if !update {
            then.copy_from_slice(now);
        }
    }

    /// The derivatives with the current tangents.
    #[inline(never)]
    pub fn current<'a, K: DegreesOfFreedom>(&'a self, work: &'a mut UpdateWork) -> &'a [Lanes] {
        let [then, now] = &self.tangents;
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
                let (number, through) = &mut changes[count];
                *number = law * FORCES + force;
                for (column, to) in through[..width].iter_mut().enumerate() {
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
                let by: [Lanes; 4] = std::array::from_fn(|k| force_rows(four[k].0, row));
                let through: [&[Lanes]; 4] = std::array::from_fn(|k| &four[k].1[..width]);
                for (column, to) in to.iter_mut().enumerate() {
                    *to += (by[0] * through[0][column] + by[1] * through[1][column])
                        + (by[2] * through[2][column] + by[3] * through[3][column]);
                }
            }
            for (force, through) in fours.remainder() {
                let by = force_rows(*force, row);
                to.iter_mut()
                    .zip(through)
                    .for_each(|(to, through)| *to += by * *through);
            }
        }
        out
    }
}

/// The derivatives of some cells: those of a pack, and those of their transport quantities.
pub(crate) struct Columns<'a> {
    pub cells: &'a [usize],
    pub derivatives: &'a mut Derivatives,
    pub transports: &'a mut [Transport<[f64; MOST]>],
}

impl Columns<'_> {
    /// Records the derivatives of balance, transport quantities and arguments of the laws in a
    /// direction: the `value` of each.
    #[inline(always)]
    pub(super) fn record<K: DegreesOfFreedom, T: Copy, const D: usize>(
        &mut self,
        direction: usize,
        (rows, transport, arguments): (&[T; MOST_ROWS], &Transport<T>, &OfLaws<Arguments<T>>),
        value: impl Fn(T) -> Lanes,
    ) {
        let width = K::DEGREES.count;
        let Derivatives { block, right, .. } = &mut *self.derivatives;
        for (row, block) in rows.iter().zip(block.chunks_exact_mut(width)) {
            block[direction] = value(*row);
        }
        for (figure, of) in transport.as_array().into_iter().enumerate() {
            for (&cell, derivative) in self.cells.iter().zip(value(*of).to_array()) {
                self.transports[cell].as_mut_array()[figure][direction] = derivative;
            }
        }
        let laws = right.len() / (ARGUMENTS * width);
        for (law, right) in right.chunks_exact_mut(ARGUMENTS * width).enumerate() {
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
    pub(super) fn record_by_hand<K: DegreesOfFreedom, R: VaryingRing<Lanes, D>, const D: usize>(
        &mut self,
        linear: &Linearised<'_, R, D>,
    ) {
        let degrees = K::DEGREES;
        let mut arguments = OfLaws::<Arguments<Lanes>>::default();
        for k in (0..degrees.drift).chain(degrees.sheave..degrees.count) {
            let direction = Direction::from_index::<K>(k);
            let (b, ring) = match direction {
                Direction::Ring(_) if R::MOVES => linear.vary::<true>(direction, &mut arguments),
                _ => linear.vary::<false>(direction, &mut arguments),
            };
            let rows = rows::<_, K, D>(&b, &ring);
            self.record::<K, _, D>(k, (&rows, &b.transport, &arguments), |value| value);
        }
        let force_rows = &mut self.derivatives.force_rows;
        linear.for_each_force(|force, b, ring| {
            let rows = rows::<_, K, D>(&b, &ring);
            force_rows[force * degrees.rows..][..degrees.rows].copy_from_slice(&rows[..degrees.rows]);
        });
    }
}

/// A force with changed tangents, and its (S_new − S) R.
type Change = (usize, [Lanes; MOST]);

/// Working memory of [`Derivatives::current`].
#[derive(Clone, Debug)]
pub(crate) struct UpdateWork {
    changes: Box<OfLaws<[Change; FORCES]>>,
    out: Vec<Lanes>,
}

impl UpdateWork {
    /// For the packs of a ring.
    pub fn new<K: DegreesOfFreedom>() -> Self {
        Self {
            changes: Box::new([[(0, [Lanes::zero(); MOST]); FORCES]; _]),
            out: vec![Lanes::zero(); K::DEGREES.rows * K::DEGREES.count],
        }
    }
}
