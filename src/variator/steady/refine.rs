//! A steady state on a coarse mesh as the start on a fine one.
//!
//! A solution from the kinematic state mainly determines which elements stick, slide and separate. A mesh with half the
//! elements gives nearly the same result, and with one cell per element its Jacobian costs a quarter.

use crate::reference_curve::{ReferenceCurve, TwoPulleyFrame};
use crate::ring::kinematics::Hermite;
use crate::ring::mesh::find;
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::diagnostics::belt::BeltDiagnostics;
use crate::variator::mesh::belt_mesh::{BeltMesh, Element};
use crate::variator::settings::parameters::{Mesh, Parameters};
use crate::variator::steady::FEWEST;
use crate::variator::system::VariatorSystem;
use nalgebra::Vector3;

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

/// Writes the fields of `from`, a state of `coarse`, into `state`, a state of `system` whose sum of element contents is kept.
pub(super) fn prolong(coarse: &VariatorSystem, from: &State, system: &VariatorSystem, state: &mut State) {
    let (fine, belt) = (&*system.belt, &*coarse.belt);
    let content = fine.cells_at.iter().map(|at| state.y[at.content]).sum();
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
    if !fine.law.is_chain() {
        prolong_contents(coarse, from, system, state, content);
    }
}

/// Element of a coarse mesh at a place `along` a cell of the `fine` mesh, and the place along it, from 0 to 1.
fn find_element(coarse: &BeltMesh, fine: &BeltMesh, cell: usize, along: f64) -> (usize, f64) {
    let of_fine = fine.cells_per_element;
    let Element { segment, start, share } = fine.elements[cell / of_fine];
    let along = ((cell % of_fine) as f64 + along) / of_fine as f64;
    find(&coarse.elements, segment, start + share * along)
}

/// Cell of a coarse mesh at a place `along` a cell of the `fine` mesh, and the place along it, from 0 to 1.
fn find_cell(coarse: &BeltMesh, fine: &BeltMesh, cell: usize, along: f64) -> (usize, f64) {
    let (element, along) = find_element(coarse, fine, cell, along);
    let cells = coarse.cells_per_element;
    let along = along * cells as f64;
    let within = (along as usize).min(cells - 1);
    (element * cells + within, along - within as f64)
}

/// Nodes on the cubics of the coarse mesh.
fn prolong_nodes(belt: &Belt, from: &State, fine: &Belt, state: &mut State) {
    if fine.layout.components() == 0 {
        return;
    }
    let frame = belt.curve.frame(belt.theta(from.view()));
    for node in 0..fine.layout.elements {
        let cell = node * fine.mesh.cells_per_element;
        let (element, along) = find_element(&belt.mesh, &fine.mesh, cell, 0.0);
        let length = belt.element_length(&frame, element);
        let shape = Hermite::<f64>::at(2.0 * along - 1.0);
        for (to, of) in [(&mut state.q, &from.q), (&mut state.y, &from.y)] {
            let [left, right] = [element, element + 1].map(|node| {
                let [a, b] = read_node(belt, &frame, of, node);
                [a, b * length]
            });
            let along = |w: &[f64; 4]| left[0] * w[0] + left[1] * w[1] + right[0] * w[2] + right[1] * w[3];
            let values = [along(&shape.n), along(&shape.dn) * 2.0 / length];
            write_node(fine, &frame, to, node, values);
        }
    }
}

/// Deflection of a node and its slope in x, y, z, or their rates where Θ rests, from the vector `of`.
fn read_node(belt: &Belt, frame: &TwoPulleyFrame<f64>, of: &[f64], node: usize) -> [Vector3<f64>; 2] {
    [0, 1].map(|slope| {
        let mut x = Vector3::zeros();
        for k in 0..belt.layout.components() {
            x[k] = of[belt.layout.node(node, 2 * k + slope)];
        }
        if let Some([t, n]) = belt.ring.directions(belt, frame, node) {
            let turned = t * x[0] + n * x[1];
            (x[0], x[1]) = (turned.x, turned.y);
        }
        x
    })
}

/// Writes a deflection and its slope into the vector `to`; the inverse of [`read_node`].
fn write_node(belt: &Belt, frame: &TwoPulleyFrame<f64>, to: &mut [f64], node: usize, values: [Vector3<f64>; 2]) {
    for (slope, mut x) in values.into_iter().enumerate() {
        if let Some([t, n]) = belt.ring.directions(belt, frame, node) {
            let planar = x.xy();
            (x[0], x[1]) = (t.dot(&planar), n.dot(&planar));
        }
        for k in 0..belt.layout.components() {
            to[belt.layout.node(node, 2 * k + slope)] = x[k];
        }
    }
}

/// Contents of the cells from the densities of the coarse ones, with the sum `total`. The rest of `state` is already set.
fn prolong_contents(coarse: &VariatorSystem, from: &State, system: &VariatorSystem, state: &mut State, total: f64) {
    let fine = &*system.belt;
    let known = per_cell(coarse, from, |_, density| density);
    let lengths = per_cell(system, state, |length, _| length);
    let density = |i| known[find_cell(&coarse.belt.mesh, &fine.mesh, i, 0.5).0];
    let contents = lengths.iter().enumerate().map(|(i, length)| density(i) * length);
    // The error of the sum is distributed over the gaps or, where there are none, over all cells.
    let off = total - contents.clone().sum::<f64>();
    let mut gaps: Vec<f64> = contents
        .clone()
        .zip(&lengths)
        .map(|(content, length)| (length - content).max(0.0))
        .collect();
    if gaps.iter().all(|gap| *gap == 0.0) {
        gaps.clone_from(&lengths);
    }
    let share = off / gaps.iter().sum::<f64>();
    for (i, (content, gap)) in contents.zip(&gaps).enumerate() {
        state.y[fine.layout.content(i)] = content + share * gap;
    }
}

/// A value for each cell from its pitch length, m, and its density.
fn per_cell(system: &VariatorSystem, state: &State, value: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let (mesh, diagnostics) = (&system.belt.mesh, BeltDiagnostics::of(system, state.view()));
    let of = |cell| {
        let sample = |station| diagnostics.sample(mesh, cell, station);
        let length = (0..mesh.points).map(sample).map(|s| s.lambda * s.weight).sum();
        value(length, sample(0).density)
    };
    mesh.cells.iter().map(of).collect()
}
