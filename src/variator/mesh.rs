//! The border-aligned mesh: five segments, each divided into ring elements, each element into chain cells.
//!
//! Element borders lie on the arc borders for every Θ, so every quadrature point stays on its own arc or strand and all
//! integrals are smooth in Θ. Elements are graded towards the arc borders, where the contact begins (pressure rises over
//! about 5 mm) and the ring has its bending boundary layer (√(EI/T) ≈ 2 mm).

use super::parameters::{Mesh, RingModel};
use crate::ring::mesh::{Spacing, divide, parts};

pub use crate::ring::mesh::{Element, Station};

/// Secondary pulley in arrays over pulleys: it comes first along ξ.
pub const S: usize = 0;
/// Primary pulley in arrays over pulleys.
pub const P: usize = 1;

/// Grading of the arcs: an element at the border has 1 − this of the mean size.
const ARC_GRADING: f64 = 0.8;
/// Grading of the strands.
const STRAND_GRADING: f64 = 0.88;

/// A chain cell.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Ring element it lies in.
    pub element: usize,
    /// Pulley whose sheaves it can touch: [`S`] or [`P`].
    pub pulley: usize,
    /// Whether it lies on an arc.
    pub arc: bool,
    /// Its left face.
    pub face: Station,
    /// Quadrature points.
    pub stations: Vec<Station>,
}

/// Elements and cells around the loop; the first node is at ξ = 0.
#[derive(Clone, Debug)]
pub struct BeltMesh {
    /// Ring elements.
    pub elements: Vec<Element>,
    /// Chain cells.
    pub cells: Vec<Cell>,
    /// Cells in each element.
    pub cells_per_element: usize,
    /// Quadrature points in each cell.
    pub points: usize,
}

impl BeltMesh {
    /// Mesh of a belt on two pulleys with this ring model.
    #[must_use]
    pub fn new(mesh: &Mesh, ring: RingModel) -> Self {
        let half = (mesh.secondary_arc / 2) as usize;
        let (strand, arc) = (mesh.strand as usize, mesh.primary_arc as usize);
        let counts = [half, strand, arc, strand, half];
        let cells_per_element = if ring == RingModel::Ale0 {
            1
        } else {
            mesh.cells_per_element as usize
        };
        let points = match ring {
            RingModel::Ale0 => 2,
            // Full integration of the membrane needs three points or more in an element.
            RingModel::Ale => 2 + usize::from(cells_per_element == 1),
            // A ring with elements of its own sags between the points that carry it, q d⁴/(384 EI) or 2 µm at the widest of
            // two points a cell.
            RingModel::Rcm | RingModel::Ancf => 3,
        };
        let mut elements = Vec::new();
        let mut cells = Vec::new();
        for (segment, &count) in counts.iter().enumerate() {
            let spacing = match segment {
                0 => Spacing::End(ARC_GRADING),
                2 => Spacing::Both(ARC_GRADING),
                4 => Spacing::Start(ARC_GRADING),
                _ => Spacing::Both(STRAND_GRADING),
            };
            for element in divide(segment, count, spacing) {
                for (face, stations) in parts(&element, cells_per_element, points) {
                    let middle = 0.5 * (stations[0].fraction + stations[stations.len() - 1].fraction);
                    let pulley = match segment {
                        2 => P,
                        1 if middle > 0.5 => P,
                        3 if middle < 0.5 => P,
                        _ => S,
                    };
                    cells.push(Cell {
                        element: elements.len(),
                        pulley,
                        arc: segment % 2 == 0,
                        face,
                        stations,
                    });
                }
                elements.push(element);
            }
        }
        Self {
            elements,
            cells,
            cells_per_element,
            points,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_filled_and_weights_sum_to_one() {
        let mesh = BeltMesh::new(&super::super::parameters::Parameters::default().mesh, RingModel::Ale);
        for segment in 0..5 {
            let sum: f64 = mesh
                .elements
                .iter()
                .filter(|e| e.segment == segment)
                .map(|e| e.share)
                .sum();
            assert!((sum - 1.0).abs() < 1e-14);
        }
        for element in 0..mesh.elements.len() {
            let of_element = mesh.cells.iter().filter(|c| c.element == element);
            let sum: f64 = of_element.flat_map(|c| &c.stations).map(|s| s.weight).sum();
            assert!((sum - 1.0).abs() < 1e-14);
        }
    }
}
