//! Order of the unknowns in the matrix for a travelling ring.
//!
//! Its nodes pass under the cells, so neighbours change. The order of the vector is constant. Each
//! Jacobian sorts cells and nodes by their current position along the belt, and divides this order
//! into blocks of equal size. The block size is the largest distance of two coupled unknowns, so
//! the result is an arrow matrix.

use crate::reference_curve::{TwoPulley, TwoPulleyFrame, ratio_of_theta};
use pushbelt::variator::ring_models::{Belt, BeltMesh, Cell, Layout};
use pushbelt::variator::settings::Parameters;

/// Nodes of a travelling ring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travelling {
    /// Number of nodes, and of elements.
    pub nodes: usize,
    /// Unknowns of a node and the element after it.
    pub block: usize,
    /// Unstretched length of an element, m.
    pub length: f64,
}

impl Travelling {
    /// The nodes of a layout.
    pub fn of(layout: &Layout, curve: &TwoPulley) -> Self {
        Self {
            nodes: layout.nodes,
            block: layout.per_node,
            length: curve.length() / layout.nodes as f64,
        }
    }

    /// Element at the unstretched place x̄, m.
    #[inline]
    pub fn element(&self, place: f64) -> Passed {
        let count = (place / self.length).floor();
        Passed {
            element: self.wrap(count),
            count,
        }
    }

    /// Node number from a number without wrapping.
    #[inline]
    fn wrap(&self, count: f64) -> usize {
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

/// An element of a travelling ring.
pub(crate) struct Passed {
    /// Its number around the loop.
    pub element: usize,
    /// Its number without wrapping.
    pub count: f64,
}

/// Margin of unknowns beyond the farthest coupling of the examined states.
const MARGIN: usize = 4;
/// Number of examined shapes of the curve between the end stops.
const SHAPES: u32 = 16;
/// Number of examined drifts within an element.
const DRIFTS: u32 = 8;

/// Places ξ of the points of every cell, m.
fn points(mesh: &BeltMesh, frame: &TwoPulleyFrame<f64>) -> Vec<Vec<f64>> {
    let of = |cell: &Cell| {
        let segment = mesh.elements[cell.element].segment;
        let points = std::iter::once(&cell.face).chain(&cell.stations);
        points.map(|at| frame.point(segment, at.fraction).xi.v).collect()
    };
    mesh.cells.iter().map(of).collect()
}

/// Shapes of the curve from one end stop to the other, and the initial one.
fn shapes(parameters: &Parameters, curve: &TwoPulley) -> Vec<f64> {
    let lowest = (parameters.secondary.min_radius / parameters.primary.max_radius).ln();
    let highest = (parameters.secondary.max_radius / parameters.primary.min_radius).ln();
    (0..=SHAPES)
        .map(|k| (lowest + (highest - lowest) * f64::from(k) / f64::from(SHAPES)).exp())
        .chain([parameters.initial.ratio])
        .filter(|&ratio| curve.radii(ratio).is_ok())
        .map(ratio_of_theta)
        .collect()
}

/// Sets number and size of the blocks, which contain every coupling of a travelling ring at all
/// ratios between the stops.
pub(crate) fn set_blocks(layout: &mut Layout, mesh: &BeltMesh, parameters: &Parameters) {
    let geometry = &parameters.geometry;
    let curve = &TwoPulley::new(geometry.center_distance, geometry.belt_length);
    let travelling = &Travelling::of(layout, curve);
    let total = 2 * layout.cells() + travelling.nodes * travelling.block;
    let mut places = vec![0; total];
    let mut reach = 0;
    for theta in shapes(parameters, curve) {
        let frame = curve.frame(theta);
        let points = points(mesh, &frame);
        let faces: Vec<f64> = points.iter().map(|xi| xi[0]).collect();
        for part in 0..DRIFTS {
            let s = f64::from(part) / f64::from(DRIFTS) * travelling.length;
            line_up(layout, travelling, &faces, s, &mut places);
            reach = reach.max(farthest(layout, travelling, &points, s, &places));
        }
    }
    let count = (total / (reach + MARGIN)).max(3);
    (layout.shape.blocks, layout.shape.block) = (count, total.div_ceil(count));
}

/// Consecutive places of cells and nodes along the belt.
fn line_up(layout: &Layout, travelling: &Travelling, faces: &[f64], s: f64, places: &mut [usize]) {
    let &Travelling { nodes, block, length } = travelling;
    // The first node after ξ = 0, and where it is.
    let count = -(s / length).floor();
    let (first, offset) = (travelling.wrap(count), count * length + s);
    let mut next = 0;
    let mut append = |unknown: usize| {
        places[unknown] = next;
        next += 1;
    };
    let mut passed = 0;
    let mut append_nodes_before = |to: f64, append: &mut dyn FnMut(usize)| {
        while passed < nodes && offset + passed as f64 * length < to {
            for k in 0..block {
                append(layout.node(first + passed, k));
            }
            passed += 1;
        }
    };
    for (cell, face) in faces.iter().enumerate() {
        append_nodes_before(*face, &mut append);
        append(layout.belt_speed(cell));
        append(layout.content(cell));
    }
    append_nodes_before(f64::INFINITY, &mut append);
}

/// Largest distance of two coupled unknowns.
fn farthest(
    layout: &Layout,
    travelling: &Travelling,
    points: &[Vec<f64>],
    s: f64,
    places: &[usize],
) -> usize {
    let total = places.len();
    let distance = |a: usize, b: usize| {
        let d = places[a].abs_diff(places[b]);
        d.min(total - d)
    };
    let cells = points.len();
    let mut found = 0;
    let nodes_of = |cell: usize, out: &mut Vec<usize>| {
        for xi in &points[cell] {
            let element = travelling.element(xi - s).element;
            for node in [element, element + 1] {
                out.push(layout.node(node, 0));
                out.push(layout.node(node, travelling.block - 1));
            }
        }
    };
    let (mut own, mut both) = (Vec::new(), Vec::new());
    for cell in 0..cells {
        let before = (cell + cells - 1) % cells;
        own.clear();
        nodes_of(cell, &mut own);
        both.clear();
        both.extend_from_slice(&own);
        nodes_of(before, &mut both);
        own.extend([
            layout.belt_speed(cell),
            layout.belt_speed(cell + 1),
            layout.content(cell),
        ]);
        both.extend([
            layout.belt_speed(before),
            layout.belt_speed(cell),
            layout.belt_speed(cell + 1),
        ]);
        for (i, &a) in own.iter().enumerate() {
            for &b in &own[i + 1..] {
                found = found.max(distance(a, b));
            }
        }
        for row in [layout.content(before), layout.content(cell)] {
            for &b in &both {
                found = found.max(distance(row, b));
            }
        }
    }
    found
}

/// Memory for the order of the unknowns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    faces: Vec<f64>,
    places: Vec<usize>,
    /// Place of each unknown in the matrix.
    pub order: Vec<usize>,
}

impl Order {
    /// Finds the order at this shape of the curve and drift s.
    pub fn find(&mut self, belt: &Belt, frame: &TwoPulleyFrame<f64>, s: f64) {
        let (layout, mesh) = (&belt.layout, &belt.mesh);
        let travelling = &Travelling::of(layout, &belt.curve);
        let total = 2 * layout.cells() + travelling.nodes * travelling.block;
        self.faces.clear();
        self.faces.extend(mesh.cells.iter().map(|cell| {
            let segment = mesh.elements[cell.element].segment;
            frame.point(segment, cell.face.fraction).xi.v
        }));
        self.places.resize(total, 0);
        line_up(layout, travelling, &self.faces, s, &mut self.places);
        let (blocks, size) = (layout.shape.blocks, layout.shape.block);
        let start = |block: usize| (block * total).div_ceil(blocks);
        self.order.clear();
        self.order.extend(self.places.iter().map(|&place| {
            let block = place * blocks / total;
            block * size + place - start(block)
        }));
        // Unused places in the blocks.
        for block in 0..blocks {
            let used = start(block + 1) - start(block);
            self.order.extend((used..size).map(|k| block * size + k));
        }
        self.order.extend(blocks * size..layout.len());
    }
}

/// Unknown `k` of a travelling element: those of its left node, then those of the next node.
#[inline]
pub(super) fn nodal(layout: &Layout, element: usize, k: usize) -> usize {
    let block = layout.per_node;
    layout.node(element + k / block, k % block)
}
