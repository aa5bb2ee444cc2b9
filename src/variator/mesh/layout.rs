//! Indices of the unknowns: velocities and first-order states; positions follow from q̇ = y.
//!
//! Block k belongs to ring element k: its left node (`ALE`: a_x, b_x, a_y, b_y, in space a_z, b_z),
//! then for each cell the speed V of its left face, the content N of elements of the cell before,
//! and (`ALE0`) the ring tension T at its left face. The border holds what all cells share: ṡ, Θ̇,
//! then for both pulleys, the secondary first, ż, ψ_x and ψ_y, ω, last the multipliers of the gauge
//! conditions or (`ALE0`) the rates of the displaced centres and of the growth.

use crate::pulley::Pulley;
use crate::reference_curve::COORDINATES;
use crate::solver::arrow::Shape;
use crate::variator::mesh::belt_mesh::BeltMesh;
use std::ops::Range;

/// Number of unknowns in the border of every belt.
const GLOBALS: usize = 2 + 4 * Pulley::BOTH.len();
/// Number of gauge conditions, where the ring has nodes.
pub const CONDITIONS: usize = 2;
/// Index of the turn among the coordinates of displaced centres; the others are lengths.
pub const TURN: usize = 1;

/// An unknown of a node: a length, or an angle or slope.
#[derive(Clone, Copy, Debug)]
pub struct NodeUnknown {
    /// Its index.
    pub index: usize,
    /// Whether it is a length.
    pub is_length: bool,
}

/// Indices of the unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Number of ring elements of the mesh.
    pub elements: usize,
    /// Cells in an element.
    pub cells_per_element: usize,
    /// Number of nodes with unknowns; 0 if the ring follows the reference curve and its tension at
    /// each face is an unknown.
    pub nodes: usize,
    /// Unknowns of a node, and of the ring element after it.
    pub per_node: usize,
    /// Bit mask of the unknowns of a node that are lengths; the others are angles or slopes.
    pub lengths: u32,
    /// Components of the deflection from the reference curve at each node, 2 or 3: the unknowns of
    /// a node are value and slope of each component in turn. 0 for other rings.
    pub components: usize,
    /// Index of the first node.
    pub first_node: usize,
    /// Distance of nodes.
    pub next_node: usize,
    /// Index of the first cell.
    pub first_cell: usize,
    /// Distance of the first cells of elements.
    pub next_element: usize,
    /// Distance of cells.
    pub next_cell: usize,
    /// Whether the content of a cell is beside the speed of the next cell.
    pub content_beside_next: bool,
    /// Shape of the Jacobian.
    pub shape: Shape,
}

impl Layout {
    /// With a ring that deflects at each node of the mesh in 2 or 3 `components` (`ALE`), or
    /// follows the reference curve (`ALE0`): 0.
    #[must_use]
    pub fn deflecting(components: usize, mesh: &BeltMesh) -> Self {
        let (elements, cells_per_element) = (mesh.elements.len(), mesh.cells_per_element);
        let per_node = 2 * components;
        let (nodes, per_cell, extra) = if components == 0 {
            (0, 3, COORDINATES - 1)
        } else {
            (elements, 2, CONDITIONS)
        };
        let block = per_node + cells_per_element * per_cell;
        Self {
            elements,
            cells_per_element,
            nodes,
            per_node,
            lengths: 0b01_0101,
            components,
            first_node: 0,
            next_node: block,
            first_cell: per_node,
            next_element: block,
            next_cell: per_cell,
            content_beside_next: cells_per_element > 1,
            shape: Shape {
                blocks: elements,
                block,
                border: GLOBALS + extra,
            },
        }
    }

    /// Whether the ring deflects along z too.
    #[must_use]
    pub fn is_spatial(&self) -> bool {
        self.components == 3
    }

    /// Whether the ring tension is an unknown (`ALE0`). With any other ring s and Θ duplicate
    /// motions of its nodes, so that gauge conditions with multipliers are needed.
    #[must_use]
    pub fn has_tension(&self) -> bool {
        self.nodes == 0
    }

    /// Unknowns that only fill the blocks of the matrix.
    #[must_use]
    pub fn free(&self) -> Range<usize> {
        let per_cell = if self.has_tension() { 3 } else { 2 };
        per_cell * self.cells() + self.per_node * self.nodes..self.drift()
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.elements * self.cells_per_element
    }

    /// Index of unknown `k` of node `node`: a_x, b_x, a_y, b_y, in space a_z, b_z; other ring
    /// models have other unknowns.
    #[must_use]
    pub fn node(&self, node: usize, k: usize) -> usize {
        self.first_node + node % self.nodes.max(1) * self.next_node + k
    }

    /// All unknowns of the nodes.
    pub fn node_unknowns(&self) -> impl Iterator<Item = NodeUnknown> + use<> {
        let layout = *self;
        let each = (0..layout.nodes).flat_map(move |node| (0..layout.per_node).map(move |k| (node, k)));
        each.map(move |(node, k)| NodeUnknown {
            index: layout.node(node, k),
            is_length: layout.lengths >> k & 1 == 1,
        })
    }

    /// Index of the speed V of the elements at the left face of `cell`.
    #[must_use]
    pub fn belt_speed(&self, cell: usize) -> usize {
        let cell = cell % self.cells();
        let (element, of_element) = (cell / self.cells_per_element, cell % self.cells_per_element);
        self.first_cell + element * self.next_element + of_element * self.next_cell
    }

    /// Index of the content N of `cell`. It belongs to the block of the next cell, so that the flow
    /// into a cell depends on nodes of neighbouring blocks only; with one cell per element this
    /// holds for one direction of flow.
    #[must_use]
    pub fn content(&self, cell: usize) -> usize {
        self.belt_speed(cell + usize::from(self.content_beside_next)) + 1
    }

    /// Index of the ring tension at the left face of `cell` (`ALE0`).
    #[must_use]
    pub fn tension(&self, cell: usize) -> usize {
        self.belt_speed(cell) + 2
    }

    /// Index of the drift rate ṡ.
    #[must_use]
    pub fn drift(&self) -> usize {
        self.shape.blocks * self.shape.block
    }

    /// Index of Θ̇.
    #[must_use]
    pub fn theta(&self) -> usize {
        self.drift() + 1
    }

    /// Index of the axial speed ż of a pulley's movable sheave.
    #[must_use]
    pub fn sheave(&self, pulley: Pulley) -> usize {
        self.theta() + 1 + pulley as usize
    }

    /// Index of the tilt of a pulley's sheaves: ψ_x (0) or ψ_y (1).
    #[must_use]
    pub fn tilt(&self, pulley: Pulley, axis: usize) -> usize {
        self.sheave(Pulley::Primary) + 1 + 2 * pulley as usize + axis
    }

    /// Index of the angular speed ω of a pulley.
    #[must_use]
    pub fn shaft_speed(&self, pulley: Pulley) -> usize {
        self.tilt(Pulley::Primary, 1) + 1 + pulley as usize
    }

    /// Index of the multiplier of a gauge condition.
    #[must_use]
    pub fn gauge(&self, condition: usize) -> usize {
        self.globals().end + condition
    }

    /// Index of the rate of a coordinate of displaced centres (`ALE0`): spread, turn, shift along x
    /// and y, growth.
    #[must_use]
    pub fn centre(&self, k: usize) -> usize {
        self.globals().end + k
    }

    /// Indices of the rates of the coordinates of displaced centres, if there are any.
    #[must_use]
    pub fn centres(&self) -> Range<usize> {
        let end = if self.has_tension() { self.len() } else { self.centre(0) };
        self.centre(0)..end
    }

    /// Indices of the global unknowns common to all rings: no gauge multipliers, no displaced
    /// centres.
    #[must_use]
    pub fn globals(&self) -> Range<usize> {
        self.drift()..self.drift() + GLOBALS
    }

    /// Whether each unknown is the rate of a position.
    #[must_use]
    pub fn has_position(&self) -> Vec<bool> {
        let mut has_position = vec![false; self.len()];
        let own = self.node_unknowns().map(|of| of.index).chain(self.centres());
        let shared = [self.drift(), self.theta()].into_iter();
        for i in own.chain(shared).chain(Pulley::BOTH.map(|pulley| self.sheave(pulley))) {
            has_position[i] = true;
        }
        has_position
    }

    /// Number of unknowns.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a belt has unknowns")]
    pub fn len(&self) -> usize {
        self.shape.len()
    }
}
