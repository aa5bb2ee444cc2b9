//! The rings that `ring.model` and `ring.spatial` choose: `ALE0`, `ALE`, and `ALE` in space.

use crate::variator::assembly::packed::eulerian_equations;
use crate::variator::belt::Belt;
use crate::variator::belt::equations::Assembly;
use crate::variator::belt::ring::BeltRing;
use crate::variator::mesh::belt_mesh::{BeltMesh, CellDivision};
use crate::variator::mesh::layout::Layout;
use crate::variator::rings::deflecting::Ale;
use crate::variator::rings::guided::Ale0;
use crate::variator::settings::parameters::{Mesh, Parameters, RingModel};
use std::sync::Arc;

impl BeltRing for Ale0 {
    fn name(&self) -> &'static str {
        "ALE0"
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        let (per_element, points) = (1, 2);
        BeltMesh::new(sizes, CellDivision { per_element, points })
    }

    fn layout(&self, _parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        Layout::deflecting(0, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(*self, belt, true)
    }
}

impl<const D: usize> BeltRing for Ale<D> {
    fn name(&self) -> &'static str {
        "ALE"
    }

    fn layout(&self, _parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        Layout::deflecting(D, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(*self, belt, true)
    }
}

impl Parameters {
    /// The ring that `ring.model` and `ring.spatial` choose.
    #[must_use]
    pub fn ring_of_model(&self) -> Arc<dyn BeltRing> {
        match (self.ring_model, self.spatial) {
            (RingModel::Ale0, _) => Arc::new(Ale0),
            (RingModel::Ale, false) => Arc::new(Ale::<2>),
            (RingModel::Ale, true) => Arc::new(Ale::<3>),
        }
    }
}
