//! A steady state as the start of another one: on a finer mesh, or of other parameters and loads.
//!
//! A solution from the kinematic state mainly determines which elements stick, slide and separate.
//! A mesh with half the elements and one cell in each gives nearly the same result, and its
//! Jacobian costs a quarter.

use super::{FEWEST_ON_ARC, FEWEST_ON_STRAND};
use crate::pulley::{PerPulley, Pulley};
use crate::ring::kinematics::Hermite;
use crate::ring::mesh::find;
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::mesh::belt_mesh::{BeltMesh, Element};
use crate::variator::pulleys::loads::ShaftMode;
use crate::variator::settings::{Mesh, Parameters};
use std::sync::Arc;

/// Parameters with half the elements and one cell in each; none if a belt needs more.
pub(super) fn coarser(parameters: &Parameters) -> Option<Parameters> {
    let fine = &parameters.mesh;
    let even_half = |count: i32| 2 * (count / 4);
    let mesh = Mesh {
        primary_arc: even_half(fine.primary_arc),
        secondary_arc: even_half(fine.secondary_arc),
        strand: fine.strand / 2,
        cells_per_element: 1,
    };
    let arc = mesh.primary_arc.min(mesh.secondary_arc);
    let enough = arc >= FEWEST_ON_ARC && mesh.strand >= FEWEST_ON_STRAND;
    enough.then(|| Parameters {
        mesh,
        ..parameters.clone()
    })
}

/// Writes the fields of `from`, a state of the coarse `belt` found from its `kinematic` one, into
/// `state`, a kinematic state of the `fine` belt, whose sum of element contents is kept.
pub(super) fn prolong(belt: &Belt, kinematic: &State, from: &State, fine: &Belt, state: &mut State) {
    let content: f64 = fine.cells_at.iter().map(|cell| state.y[cell.content]).sum();
    let globals = |belt: &Belt| belt.layout.drift()..belt.layout.len();
    state.y_dot.fill(0.0);
    for (to, of) in globals(fine).zip(globals(belt)) {
        (state.y[to], state.q[to]) = (from.y[of], from.q[of]);
    }
    prolong_nodes(belt, from, fine, state);
    for cell in 0..fine.mesh.cells.len() {
        let MeshPosition { index, fraction } = find_cell(&belt.mesh, &fine.mesh, cell, 0.0);
        let between = |left: usize, right: usize| from.y[left] * (1.0 - fraction) + from.y[right] * fraction;
        let [layout, coarse] = [&fine.layout, &belt.layout];
        state.y[layout.belt_speed(cell)] = between(coarse.belt_speed(index), coarse.belt_speed(index + 1));
        if layout.has_tension() {
            state.y[layout.tension(cell)] = between(coarse.tension(index), coarse.tension(index + 1));
        }
    }
    if fine.law.is_pull_chain() {
        return;
    }
    // In the kinematic state cells share an element's length, so contents scale with its.
    for (cell, at) in fine.cells_at.iter().enumerate() {
        let coarse = belt.layout.content(find_cell(&belt.mesh, &fine.mesh, cell, 0.5).index);
        state.y[at.content] *= from.y[coarse] / kinematic.y[coarse];
    }
    let sum: f64 = fine.cells_at.iter().map(|cell| state.y[cell.content]).sum();
    for cell in &fine.cells_at {
        state.y[cell.content] *= content / sum;
    }
}

/// A steady state from which those of other parameters and loads are found.
#[derive(Clone, Debug)]
pub struct Neighbour {
    /// Its belt.
    pub belt: Arc<Belt>,
    /// The kinematic state it was found from.
    pub kinematic: State,
    /// The steady state.
    pub state: State,
}

impl Neighbour {
    /// Moves the kinematic state of another belt near its steady one: the difference between the
    /// kinematic states is added, and fixed speeds of shafts are kept. Returns whether it can; the
    /// belts may differ in parameters and in the number of elements.
    pub fn move_to(&self, belt: &Belt, state: &mut State, shaft: &PerPulley<ShaftMode>) -> bool {
        let Self {
            belt: of,
            kinematic,
            state: from,
        } = self;
        let [here, there] =
            [belt, of].map(|belt| (belt.ring.name(), belt.layout.components, belt.law.is_pull_chain()));
        if here != there {
            return false;
        }
        let other = state.clone();
        prolong(of, kinematic, from, belt, state);
        let globals = |belt: &Belt| belt.layout.drift()..belt.layout.len();
        for (to, of) in globals(belt).zip(globals(of)) {
            state.y[to] += other.y[to] - kinematic.y[of];
            state.q[to] += other.q[to] - kinematic.q[of];
        }
        let faster = other.y[belt.layout.drift()] / kinematic.y[of.layout.drift()];
        for cell in 0..belt.mesh.cells.len() {
            state.y[belt.layout.belt_speed(cell)] *= faster;
        }
        for pulley in Pulley::BOTH {
            if shaft[pulley] == ShaftMode::Fixed {
                let speed = belt.layout.shaft_speed(pulley);
                state.y[speed] = other.y[speed];
            }
        }
        true
    }
}

/// Index of an element or a cell, and position along it, from 0 to 1.
struct MeshPosition {
    index: usize,
    fraction: f64,
}

/// Element of a coarse mesh at the position `fraction` along a cell of the `fine` mesh.
fn find_element(coarse: &BeltMesh, fine: &BeltMesh, cell: usize, fraction: f64) -> MeshPosition {
    let of_fine = fine.cells_per_element;
    let Element {
        segment,
        start,
        length,
    } = fine.elements[cell / of_fine];
    let fraction = ((cell % of_fine) as f64 + fraction) / of_fine as f64;
    let (index, fraction) = find(&coarse.elements, segment, start + length * fraction);
    MeshPosition { index, fraction }
}

/// The same for a cell of the coarse mesh.
fn find_cell(coarse: &BeltMesh, fine: &BeltMesh, cell: usize, fraction: f64) -> MeshPosition {
    let element = find_element(coarse, fine, cell, fraction);
    let cells = coarse.cells_per_element;
    let position = element.fraction * cells as f64;
    let in_element = (position as usize).min(cells - 1);
    MeshPosition {
        index: element.index * cells + in_element,
        fraction: position - in_element as f64,
    }
}

/// Nodes on the cubics of the coarse mesh.
fn prolong_nodes(belt: &Belt, from: &State, fine: &Belt, state: &mut State) {
    if fine.layout.components == 0 {
        return;
    }
    let frame = belt.curve.frame(belt.theta(from.view()));
    for node in 0..fine.layout.elements {
        let cell = node * fine.mesh.cells_per_element;
        let MeshPosition { index, fraction } = find_element(&belt.mesh, &fine.mesh, cell, 0.0);
        let length = belt.element_length(&frame, index);
        let shape = Hermite::<f64>::new(2.0 * fraction - 1.0);
        for (to, from) in [(&mut state.q, &from.q), (&mut state.y, &from.y)] {
            for k in 0..fine.layout.components {
                let [left, right] = [index, index + 1].map(|node| {
                    let [a, b] = [0, 1].map(|slope| from[belt.layout.node(node, 2 * k + slope)]);
                    [a, b * length]
                });
                let interpolated =
                    |w: &[f64; 4]| left[0] * w[0] + left[1] * w[1] + right[0] * w[2] + right[1] * w[3];
                to[fine.layout.node(node, 2 * k)] = interpolated(&shape.n);
                to[fine.layout.node(node, 2 * k + 1)] = interpolated(&shape.dn) * 2.0 / length;
            }
        }
    }
}
