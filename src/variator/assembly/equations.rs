//! The equations of ring, elements and contact: one implementation for rings whose mesh stands still
//! ([`PackedCells`](crate::variator::assembly::packed::PackedCells)), one for rings that travel with theirs.

use crate::contact::Friction;
use crate::pulley::PerPulley;
use crate::ring::model::{Energy, Shape};
use crate::scalar::Lanes;
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::solver::sdirk::Geometry;
use crate::tape::Tape;
use crate::variator::assembly::sums::{PulleyLoad, ResultantSlopes};
use crate::variator::belt::Belt;
use crate::variator::cell::sample::Sample;
use crate::variator::law::place::CellLaw;
use std::fmt::Debug;

/// The belt, and the laws in force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InForce<'a> {
    pub belt: &'a Belt,
    pub law: &'a CellLaw,
    pub friction: &'a Friction,
}

/// Equations of ring and elements. It keeps derivatives and working memory. Results depend on the arguments alone; those of
/// [`Assembly::jacobian`] depend on the kept derivatives too.
pub(crate) trait Assembly: Debug + Send + Sync {
    /// A copy with the same kept derivatives.
    fn boxed(&self) -> Box<dyn Assembly>;

    /// Adds the equations of the belt to `out`; returns its loads on the pulleys.
    fn residual(&mut self, acting: InForce<'_>, view: View<'_>, out: &mut [f64]) -> PerPulley<PulleyLoad>;

    /// Adds the derivatives of the equations, with the factors α of ẏ and β of q, to the matrix, and those of the resultants
    /// of the contact forces to their slopes; returns the loads on the pulleys. Derivatives of an earlier call are used where they are
    /// good for Newton's method; if a `geometry` is given, as it says.
    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        slopes: [f64; 2],
        geometry: Option<Geometry>,
        out: (&mut Arrow, &mut ResultantSlopes),
    ) -> PerPulley<PulleyLoad>;

    /// Values at the stations of each group of cells.
    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]);

    /// Energies, J, and damping loss, W, of a ring that has elements of its own; else zero.
    fn ring_energy(&self, _belt: &Belt, _view: View<'_>) -> (Energy, f64) {
        (Energy::default(), 0.0)
    }

    /// Places the nodes of a ring that travels with its mesh on `shape`: their unknowns, if it is such a ring.
    fn placed_on(&self, _shape: Shape<'_>) -> Option<Vec<f64>> {
        None
    }

    /// Drops the kept derivatives: the next Jacobian evaluates all of them.
    fn forget_derivatives(&mut self) {}

    /// Evaluates the kept derivatives at the places that were read from a tape.
    fn restore_derivatives(&mut self, _acting: InForce<'_>) {}

    /// Writes to a tape, or reads from it, the places of the kept derivatives.
    fn serialize_derivatives(&mut self, _belt: &Belt, _tape: &mut Tape<'_>) {}

    /// Number of packs of cells that were differentiated, and of those that got new slopes of their laws alone.
    fn differentiations(&self) -> [u64; 2] {
        [0; 2]
    }

    /// Largest difference between derivatives by hand and by forward differentiation, as a share of the largest entry
    /// of its column.
    #[cfg(test)]
    fn worst_derivative(&self, _acting: InForce<'_>, _view: View<'_>, _alpha: f64) -> f64 {
        f64::NAN
    }
}

impl Clone for Box<dyn Assembly> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}
