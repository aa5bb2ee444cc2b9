//! The trait of a ring model of a variator.

use crate::reference_curve::{TwoPulley, TwoPulleyFrame};
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::belt::equations::Assembly;
use crate::variator::mesh::belt_mesh::{BeltMesh, CellDivision};
use crate::variator::mesh::layout::RingUnknowns;
use crate::variator::settings::ParameterError;
use crate::variator::settings::parameters::{Mesh, Parameters};
use nalgebra::Vector2;
use std::fmt::Debug;
use std::sync::Arc;

/// A model of a belt's ring.
pub trait BeltRing: Debug + Send + Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// Checks restrictions of this ring on the parameters beyond [`Parameters::validate`].
    ///
    /// # Errors
    /// The first parameter that does not fit the ring.
    fn check(&self, _parameters: &Parameters) -> Result<(), ParameterError> {
        Ok(())
    }

    /// Division of a mesh element into cells.
    fn cells(&self, mesh: &Mesh) -> CellDivision;

    /// Whether element borders follow the arc borders. If not, elements are spaced evenly along the belt.
    fn is_aligned(&self) -> bool {
        true
    }

    /// Unknowns of the ring other than drift and Θ.
    fn unknowns(&self, parameters: &Parameters, mesh: &BeltMesh, curve: &TwoPulley) -> RingUnknowns;

    /// Equations of ring, elements and contact of a belt with this ring.
    fn equations(&self, belt: &Belt) -> Box<dyn Assembly>;

    /// Directions A_i of (10) of the in-plane deflection at a node; `None` for x and y.
    fn directions(&self, _belt: &Belt, _frame: &TwoPulleyFrame<f64>, _node: usize) -> Option<[Vector2<f64>; 2]> {
        None
    }

    /// Absolute tolerance of the speed of the ring's nodes, m/s: `of_place` limits the error of their place over a step,
    /// `of_sliding` that of their sliding on the elements.
    fn speed_error(&self, of_place: f64, _of_sliding: f64) -> f64 {
        of_place
    }

    /// Largest drift of the ring in a step, m.
    fn longest_drift(&self, _belt: &Belt) -> f64 {
        f64::INFINITY
    }

    /// The ring, on the same mesh, from whose steady state [`BeltRing::start_from`] starts this ring; `None` if this
    /// ring has a steady state of its own.
    fn starts_on(&self) -> Option<Arc<dyn BeltRing>> {
        None
    }

    /// Start state of `belt`, with this ring, from the `state` of `other`, with the ring of [`BeltRing::starts_on`].
    fn start_from(&self, _belt: &Belt, _other: &Belt, state: &State) -> State {
        state.clone()
    }
}
