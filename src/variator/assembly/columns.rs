//! The columns of a pack's derivatives, and those by hand.

use crate::chain::Transport;
use crate::scalar::Lanes;
use crate::variator::assembly::law_part::{LawPart, in_block};
use crate::variator::assembly::pack::Pack;
use crate::variator::assembly::unknowns::rows;
use crate::variator::cell::directions::{Directions, MOST, MOST_ROWS};
use crate::variator::cell::laws::LawArguments;
use crate::variator::cell::variation::{Direction, Evaluated, Linearised};
use crate::variator::rings::ring::VaryingRing;

/// Memory for the derivatives of a pack: a column for each direction.
pub struct Columns<'a> {
    pub(super) pack: &'a Pack,
    pub(super) block: &'a mut [Lanes],
    pub(super) laws: Option<&'a mut LawPart>,
    pub(super) transports: &'a mut [Transport<[f64; MOST]>],
}

impl Columns<'_> {
    /// Records the derivatives of balance, transport quantities and arguments of the laws in a direction.
    #[inline(always)]
    pub fn record<K: Directions>(
        &mut self,
        direction: usize,
        rows: &[Lanes; MOST_ROWS],
        transport: &Transport<Lanes>,
        arguments: &LawArguments<Lanes>,
    ) {
        for (row, block) in in_block::<K>(rows).zip(self.block.chunks_exact_mut(K::COUNT)) {
            block[direction] = *row;
        }
        for (figure, slope) in transport.each().into_iter().enumerate() {
            for (&cell, slope) in self.pack.cells().iter().zip(slope.to_array()) {
                self.transports[cell].each_mut()[figure][direction] = slope;
            }
        }
        if let Some(laws) = &mut self.laws {
            laws.record::<K>(direction, arguments);
        }
    }
}

/// Derivatives by hand in the directions of the cells' own unknowns and of the pulley, and the laws' part.
#[inline(always)]
pub(crate) fn vary_own<K: Directions, R: VaryingRing<Lanes, D>, const D: usize>(
    ring: &R,
    evaluated: Evaluated<'_, D>,
    columns: &mut Columns<'_>,
) {
    let linear = Linearised::new(ring, evaluated);
    for k in (0..K::DRIFT).chain(K::SHEAVE..K::COUNT) {
        let mut arguments = LawArguments::zero();
        let (b, ring) = linear.vary(Direction::of::<K>(k), &mut arguments);
        columns.record::<K>(k, &rows::<_, K, D>(&b, &ring), &b.transport, &arguments);
    }
    if let Some(laws) = &mut columns.laws {
        laws.keep::<K, _, D>(&linear, evaluated.laws);
    }
}
