//! What a variator requires of a ring model.

use crate::reference_curve::{TwoPulley, TwoPulleyFrame};
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::belt::equations::Assembly;
use crate::variator::mesh::belt_mesh::{BeltMesh, CellDivision};
use crate::variator::mesh::layout::RingUnknowns;
use crate::variator::settings::parameters::{Mesh, Parameters};
use crate::variator::settings::validation::ParameterError;
use nalgebra::Vector2;
use std::fmt::Debug;
use std::sync::Arc;

/// A model of a belt's ring.
pub trait BeltRing: Debug + Send + Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// Checks the parameters that this ring restricts further than [`Parameters::validate`].
    ///
    /// # Errors
    /// The first parameter that does not fit the ring.
    fn check(&self, _parameters: &Parameters) -> Result<(), ParameterError> {
        Ok(())
    }

    /// Cells of an element of the mesh.
    fn cells(&self, mesh: &Mesh) -> CellDivision;

    /// Whether element borders follow the arc borders. If not, elements are spaced evenly along the belt.
    fn is_aligned(&self) -> bool {
        true
    }

    /// Unknowns of the ring beside drift and Θ.
    fn unknowns(&self, parameters: &Parameters, mesh: &BeltMesh, curve: &TwoPulley) -> RingUnknowns;

    /// Equations of ring, elements and contact of a belt with this ring.
    fn equations(&self, belt: &Belt) -> Box<dyn Assembly>;

    /// Directions A_i in (10) along which the deflection at a node is counted in the plane; x and y if there are none.
    fn directions(&self, _belt: &Belt, _frame: &TwoPulleyFrame<f64>, _node: usize) -> Option<[Vector2<f64>; 2]> {
        None
    }

    /// Absolute error, m/s, that does not matter in a speed of the ring's nodes: `of_place` if their places matter over a
    /// step, `of_sliding` if they slide on the elements.
    fn speed_error(&self, of_place: f64, _of_sliding: f64) -> f64 {
        of_place
    }

    /// Longest distance that the ring may drift in a step, m.
    fn longest_drift(&self, _belt: &Belt) -> f64 {
        f64::INFINITY
    }

    /// The ring, on the same mesh, whose start state this one takes over by [`BeltRing::start_from`]; none if this ring
    /// has a steady state of its own.
    fn starts_on(&self) -> Option<Arc<dyn BeltRing>> {
        None
    }

    /// The state of `belt`, which has this ring, in which it starts from the `state` of `other`, which has the ring of
    /// [`BeltRing::starts_on`].
    fn start_from(&self, _belt: &Belt, _other: &Belt, state: &State) -> State {
        state.clone()
    }
}
