//! The border-aligned mesh: five segments, each divided into ring elements, each element into chain cells.
//!
//! Element borders lie on the arc borders for every Θ, so every quadrature point stays on its own arc or strand and all
//! integrals are smooth in Θ. Elements are graded towards the arc borders, where the contact begins (pressure rises over
//! about 5 mm) and the ring has its bending boundary layer (√(EI/T) ≈ 2 mm).

use super::parameters::Mesh;
use crate::ring::kinematics::Hermite;
use std::f64::consts::TAU;

/// Secondary pulley in arrays over pulleys: it comes first along ξ.
pub const S: usize = 0;
/// Primary pulley in arrays over pulleys.
pub const P: usize = 1;

/// Grading of the arcs: an element at the border has 1 − this of the mean size.
const ARC_GRADING: f64 = 0.6;
/// Grading of the strands.
const STRAND_GRADING: f64 = 0.88;

/// A quadrature point of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Fraction of the segment.
    pub fraction: f64,
    /// Hermite functions there.
    pub shape: Hermite,
    /// dξ as a fraction of the element length.
    pub weight: f64,
    /// Fraction of the cell: weight of its right face.
    pub right: f64,
}

/// A ring element.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// Segment of the reference curve.
    pub segment: usize,
    /// Start as a fraction of the segment.
    pub start: f64,
    /// Length as a fraction of the segment.
    pub share: f64,
}

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
}

fn graded(s: f64, grading: f64) -> f64 {
    s - grading / TAU * (TAU * s).sin()
}

/// Nodes and weights of Gauss's rule on [−1, 1].
fn gauss(points: usize) -> &'static [(f64, f64)] {
    const TWO: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
    const THREE: [(f64, f64); 3] = [
        (-0.774_596_669_241_483_4, 5.0 / 9.0),
        (0.0, 8.0 / 9.0),
        (0.774_596_669_241_483_4, 5.0 / 9.0),
    ];
    const FIVE: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    match points {
        2 => &TWO,
        3 => &THREE,
        _ => &FIVE,
    }
}

fn station(element: &Element, x: f64, weight: f64, right: f64) -> Station {
    Station {
        fraction: element.start + element.share * 0.5 * (1.0 + x),
        shape: Hermite::at(x),
        weight,
        right,
    }
}

/// Divides elements into cells with Gauss points.
pub(crate) fn cells_of(element: &Element, cells: usize, points: usize) -> Vec<(Station, Vec<Station>)> {
    let width = 1.0 / cells as f64;
    (0..cells)
        .map(|c| {
            let left = -1.0 + 2.0 * c as f64 * width;
            let stations = gauss(points)
                .iter()
                .map(|&(eta, w)| {
                    let right = 0.5 * (1.0 + eta);
                    station(element, left + 2.0 * width * right, 0.5 * w * width, right)
                })
                .collect();
            (station(element, left, 0.0, 0.0), stations)
        })
        .collect()
}

impl BeltMesh {
    /// Mesh of a belt on two pulleys.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let half = (mesh.secondary_arc / 2) as usize;
        let (strand, arc) = (mesh.strand as usize, mesh.primary_arc as usize);
        let counts = [half, strand, arc, strand, half];
        let cells_per_element = mesh.cells_per_element as usize;
        // Full integration of the membrane needs three points or more in an element.
        let points = if cells_per_element == 1 { 3 } else { 2 };
        let mut elements = Vec::new();
        let mut cells = Vec::new();
        for (segment, &count) in counts.iter().enumerate() {
            let border = |k: usize| {
                let s = k as f64 / count as f64;
                match segment {
                    0 => 2.0 * graded(0.5 + 0.5 * s, ARC_GRADING) - 1.0,
                    2 => graded(s, ARC_GRADING),
                    4 => 2.0 * graded(0.5 * s, ARC_GRADING),
                    _ => graded(s, STRAND_GRADING),
                }
            };
            for k in 0..count {
                let element = Element {
                    segment,
                    start: border(k),
                    share: border(k + 1) - border(k),
                };
                for (face, stations) in cells_of(&element, cells_per_element, points) {
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
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_filled_and_weights_sum_to_one() {
        let mesh = BeltMesh::new(&super::super::parameters::Parameters::default().mesh);
        for segment in 0..5 {
            let sum: f64 = mesh.elements.iter().filter(|e| e.segment == segment).map(|e| e.share).sum();
            assert!((sum - 1.0).abs() < 1e-14);
        }
        for element in 0..mesh.elements.len() {
            let of_element = mesh.cells.iter().filter(|c| c.element == element);
            let sum: f64 = of_element.flat_map(|c| &c.stations).map(|s| s.weight).sum();
            assert!((sum - 1.0).abs() < 1e-14);
        }
    }
}
