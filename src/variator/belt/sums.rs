//! Sums over the cells of a belt.

use crate::pulley::{PerPulley, Pulley};

pub use crate::variator::law::arguments::PulleyLoad;

/// Derivatives of the resultants of the contact forces on the belt with respect to every unknown,
/// for the drag of the shafts. The resultants are not rows of the matrix.
#[derive(Clone, Debug)]
pub struct ResultantDerivatives(PerPulley<[Vec<f64>; 2]>);

impl ResultantDerivatives {
    /// Memory for this number of unknowns.
    #[must_use]
    pub fn new(unknowns: usize) -> Self {
        Self(PerPulley::from_fn(|_| [0, 1].map(|_| vec![0.0; unknowns])))
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        for of in self.0.each_mut() {
            for derivatives in of {
                derivatives.fill(0.0);
            }
        }
    }

    /// Derivatives of component `axis` at a pulley with respect to each unknown.
    #[inline(always)]
    pub fn of(&mut self, pulley: Pulley, axis: usize) -> &mut [f64] {
        &mut self.0[pulley][axis]
    }

    /// Derivatives of `weights`·resultant at a pulley with respect to each unknown.
    pub fn along(&self, pulley: Pulley, weights: [f64; 2]) -> impl Iterator<Item = f64> + '_ {
        let [x, y] = &self.0[pulley];
        x.iter().zip(y).map(move |(x, y)| weights[0] * x + weights[1] * y)
    }
}
