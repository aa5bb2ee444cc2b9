//! A steady state on a coarse mesh as the start on a fine one.
//!
//! A solution from the kinematic state mainly determines which elements stick, slide and separate.
//! A mesh with half the elements gives nearly the same result, and with one cell per element its
//! Jacobian costs a quarter.

use crate::reference_curve::ReferenceCurve;
use crate::ring::kinematics::Hermite;
use crate::ring::mesh::find;
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::mesh::belt_mesh::{BeltMesh, Element};
use crate::variator::settings::parameters::{Mesh, Parameters};
use crate::variator::steady::FEWEST;

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
    let enough = mesh.primary_arc.min(mesh.secondary_arc) >= FEWEST[0] && mesh.strand >= FEWEST[1];
    enough.then(|| Parameters {
        mesh,
        ..parameters.clone()
    })
}

/// Writes the fields of `from`, a state of the coarse `belt` found from its `kinematic` one, into
/// `state`, a kinematic state of the `fine` belt, whose sum of element contents is kept.
pub(super) fn prolong(belt: &Belt, [kinematic, from]: [&State; 2], fine: &Belt, state: &mut State) {
    let content: f64 = fine.cells_at.iter().map(|at| state.y[at.content]).sum();
    let globals = |belt: &Belt| belt.layout.drift()..belt.layout.len();
    state.y_dot.fill(0.0);
    for (to, of) in globals(fine).zip(globals(belt)) {
        (state.y[to], state.q[to]) = (from.y[of], from.q[of]);
    }
    prolong_nodes(belt, from, fine, state);
    for cell in 0..fine.mesh.cells.len() {
        let (of, along) = find_cell(&belt.mesh, &fine.mesh, cell, 0.0);
        let between = |left: usize, right: usize| from.y[left] * (1.0 - along) + from.y[right] * along;
        let [layout, coarse] = [&fine.layout, &belt.layout];
        state.y[layout.belt_speed(cell)] = between(coarse.belt_speed(of), coarse.belt_speed(of + 1));
        if layout.has_tension() {
            state.y[layout.tension(cell)] = between(coarse.tension(of), coarse.tension(of + 1));
        }
    }
    if fine.law.is_pull_chain() {
        return;
    }
    // Cells of an element share its length in the kinematic state, so contents are in proportion to
    // its.
    for (cell, at) in fine.cells_at.iter().enumerate() {
        let of = belt.layout.content(find_cell(&belt.mesh, &fine.mesh, cell, 0.5).0);
        state.y[at.content] *= from.y[of] / kinematic.y[of];
    }
    let sum: f64 = fine.cells_at.iter().map(|at| state.y[at.content]).sum();
    for at in &fine.cells_at {
        state.y[at.content] *= content / sum;
    }
}

/// Element of a coarse mesh at a place `along` a cell of the `fine` mesh, and the place along it,
/// from 0 to 1.
fn find_element(coarse: &BeltMesh, fine: &BeltMesh, cell: usize, along: f64) -> (usize, f64) {
    let of_fine = fine.cells_per_element;
    let Element {
        segment,
        start,
        length,
    } = fine.elements[cell / of_fine];
    let along = ((cell % of_fine) as f64 + along) / of_fine as f64;
    find(&coarse.elements, segment, start + length * along)
}

/// Cell of a coarse mesh at a place `along` a cell of the `fine` mesh, and the place along it, from
/// 0 to 1.
fn find_cell(coarse: &BeltMesh, fine: &BeltMesh, cell: usize, along: f64) -> (usize, f64) {
    let (element, along) = find_element(coarse, fine, cell, along);
    let cells = coarse.cells_per_element;
    let along = along * cells as f64;
    let within = (along as usize).min(cells - 1);
    (element * cells + within, along - within as f64)
}

/// Nodes on the cubics of the coarse mesh.
fn prolong_nodes(belt: &Belt, from: &State, fine: &Belt, state: &mut State) {
    if fine.layout.components == 0 {
        return;
    }
    let frame = belt.curve.frame(belt.theta(from.view()));
    for node in 0..fine.layout.elements {
        let cell = node * fine.mesh.cells_per_element;
        let (element, along) = find_element(&belt.mesh, &fine.mesh, cell, 0.0);
        let length = belt.element_length(&frame, element);
        let shape = Hermite::<f64>::new(2.0 * along - 1.0);
        for (to, of) in [(&mut state.q, &from.q), (&mut state.y, &from.y)] {
            for k in 0..fine.layout.components {
                let [left, right] = [element, element + 1].map(|node| {
                    let [a, b] = [0, 1].map(|slope| of[belt.layout.node(node, 2 * k + slope)]);
                    [a, b * length]
                });
                let along =
                    |w: &[f64; 4]| left[0] * w[0] + left[1] * w[1] + right[0] * w[2] + right[1] * w[3];
                to[fine.layout.node(node, 2 * k)] = along(&shape.n);
                to[fine.layout.node(node, 2 * k + 1)] = along(&shape.dn) * 2.0 / length;
            }
        }
    }
}
