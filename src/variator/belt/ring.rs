//! The trait of a ring model of a variator.

use crate::reference_curve::TwoPulley;
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::belt::equations::Assembly;
use crate::variator::mesh::belt_mesh::{BeltMesh, CellDivision};
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

    /// The mesh of a belt with this ring, of the given sizes. Unless replaced, it is that of `ALE`.
    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        let per_element = sizes.cells_per_element as usize;
        // Full integration of the membrane needs at least three points in an element.
        let points = 2 + usize::from(per_element == 1);
        BeltMesh::new(sizes, CellDivision { per_element, points })
    }

    /// The unknowns of a belt with this ring, on its mesh.
    fn layout(&self, parameters: &Parameters, mesh: &BeltMesh) -> Layout;

    /// Equations of ring, elements and contact of a belt with this ring.
    fn equations(&self, belt: &Belt) -> Box<dyn Assembly>;

    /// Start and steps, if the nodes move with the material.
    fn material_mesh(&self, _layout: &Layout, _curve: &TwoPulley) -> Option<MaterialMesh> {
        None
    }
}

/// Start and steps of a belt whose ring has nodes that move with the material: it has no steady
/// state of its own.
#[derive(Clone, Debug)]
pub struct MaterialMesh {
    /// Ring of another belt on the same mesh, from whose state it starts.
    pub starts_on: Arc<dyn BeltRing>,
    /// The start state.
    pub start: fn(belt: &Belt, other: &Belt, state: &State) -> State,
    /// Largest drift of the ring in a step, m.
    pub longest_drift: f64,
    /// Largest negligible error of the nodes' speed, per that of sliding.
    pub speed_error: f64,
}
