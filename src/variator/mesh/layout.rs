//! Indices of the unknowns. The unknowns are velocities and first-order states; positions follow from q̇ = y.
//!
//! Block k belongs to ring element k: its left node (`ALE`: a_x, b_x, a_y, b_y, in space a_z, b_z), then for each cell
//! the speed V of its left face, the content N of elements of the cell before, and (`ALE0`) the ring tension T at its left
//! face. The border holds the globals, of `ALE0` also the coordinates of displaced centres.
//!
//! The nodes of a travelling ring have no fixed neighbours among the cells. Its unknowns are in separate groups: V and N of
//! each cell, then the nodes, then unknowns that only fill the blocks. Its equations reorder them for the matrix.

use crate::pulley::Pulley;
use crate::reference_curve::COORDINATES;
use crate::solver::arrow::Shape;
use crate::variator::mesh::belt_mesh::BeltMesh;

/// Places of the global unknowns in the border. Pairs follow each other, the secondary pulley's first.
const DRIFT: usize = 0;
const THETA: usize = 1;
const SHEAVE: usize = 2;
const TILT: usize = 4;
const SHAFT: usize = 8;
const GAUGE: usize = 10;
/// Number of gauge conditions, where the ring has nodes.
pub const CONDITIONS: usize = 2;
/// Number of coordinates of displaced centres, where it has none.
pub const CENTRES: usize = COORDINATES - 1;
/// Index of the turn among them; the others are lengths.
pub const TURN: usize = 1;

/// Unknowns of a ring other than drift and Θ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingUnknowns {
    /// Number of nodes with unknowns; 0 if the ring follows the reference curve.
    pub nodes: usize,
    /// Unknowns of a node and of the element after it.
    pub per_node: usize,
    /// Bit mask of the unknowns of a node that are lengths; the others are angles or slopes.
    pub lengths: u32,
    /// Components of the deflection from the reference curve at each node: 2, or 3 in space. The unknowns of a node are
    /// then value and slope of each component in turn. 0 if the nodes have other unknowns.
    pub components: usize,
    /// Whether the ring tension at each face is an unknown.
    pub tension: bool,
    /// Number and size of the matrix blocks, if the nodes have no fixed neighbours among the cells. Otherwise node k is in
    /// block k, with the cells of element k.
    pub apart: Option<[usize; 2]>,
}

impl RingUnknowns {
    /// The tension at each face, for a ring on the reference curve (`ALE0`).
    pub const TENSION: Self = Self {
        nodes: 0,
        per_node: 0,
        lengths: 0,
        components: 0,
        tension: true,
        apart: None,
    };

    /// Deflection and slope at each node of the mesh in 2 `components`, or 3 in space (`ALE`).
    #[must_use]
    pub fn deflection(components: usize, mesh: &BeltMesh) -> Self {
        Self {
            nodes: mesh.elements.len(),
            per_node: 2 * components,
            lengths: 0b01_0101 & ((1 << (2 * components)) - 1),
            components,
            tension: false,
            apart: None,
        }
    }

    /// Whether unknown `k` of a node is a length; otherwise it is an angle or a slope.
    #[must_use]
    pub fn is_length(&self, k: usize) -> bool {
        self.lengths >> k & 1 == 1
    }
}

/// Indices of the unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Number of ring elements of the mesh.
    pub elements: usize,
    /// Chain cells in an element.
    pub cells_per_element: usize,
    /// Unknowns of the ring.
    pub ring: RingUnknowns,
    /// Node in the middle of the primary arc, opposite node 0.
    pub opposite: usize,
}

impl Layout {
    /// Layout of a mesh with the unknowns of its ring.
    #[must_use]
    pub fn new(mesh: &BeltMesh, ring: RingUnknowns) -> Self {
        Self {
            elements: mesh.elements.len(),
            cells_per_element: mesh.cells_per_element,
            ring,
            opposite: mesh.opposite(),
        }
    }

    /// Components of the deflection from the reference curve; 0 if the ring follows it or has other unknowns.
    #[must_use]
    pub fn components(&self) -> usize {
        self.ring.components
    }

    /// Whether the ring deflects along z too.
    #[must_use]
    pub fn is_spatial(&self) -> bool {
        self.components() == 3
    }

    /// Whether the ring tension is an unknown (`ALE0`).
    #[must_use]
    pub fn has_tension(&self) -> bool {
        self.ring.tension
    }

    /// Whether s and Θ duplicate motions of the ring, so that gauge conditions with multipliers are needed (all but
    /// `ALE0`).
    #[must_use]
    pub fn has_gauge(&self) -> bool {
        !self.has_tension()
    }

    /// Unknowns of the cells, V and N of each.
    #[must_use]
    pub fn cell_unknowns(&self) -> usize {
        2 * self.cells()
    }

    /// Unknowns that only fill the blocks of the matrix.
    #[must_use]
    pub fn free(&self) -> std::ops::Range<usize> {
        match self.ring.apart {
            Some([blocks, size]) => self.cell_unknowns() + self.ring.nodes * self.ring.per_node..blocks * size,
            None => 0..0,
        }
    }

    fn node_size(&self) -> usize {
        2 * self.components()
    }

    fn cell_size(&self) -> usize {
        if self.has_tension() { 3 } else { 2 }
    }

    fn block(&self) -> usize {
        self.node_size() + self.cells_per_element * self.cell_size()
    }

    /// Shape of the Jacobian.
    #[must_use]
    pub fn shape(&self) -> Shape {
        let [blocks, block] = self.ring.apart.unwrap_or([self.elements, self.block()]);
        Shape {
            blocks,
            block,
            border: GAUGE + if self.has_gauge() { CONDITIONS } else { CENTRES },
        }
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.elements * self.cells_per_element
    }

    /// Index of unknown `k` of node `node`: a_x, b_x, a_y, b_y, in space a_z, b_z; other ring models have other unknowns.
    #[must_use]
    pub fn node(&self, node: usize, k: usize) -> usize {
        if self.ring.apart.is_some() {
            return self.cell_unknowns() + (node % self.ring.nodes) * self.ring.per_node + k;
        }
        (node % self.elements) * self.block() + k
    }

    fn cell(&self, cell: usize) -> usize {
        let cell = cell % self.cells();
        if self.ring.apart.is_some() {
            return 2 * cell;
        }
        let (element, c) = (cell / self.cells_per_element, cell % self.cells_per_element);
        element * self.block() + self.node_size() + c * self.cell_size()
    }

    /// Index of the speed V of the elements at the left face of `cell`.
    #[must_use]
    pub fn belt_speed(&self, cell: usize) -> usize {
        self.cell(cell)
    }

    /// Index of the content N of `cell`. It belongs to the block of the next cell, so that the flow into a cell from either
    /// side depends on nodes of neighbouring blocks only. With one cell per element this holds for one direction of
    /// flow only.
    #[must_use]
    pub fn content(&self, cell: usize) -> usize {
        let with = if self.cells_per_element > 1 && self.ring.apart.is_none() {
            cell + 1
        } else {
            cell
        };
        self.cell(with) + 1
    }

    /// Index of the ring tension at the left face of `cell` (`ALE0`).
    #[must_use]
    pub fn tension(&self, cell: usize) -> usize {
        self.cell(cell) + 2
    }

    fn border(&self) -> usize {
        let shape = self.shape();
        shape.blocks * shape.block
    }

    /// Index of the drift rate ṡ.
    #[must_use]
    pub fn drift(&self) -> usize {
        self.border() + DRIFT
    }

    /// Index of Θ̇.
    #[must_use]
    pub fn theta(&self) -> usize {
        self.border() + THETA
    }

    /// Index of the axial speed ż of a pulley's movable sheave.
    #[must_use]
    pub fn sheave(&self, pulley: Pulley) -> usize {
        self.border() + SHEAVE + pulley as usize
    }

    /// Index of the tilt of a pulley's sheaves: ψ_x (0) or ψ_y (1).
    #[must_use]
    pub fn tilt(&self, pulley: Pulley, axis: usize) -> usize {
        self.border() + TILT + 2 * pulley as usize + axis
    }

    /// Index of the angular speed ω of a pulley.
    #[must_use]
    pub fn shaft_speed(&self, pulley: Pulley) -> usize {
        self.border() + SHAFT + pulley as usize
    }

    /// Index of the multiplier of a gauge condition.
    #[must_use]
    pub fn gauge(&self, condition: usize) -> usize {
        self.border() + GAUGE + condition
    }

    /// Index of the rate of a coordinate of displaced centres (`ALE0`): spread, turn, shift along x and y, growth.
    #[must_use]
    pub fn centre(&self, k: usize) -> usize {
        self.border() + GAUGE + k
    }

    /// Indices of the rates of the coordinates of displaced centres, if there are any.
    #[must_use]
    pub fn centres(&self) -> std::ops::Range<usize> {
        let count = if self.has_tension() { CENTRES } else { 0 };
        self.centre(0)..self.centre(count)
    }

    /// Indices of the global unknowns common to all rings: no gauge multipliers, no displaced centres.
    #[must_use]
    pub fn globals(&self) -> std::ops::Range<usize> {
        self.border()..self.border() + GAUGE
    }

    /// Whether each unknown is the rate of a position.
    #[must_use]
    pub fn has_position(&self) -> Vec<bool> {
        let mut has_position = vec![false; self.len()];
        for node in 0..self.ring.nodes {
            for k in 0..self.ring.per_node {
                has_position[self.node(node, k)] = true;
            }
        }
        has_position[self.drift()] = true;
        has_position[self.theta()] = true;
        has_position[self.centres()].fill(true);
        for pulley in Pulley::BOTH {
            has_position[self.sheave(pulley)] = true;
        }
        has_position
    }

    /// Calls `f` with every unknown of the ring's nodes that is a length.
    pub(crate) fn for_each_length_unknown(&self, mut f: impl FnMut(usize)) {
        for node in 0..self.ring.nodes {
            for k in (0..self.ring.per_node).filter(|&k| self.ring.is_length(k)) {
                f(self.node(node, k));
            }
        }
    }

    /// Number of unknowns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.shape().len()
    }

    /// Whether there are no unknowns.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
