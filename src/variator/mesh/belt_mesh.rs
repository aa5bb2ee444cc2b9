//! The mesh: five segments of ring elements around the belt, each divided into cells.
//!
//! Element borders follow the arc borders for every Θ, so all integrals are smooth in Θ. Elements
//! are graded towards the arc borders, where contact begins (pressure rises over about 5 mm) and
//! the ring has its bending boundary layer (√(EI/T) ≈ 2 mm).

use crate::pulley::{PerPulley, Pulley};
use crate::ring::mesh::{Spacing, divide, parts};
use crate::scalar::{LANES, Lanes};
use crate::variator::settings::parameters::Mesh;

pub use crate::ring::mesh::{Element, Station};

/// Largest number of quadrature points of a cell.
pub const STATIONS: usize = 3;
/// Points of a cell: its left face, then its quadrature points.
pub const CELL_POINTS: usize = STATIONS + 1;

/// Grading g of the arcs: an element at the border has 1 − g times the mean size.
const ARC_GRADING: f64 = 0.76;
const STRAND_GRADING: f64 = 0.88;

/// A finite volume of the stack of push elements.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Ring element that contains it.
    pub element: usize,
    /// Pulley that it can touch.
    pub pulley: Pulley,
    /// Left face of the cell.
    pub face: Station,
    /// Quadrature points between its faces.
    pub stations: Vec<Station>,
    /// Index of its group.
    pub group: usize,
    /// Lane of the cell in its group.
    pub lane: usize,
}

/// Neighbouring cells on one segment, evaluated together, one in each lane of a register.
#[derive(Clone, Debug)]
pub struct Group {
    /// Cells; the last one is repeated in unused lanes.
    pub cells: [usize; LANES],
    /// Number of lanes in use.
    pub used: usize,
    /// 1 in the lanes in use whose cell can touch the pulley, otherwise 0.
    pub on: PerPulley<Lanes>,
}

impl Group {
    /// 1 in the lanes in use, otherwise 0.
    #[inline(always)]
    #[must_use]
    pub fn in_use(&self) -> Lanes {
        self.on.secondary + self.on.primary
    }
}

/// Cells of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellDivision {
    /// Number of cells in an element.
    pub per_element: usize,
    /// Quadrature points in a cell, 2 to 3.
    pub points: usize,
}

/// Elements and cells around the loop; the first node is at ξ = 0.
#[derive(Clone, Debug)]
pub struct BeltMesh {
    /// Ring elements, from ξ = 0 on.
    pub elements: Vec<Element>,
    /// Cells, in the order of ξ.
    pub cells: Vec<Cell>,
    /// Groups of cells, around the loop.
    pub groups: Vec<Group>,
    /// Cells in each element.
    pub cells_per_element: usize,
    /// Quadrature points in each cell.
    pub points: usize,
}

/// Divides cells into groups and records group and lane in each cell.
fn group(cells: &mut [Cell], elements: &[Element]) -> Vec<Group> {
    let mut groups = Vec::new();
    for segment in cells.chunk_by_mut(|a, b| elements[a.element].segment == elements[b.element].segment) {
        for members in segment.chunks_mut(LANES) {
            let used = members.len();
            let first = groups.last().map_or(0, |g: &Group| g.cells[0] + g.used);
            for (lane, cell) in members.iter_mut().enumerate() {
                (cell.group, cell.lane) = (groups.len(), lane);
            }
            let touches = |pulley: Pulley| {
                std::array::from_fn(|lane| f64::from(members.get(lane).is_some_and(|c| c.pulley == pulley)))
            };
            groups.push(Group {
                cells: std::array::from_fn(|lane| first + lane.min(used - 1)),
                used,
                on: PerPulley::from_fn(|pulley| Lanes::new(touches(pulley))),
            });
        }
    }
    groups
}

impl BeltMesh {
    /// Mesh of a belt on two pulleys with these cells.
    #[must_use]
    pub fn new(mesh: &Mesh, cells: CellDivision) -> Self {
        let half = (mesh.secondary_arc / 2) as usize;
        let (strand, arc) = (mesh.strand as usize, mesh.primary_arc as usize);
        let strand = |segment: usize| divide(segment, strand, Spacing::Both(STRAND_GRADING));
        let elements = divide(0, half, Spacing::End(ARC_GRADING))
            .chain(strand(1))
            .chain(divide(2, arc, Spacing::Both(ARC_GRADING)))
            .chain(strand(3))
            .chain(divide(4, half, Spacing::Start(ARC_GRADING)));
        Self::of_elements(elements.collect(), cells, |segment, middle| match segment {
            1 => middle > 0.5,
            2 => true,
            3 => middle < 0.5,
            _ => false,
        })
    }

    /// Mesh of these elements around the loop. `touches_primary` tells the pulley of a cell from
    /// the segment and the fraction of its middle; other cells can touch the secondary pulley.
    #[must_use]
    pub fn of_elements(
        elements: Vec<Element>,
        cells: CellDivision,
        touches_primary: impl Fn(usize, f64) -> bool,
    ) -> Self {
        let CellDivision { per_element, points } = cells;
        let mut cells = Vec::new();
        for (k, element) in elements.iter().enumerate() {
            for (face, stations) in parts(element, per_element, points) {
                let middle = 0.5 * (stations[0].fraction + stations[stations.len() - 1].fraction);
                cells.push(Cell {
                    element: k,
                    pulley: if touches_primary(element.segment, middle) {
                        Pulley::Primary
                    } else {
                        Pulley::Secondary
                    },
                    face,
                    stations,
                    group: 0,
                    lane: 0,
                });
            }
        }
        let groups = group(&mut cells, &elements);
        Self {
            elements,
            cells,
            groups,
            cells_per_element: per_element,
            points,
        }
    }
}
