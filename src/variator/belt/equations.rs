//! The equations of ring, elements and contact.
//! [`PackedCells`](crate::variator::assembly::packed::PackedCells) implements them for rings on an
//! Eulerian mesh.

use crate::archive::Archive;
use crate::contact::Friction;
use crate::pulley::PerPulley;
use crate::scalar::Lanes;
use crate::solver::Factors;
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::variator::belt::Belt;
use crate::variator::belt::sums::{PulleyLoad, ResultantDerivatives};
use crate::variator::cell::sample::Sample;
use std::fmt::Debug;

/// The belt, and the friction in force.
#[derive(Clone, Copy, Debug)]
pub struct InForce<'a> {
    /// The belt.
    pub belt: &'a Belt,
    /// Friction in force.
    pub friction: &'a Friction,
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
    /// pulleys. Derivatives of an earlier call are reused where they are valid for a simplified
    /// Newton method.
    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        factors: Factors,
        out: (&mut Arrow, &mut ResultantDerivatives),
    ) -> PerPulley<PulleyLoad>;

    /// Values at the stations of each group of cells.
    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]);

    /// Energy, J, and damping loss, W, of a ring with elements of its own; zero for other rings.
    fn ring_energy(&self, _belt: &Belt, _view: View<'_>) -> [f64; 2] {
        [0.0; 2]
    }

    /// Drops the cached derivatives; the next Jacobian evaluates all of them.
    fn forget_derivatives(&mut self) {}

    /// Writes the states of the cached derivatives to an archive, or reads them from it and
    /// evaluates the derivatives.
    fn serialize_derivatives(&mut self, _acting: InForce<'_>, _archive: &mut Archive<'_>) {}

    /// Number of evaluations of all derivatives, and of constitutive tangents alone.
    fn differentiations(&self) -> [u64; 2] {
        [0; 2]
    }
}

impl Clone for Box<dyn Assembly> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
