//! Where each unknown stands. The unknowns are velocities and first-order states; positions follow from q̇ = y.
//!
//! Block k belongs to ring element k: its left node (`ALE`: a_x, b_x, a_y, b_y), then for each cell the speed V of its
//! left face, the element amount N of the cell before, and (`ALE0`) the ring tension T at its left face. The border holds
//! the globals.

use super::mesh::BeltMesh;
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
    /// Multipliers of the gauge (`ALE`).
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
    /// Node in the middle of the primary arc, opposite to node 0.
    pub opposite: usize,
}

impl Layout {
    /// Layout on a mesh.
    #[must_use]
    pub fn new(mesh: &BeltMesh, flexible: bool) -> Self {
        Self {
            elements: mesh.elements.len(),
            cells_per_element: mesh.cells_per_element,
            flexible,
            opposite: mesh.elements.iter().take_while(|e| e.segment < 2).count()
                + mesh.elements.iter().filter(|e| e.segment == 2).count() / 2,
        }
    }

    fn node_size(&self) -> usize {
        if self.flexible { 4 } else { 0 }
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
        Shape {
            blocks: self.elements,
            block: self.block(),
            border: Global::Gauge as usize + if self.flexible { 2 } else { 0 },
        }
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.elements * self.cells_per_element
    }

    /// Node component `k` (a_x, b_x, a_y, b_y) of node `node`.
    #[must_use]
    pub fn node(&self, node: usize, k: usize) -> usize {
        (node % self.elements) * self.block() + k
    }

    fn cell(&self, cell: usize) -> usize {
        let cell = cell % self.cells();
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
        let with = if self.cells_per_element > 1 { cell + 1 } else { cell };
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
        self.elements * self.block() + global as usize + offset
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
