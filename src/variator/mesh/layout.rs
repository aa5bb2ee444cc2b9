//! Indices of the unknowns. The unknowns are velocities and first-order states; positions follow from q̇ = y.
//!
//! Block k belongs to ring element k: its left node (`ALE`: a_x, b_x, a_y, b_y, in space a_z, b_z), then for each cell
//! the speed V of its left face, the element amount N of the cell before, and (`ALE0`) the ring tension T at its left
//! face. The border holds the globals, of `ALE0` also the coordinates of displaced centres.
//!
//! With a ring that travels with its mesh the cells come first, each with V and N, then the nodes of the ring, then
//! what is left free in the blocks; the module `order` sorts them into the order of the matrix.

use crate::pulley::Pulley;
use crate::reference_curve::{COORDINATES, ReferenceCurve, TwoPulley};
use crate::ring::ancf::AncfElement;
use crate::ring::lagrangian::LagrangianElement;
use crate::ring::rcm::RcmElement;
use crate::solver::arrow::Shape;
use crate::variator::mesh::belt_mesh::BeltMesh;
use crate::variator::settings::parameters::{Parameters, RingModel};

/// Places of the global unknowns in the border. Pairs follow each other, the secondary pulley's first.
const DRIFT: usize = 0;
const THETA: usize = 1;
const SHEAVE: usize = 2;
const TILT: usize = 4;
const SHAFT: usize = 8;
const GAUGE: usize = 10;
/// Conditions that hold the gauge, where the ring has nodes.
pub const CONDITIONS: usize = 2;
/// Coordinates of displaced centres, where it has none.
pub const CENTRES: usize = COORDINATES - 1;
/// The turn among them; the others are lengths.
pub const TURN: usize = 1;

/// Unknowns of the ring beside drift and Θ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RingUnknowns {
    /// `ALE0`: the tension at each face.
    Tension,
    /// `ALE`: deflection and slope of each node, in so many components: 2, or 3 in space.
    Deflection {
        /// Number of components.
        components: usize,
        /// Whether they are counted along the reference curve and across it, A_i = [t, n, b]_ref in (10), instead of along
        /// x, y, z.
        rotating: bool,
    },
    /// `RCM`, `ANCF`: nodes that travel with the ring.
    Travelling(Travelling),
}

/// Nodes of a ring that travels with its mesh, and the blocks that they share with the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travelling {
    /// Number of nodes, and of elements.
    pub nodes: usize,
    /// Unknowns of a node and the element after it.
    pub block: usize,
    /// A bit for each unknown that is a length; the others are angles or slopes.
    lengths: u32,
    /// Unstretched length of an element, m.
    pub length: f64,
    /// Number of blocks of the matrix, and their size.
    pub blocks: [usize; 2],
}

impl Travelling {
    fn new<E: LagrangianElement>(nodes: usize, belt_length: f64) -> Self {
        Self {
            nodes,
            block: E::BLOCK,
            lengths: (0..E::BLOCK).filter(|&k| E::is_length(k)).map(|k| 1 << k).sum(),
            length: belt_length / nodes as f64,
            blocks: [0; 2],
        }
    }

    /// Whether unknown `k` of a node is a length; otherwise it is an angle or a slope.
    #[must_use]
    pub fn is_length(&self, k: usize) -> bool {
        self.lengths >> k & 1 == 1
    }

    /// Element at the unstretched place x̄, m, around the loop, and its number counted on over turns.
    #[inline]
    pub(crate) fn element(&self, place: f64) -> (usize, f64) {
        let count = (place / self.length).floor();
        (self.wrap(count), count)
    }

    /// A whole number counted on over turns, as the number of a node.
    #[inline]
    pub(crate) fn wrap(&self, count: f64) -> usize {
        let nodes = self.nodes as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number in 0..nodes"
        )]
        let node = (count - (count / nodes).floor() * nodes) as usize;
        node.min(self.nodes - 1)
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
    /// Node in the middle of the primary arc, opposite to node 0.
    pub opposite: usize,
}

impl Layout {
    /// Layout of the ring that the parameters name. The blocks of one that travels are still to be found
    /// ([`blocks`](crate::variator::mesh::order::blocks)).
    #[must_use]
    pub fn new(parameters: &Parameters, mesh: &BeltMesh, curve: &TwoPulley) -> Self {
        let ring = match parameters.ring_model {
            RingModel::Ale0 => RingUnknowns::Tension,
            RingModel::Ale => RingUnknowns::Deflection {
                components: if parameters.spatial { 3 } else { 2 },
                rotating: parameters.reference_directions,
            },
            RingModel::Rcm | RingModel::Ancf => {
                let elements = parameters.travelling_elements().unwrap_or_default();
                RingUnknowns::Travelling(if parameters.ring_model == RingModel::Rcm {
                    Travelling::new::<RcmElement>(elements, curve.length())
                } else {
                    Travelling::new::<AncfElement>(elements, curve.length())
                })
            }
        };
        Self {
            elements: mesh.elements.len(),
            cells_per_element: mesh.cells_per_element,
            ring,
            opposite: mesh.opposite(),
        }
    }

    /// Components of the deflection of an Eulerian ring; 0 of one that keeps to the reference curve or that travels.
    #[must_use]
    pub fn components(&self) -> usize {
        match self.ring {
            RingUnknowns::Deflection { components, .. } => components,
            RingUnknowns::Tension | RingUnknowns::Travelling(_) => 0,
        }
    }

    /// Whether the ring deflects along z too.
    #[must_use]
    pub fn is_spatial(&self) -> bool {
        self.components() == 3
    }

    /// Whether the overlay is counted in directions of the reference curve.
    #[must_use]
    pub fn is_rotating(&self) -> bool {
        matches!(self.ring, RingUnknowns::Deflection { rotating: true, .. })
    }

    /// Whether the ring tension is an unknown (`ALE0`).
    #[must_use]
    pub fn has_tension(&self) -> bool {
        self.ring == RingUnknowns::Tension
    }

    /// Whether s and Θ repeat motions of the ring, so that conditions with multipliers hold them (all but `ALE0`).
    #[must_use]
    pub fn has_gauge(&self) -> bool {
        !self.has_tension()
    }

    /// Nodes that travel with the ring, if they do.
    #[must_use]
    pub fn travelling(&self) -> Option<&Travelling> {
        match &self.ring {
            RingUnknowns::Travelling(travelling) => Some(travelling),
            RingUnknowns::Tension | RingUnknowns::Deflection { .. } => None,
        }
    }

    /// Unknowns of the cells of a ring that travels.
    pub(crate) fn cell_unknowns(&self) -> usize {
        2 * self.cells()
    }

    /// Unknown `k` of an element of a ring that travels: of its own node, then of the next.
    #[inline]
    #[must_use]
    pub fn nodal(&self, element: usize, k: usize) -> usize {
        let block = self.travelling().map_or(1, |t| t.block);
        self.node(element + k / block, k % block)
    }

    /// Unknowns that fill up the blocks of the matrix and stand for nothing.
    pub(crate) fn free(&self) -> std::ops::Range<usize> {
        match self.travelling() {
            Some(t) => self.cell_unknowns() + t.nodes * t.block..t.blocks[0] * t.blocks[1],
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
        let [blocks, block] = self.travelling().map_or([self.elements, self.block()], |t| t.blocks);
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

    /// Index of component `k` of node `node`: a_x, b_x, a_y, b_y, in space a_z, b_z; of a ring that travels, what its model has
    /// there.
    #[must_use]
    pub fn node(&self, node: usize, k: usize) -> usize {
        if let Some(t) = self.travelling() {
            return self.cell_unknowns() + (node % t.nodes) * t.block + k;
        }
        (node % self.elements) * self.block() + k
    }

    fn cell(&self, cell: usize) -> usize {
        let cell = cell % self.cells();
        if self.travelling().is_some() {
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

    /// Index of the amount N of `cell`. It belongs to the block of the next cell: then the flow into a cell, from either
    /// side, depends on nodes of neighbouring blocks only. One cell an element can't have that for both directions of flow.
    #[must_use]
    pub fn amount(&self, cell: usize) -> usize {
        let with = if self.cells_per_element > 1 && self.travelling().is_none() {
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

    /// Index of the multiplier of a condition of the gauge.
    #[must_use]
    pub fn gauge(&self, condition: usize) -> usize {
        self.border() + GAUGE + condition
    }

    /// Index of the rate of a coordinate of displaced centres (`ALE0`): spread, turn, shift along x and y.
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

    /// Indices of the globals that every ring has: neither multipliers of the gauge nor displaced centres.
    #[must_use]
    pub fn globals(&self) -> std::ops::Range<usize> {
        self.border()..self.border() + GAUGE
    }

    /// Whether each unknown is the rate of a position.
    #[must_use]
    pub fn has_position(&self) -> Vec<bool> {
        let mut has_position = vec![false; self.len()];
        let nodes = match &self.ring {
            RingUnknowns::Tension => 0..0,
            RingUnknowns::Deflection { .. } => 0..self.elements,
            RingUnknowns::Travelling(t) => 0..t.nodes,
        };
        let block = self.travelling().map_or(self.node_size(), |t| t.block);
        for node in nodes {
            for k in 0..block {
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

    /// Calls `f` with every unknown of the ring's nodes that is a length, not a slope or an angle.
    pub(crate) fn for_each_length_unknown(&self, mut f: impl FnMut(usize)) {
        match &self.ring {
            RingUnknowns::Tension => {}
            RingUnknowns::Deflection { components, .. } => {
                for node in 0..self.elements {
                    for k in (0..2 * components).step_by(2) {
                        f(self.node(node, k));
                    }
                }
            }
            RingUnknowns::Travelling(t) => {
                for k in (0..t.block).filter(|&k| t.is_length(k)) {
                    for node in 0..t.nodes {
                        f(self.node(node, k));
                    }
                }
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
