//! The trait of a ring model of a variator.

use crate::reference_curve::TwoPulley;
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::belt::equations::Assembly;
use crate::variator::mesh::belt_mesh::BeltMesh;
use crate::variator::mesh::layout::Layout;
use crate::variator::settings::ParameterError;
use crate::variator::settings::parameters::{Mesh, Parameters};
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

    /// The mesh of a belt with this ring, of the given sizes.
    fn mesh(&self, sizes: &Mesh) -> BeltMesh;

    /// The unknowns of a belt with this ring, on its mesh.
    fn layout(&self, parameters: &Parameters, mesh: &BeltMesh, curve: &TwoPulley) -> Layout;

    /// Equations of ring, elements and contact of a belt with this ring.
    fn equations(&self, belt: &Belt) -> Box<dyn Assembly>;

    /// Absolute tolerance of the speed of the ring's nodes, m/s: `of_place` limits the error of
    /// their place over a step, `of_sliding` that of their sliding on the elements.
    fn speed_error(&self, of_place: f64, _of_sliding: f64) -> f64 {
        of_place
    }

    /// Largest drift of the ring in a step, m.
    fn longest_drift(&self, _belt: &Belt) -> f64 {
        f64::INFINITY
    }

    /// Where this ring starts, if it has no steady state of its own: on another ring, on the same
    /// mesh.
    fn starts_on(&self) -> Option<StartsOn> {
        None
    }
}

/// A ring, and the start state of a belt from the state of another belt, with that ring.
pub type StartsOn = (Arc<dyn BeltRing>, fn(&Belt, &Belt, &State) -> State);
