//! The rings that `ring.model` and `ring.spatial` choose: `ALE0`, `ALE`, and `ALE` in space.

use crate::reference_curve::TwoPulley;
use crate::variator::assembly::packed::{deflecting_equations, guided_equations};
use crate::variator::belt::Belt;
use crate::variator::belt::equations::Assembly;
use crate::variator::belt::ring::BeltRing;
use crate::variator::mesh::belt_mesh::{BeltMesh, CellDivision};
use crate::variator::mesh::layout::Layout;
use crate::variator::settings::parameters::{Mesh, Parameters, RingModel};

/// `ALE0`: the ring follows the reference curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ale0;

/// `ALE`: the ring deflects in D components, 2 or 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ale<const D: usize = 2>;

impl BeltRing for Ale0 {
    fn name(&self) -> &'static str {
        "ALE0"
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        let cells = CellDivision {
            per_element: 1,
            points: 2,
        };
        BeltMesh::new(sizes, cells, true)
    }

    fn layout(&self, _parameters: &Parameters, mesh: &BeltMesh, _curve: &TwoPulley) -> Layout {
        Layout::deflecting(0, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        guided_equations::<TwoPulley>(belt, true)
    }
}

impl<const D: usize> BeltRing for Ale<D> {
    fn name(&self) -> &'static str {
        "ALE"
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        BeltMesh::new(sizes, CellDivision::of_deflecting(sizes), true)
    }

    fn layout(&self, _parameters: &Parameters, mesh: &BeltMesh, _curve: &TwoPulley) -> Layout {
        Layout::deflecting(D, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        deflecting_equations::<D, TwoPulley>(belt, true)
    }
}

impl Parameters {
    /// The ring that `ring.model` and `ring.spatial` choose.
    #[must_use]
    pub fn ring_of_model(&self) -> std::sync::Arc<dyn BeltRing> {
        match (self.ring_model, self.spatial) {
            (RingModel::Ale0, _) => std::sync::Arc::new(Ale0),
            (RingModel::Ale, false) => std::sync::Arc::new(Ale::<2>),
            (RingModel::Ale, true) => std::sync::Arc::new(Ale::<3>),
        }
    }
}
