//! The equations of ring, elements and contact.
//! [`PackedCells`](crate::variator::assembly::packed::PackedCells) implements them for rings on an
//! Eulerian mesh.

use crate::archive::Archive;
use crate::contact::Friction;
use crate::pulley::{PerPulley, Pulley};
use crate::scalar::Lanes;
use crate::solver::arrow::Arrow;
use crate::solver::{Factors, View};
use crate::variator::belt::Belt;
use crate::variator::cell::sample::Sample;
use std::fmt::Debug;

pub use crate::variator::law::arguments::PulleyLoad;

/// The belt, and the friction in force.
#[derive(Clone, Copy, Debug)]
pub struct InForce<'a> {
    /// The belt.
    pub belt: &'a Belt,
    /// Friction in force.
    pub friction: &'a Friction,
}

/// Of a ring with elements of its own; zero for other rings.
#[derive(Clone, Copy, Debug, Default)]
pub struct RingEnergy {
    /// Energy, J.
    pub energy: f64,
    /// Loss to damping, W.
    pub loss: f64,
}

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

/// Equations of ring and elements, with cached derivatives and working memory. Results depend on
/// the arguments alone; those of [`Assembly::jacobian`] also depend on the cached derivatives.
pub trait Assembly: Debug + Send + Sync {
    /// A copy with the same cached derivatives.
    fn boxed(&self) -> Box<dyn Assembly>;

    /// Adds the equations of the belt to `out`; returns its loads on the pulleys.
    fn residual(&mut self, acting: InForce<'_>, view: View<'_>, out: &mut [f64]) -> PerPulley<PulleyLoad>;

    /// Adds the derivatives of the equations, with the factors α of ẏ and β of q, to the matrix,
    /// and those of the resultants of the contact forces to theirs; returns the loads on the
    /// pulleys. Derivatives of an earlier call are reused where they are valid.
    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        factors: Factors,
        matrix: &mut Arrow,
        resultants: &mut ResultantDerivatives,
    ) -> PerPulley<PulleyLoad>;

    /// Values at the stations of each group of cells. Returns the energy of a ring with elements of
    /// its own.
    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]) -> RingEnergy;

    /// Drops the cached derivatives; the next Jacobian evaluates all of them.
    fn forget_derivatives(&mut self) {}

    /// Writes the states of the cached derivatives to an archive, or reads them from it and
    /// evaluates the derivatives.
    fn serialize_derivatives(&mut self, _acting: InForce<'_>, _archive: &mut Archive<'_>) {}

    /// How often all derivatives were evaluated, not constitutive tangents alone.
    fn differentiations(&self) -> u64 {
        0
    }
}

impl Clone for Box<dyn Assembly> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
