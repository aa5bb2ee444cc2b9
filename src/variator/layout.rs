//! Where each unknown stands. The unknowns are velocities and first-order states; positions follow from q̇ = y.
//!
//! Block k belongs to ring element k: its left node (`ALE`: a_x, b_x, a_y, b_y, in space a_z, b_z), then for each cell
//! the speed V of its left face, the element amount N of the cell before, and (`ALE0`) the ring tension T at its left
//! face. The border holds the globals.
//!
//! With a ring that travels with its mesh the cells stand first, each with V and N, then the nodes of the ring, then
//! what is left free in the blocks; [`super::order`] puts them in the order of the matrix.

use super::mesh::BeltMesh;
use super::order::Travelling;
use crate::solver::arrow::Shape;

/// Global unknowns, in the order of the border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Global {
    /// ṡ.
    Drift,
    /// Θ̇.
    Theta,
    /// ż_S, ż_P follow each other, as all pairs below.
    Sheave,
    /// ψ_x, ψ_y of S, then of P.
    Tilt = 4,
    /// ω_S, ω_P.
    Speed = 8,
    /// Multipliers of the gauge (all but `ALE0`).
    Gauge = 10,
}

/// Indices of the unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Number of ring elements.
    pub elements: usize,
    /// Chain cells in an element.
    pub cells_per_element: usize,
    /// Whether nodes deflect (`ALE`) or the tension is an unknown (`ALE0`).
    pub flexible: bool,
    /// Components of the deflection: 2, or 3 in space.
    pub components: usize,
    /// Node in the middle of the primary arc, opposite to node 0.
    pub opposite: usize,
    /// Nodes that travel with the ring (`ANCF`, `RCM`).
    pub travelling: Option<Travelling>,
}

impl Layout {
    /// Layout on a mesh.
    #[must_use]
    pub fn new(mesh: &BeltMesh, flexible: bool, components: usize) -> Self {
        Self {
            elements: mesh.elements.len(),
            cells_per_element: mesh.cells_per_element,
            flexible,
            components,
            opposite: mesh.opposite(),
            travelling: None,
        }
    }

    /// Whether the ring deflects along z too.
    #[must_use]
    pub fn is_spatial(&self) -> bool {
        self.flexible && self.components == 3
    }

    /// Whether the ring tension is an unknown (`ALE0`).
    #[must_use]
    pub fn has_tension(&self) -> bool {
        !self.flexible && self.travelling.is_none()
    }

    /// Unknowns of the cells of a ring that travels.
    pub(super) fn cell_unknowns(&self) -> usize {
        2 * self.cells()
    }

    /// Unknown `k` of an element of a ring that travels: of its own node, then of the next.
    #[inline]
    #[must_use]
    pub fn nodal(&self, element: usize, k: usize) -> usize {
        let block = self.travelling.map_or(1, |t| t.block);
        self.node(element + k / block, k % block)
    }

    /// What is left free in the blocks of the matrix.
    pub(super) fn free(&self) -> std::ops::Range<usize> {
        match &self.travelling {
            Some(t) => self.cell_unknowns() + t.nodes * t.block..t.blocks[0] * t.blocks[1],
            None => 0..0,
        }
    }

    fn node_size(&self) -> usize {
        if self.flexible { 2 * self.components } else { 0 }
    }

    fn cell_size(&self) -> usize {
        if self.flexible { 2 } else { 3 }
    }

    fn block(&self) -> usize {
        self.node_size() + self.cells_per_element * self.cell_size()
    }

    /// Shape of the Jacobian.
    #[must_use]
    pub fn shape(&self) -> Shape {
        let [blocks, block] = self.travelling.map_or([self.elements, self.block()], |t| t.blocks);
        let gauge = self.flexible || self.travelling.is_some();
        Shape {
            blocks,
            block,
            border: Global::Gauge as usize + if gauge { 2 } else { 0 },
        }
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.elements * self.cells_per_element
    }

    /// Component `k` of node `node`: a_x, b_x, a_y, b_y, in space a_z, b_z; of a ring that travels, what its model has
    /// there.
    #[must_use]
    pub fn node(&self, node: usize, k: usize) -> usize {
        if let Some(t) = &self.travelling {
            return self.cell_unknowns() + (node % t.nodes) * t.block + k;
        }
        (node % self.elements) * self.block() + k
    }

    fn cell(&self, cell: usize) -> usize {
        let cell = cell % self.cells();
        if self.travelling.is_some() {
            return 2 * cell;
        }
        let (element, c) = (cell / self.cells_per_element, cell % self.cells_per_element);
        element * self.block() + self.node_size() + c * self.cell_size()
    }

    /// Speed V of the left face of `cell`.
    #[must_use]
    pub fn speed(&self, cell: usize) -> usize {
        self.cell(cell)
    }

    /// Amount N of `cell`. It stands with the cell after it: then what flows into a cell, from either side, depends on
    /// nodes of neighbouring blocks only. (One cell an element can't have that for both directions of flow.)
    #[must_use]
    pub fn amount(&self, cell: usize) -> usize {
        let with = if self.cells_per_element > 1 && self.travelling.is_none() {
            cell + 1
        } else {
            cell
        };
        self.cell(with) + 1
    }

    /// Ring tension at the left face of `cell` (`ALE0`).
    #[must_use]
    pub fn tension(&self, cell: usize) -> usize {
        self.cell(cell) + 2
    }

    /// A global unknown; `offset` picks the pulley or tilt component.
    #[must_use]
    pub fn global(&self, global: Global, offset: usize) -> usize {
        let shape = self.shape();
        shape.blocks * shape.block + global as usize + offset
    }

    /// Number of unknowns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.shape().len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
