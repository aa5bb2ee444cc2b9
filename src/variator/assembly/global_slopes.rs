//! Derivatives of the global rows, and of the resultants of the contact forces, with respect to the global unknowns. They
//! are summed in lanes before they are added to the matrix.

use crate::pulley::{PerPulley, Pulley};
use crate::scalar::Lanes;
use crate::solver::arrow::Arrow;
use crate::variator::assembly::pack::global_unknowns;
use crate::variator::belt::Belt;
use crate::variator::belt::sums::ResultantSlopes;
use crate::variator::cell::directions::{Directions, MOST, RESULTANT};
use crate::variator::mesh::belt_mesh::Group;
use num_traits::Zero;

/// Sums over the cells of each pulley, row by row.
#[derive(Clone, Debug)]
pub(crate) struct GlobalSlopes {
    sums: PerPulley<Vec<Lanes>>,
}

impl GlobalSlopes {
    /// Memory for the directions from s on and the resultants.
    pub fn new<K: Directions>() -> Self {
        let globals = K::COUNT - K::DRIFT;
        Self {
            sums: PerPulley::from_fn(|_| vec![Lanes::zero(); (globals + RESULTANT) * globals]),
        }
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.sums
            .each_mut()
            .into_iter()
            .for_each(|sums| sums.fill(Lanes::zero()));
    }

    /// Adds the derivatives of a pack in row `k`.
    #[inline(always)]
    pub fn add(&mut self, k: usize, slopes: &[Lanes], group: &Group) {
        let at = k * slopes.len()..(k + 1) * slopes.len();
        for pulley in Pulley::BOTH {
            let on = group.on[pulley];
            if on == Lanes::zero() {
                continue;
            }
            for (sum, slope) in self.sums[pulley][at.clone()].iter_mut().zip(slopes) {
                *sum += *slope * on;
            }
        }
    }

    /// Adds the sums to the matrix and to the derivatives of the resultants.
    pub fn spill<K: Directions>(&self, belt: &Belt, (out, resultants): (&mut Arrow, &mut ResultantSlopes)) {
        for pulley in Pulley::BOTH {
            let mut at = [0; MOST];
            global_unknowns::<K>(&belt.layout, pulley, &mut at);
            let at = &at[K::DRIFT..K::COUNT];
            for (k, row) in self.sums[pulley].chunks_exact(at.len()).enumerate() {
                for (&column, slope) in at.iter().zip(row) {
                    match at.get(k) {
                        Some(&row) => out.add(row, column, slope.sum()),
                        None => resultants.of(pulley, k - at.len())[column] += slope.sum(),
                    }
                }
            }
        }
    }
}
