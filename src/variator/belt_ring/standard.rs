//! The rings that `ring.model` and `ring.spatial` choose: `ALE0`, `ALE`, and `ALE` in space.

use crate::reference_curve::TwoPulley;
use crate::variator::assembly::packed::{deflecting_equations, guided_equations};
use crate::variator::belt::Belt;
use crate::variator::belt::equations::Assembly;
use crate::variator::belt::ring::BeltRing;
use crate::variator::mesh::belt_mesh::{BeltMesh, CellDivision};
use crate::variator::mesh::layout::RingUnknowns;
use crate::variator::settings::parameters::{Mesh, Parameters, RingModel};

/// `ALE0`: the ring follows the reference curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ale0;

/// `ALE`: the ring deflects in D components, 2 or 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ale<const D: usize = 2>;

/// Cells of a ring that deflects.
#[must_use]
pub fn cells_of_deflecting(mesh: &Mesh) -> CellDivision {
    let per_element = mesh.cells_per_element as usize;
    CellDivision {
        per_element,
        // Full integration of the membrane needs at least three points in an element.
        points: 2 + usize::from(per_element == 1),
    }
}

impl BeltRing for Ale0 {
    fn name(&self) -> &'static str {
        "ALE0"
    }

    fn cells(&self, _mesh: &Mesh) -> CellDivision {
        CellDivision {
            per_element: 1,
            points: 2,
        }
    }

    fn unknowns(&self, _parameters: &Parameters, _mesh: &BeltMesh, _curve: &TwoPulley) -> RingUnknowns {
        RingUnknowns::TENSION
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        guided_equations::<TwoPulley>(belt, true)
    }
}

impl<const D: usize> BeltRing for Ale<D> {
    fn name(&self) -> &'static str {
        "ALE"
    }

    fn cells(&self, mesh: &Mesh) -> CellDivision {
        cells_of_deflecting(mesh)
    }

    fn unknowns(&self, _parameters: &Parameters, mesh: &BeltMesh, _curve: &TwoPulley) -> RingUnknowns {
        RingUnknowns::deflection(D, mesh)
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
