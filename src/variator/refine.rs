//! A steady state on a coarse mesh as the start on a fine one.
//!
//! What a cold solution does most is to find which elements stick, slide and part. A mesh with half the elements knows that nearly as
//! well, and with one cell an element its Jacobian costs a quarter.

use super::layout::Global;
use super::mesh::BeltMesh;
use super::parameters::{Mesh, Parameters};
use super::system::{State, VariatorSystem};
use crate::reference_curve::ReferenceCurve;
use crate::ring::kinematics::Hermite;

/// Fewest elements of an arc and of a strand on a coarse mesh.
const FEWEST: [i32; 2] = [6, 3];

/// Half the elements with half the cells, where so few still make a belt.
#[must_use]
pub fn coarser(parameters: &Parameters) -> Option<Parameters> {
    let fine = &parameters.mesh;
    let even_half = |count: i32| 2 * (count / 4);
    let mesh = Mesh {
        primary_arc: even_half(fine.primary_arc),
        secondary_arc: even_half(fine.secondary_arc),
        strand: fine.strand / 2,
        cells_per_element: 1,
        aligned: fine.aligned,
    };
    let enough = mesh.primary_arc.min(mesh.secondary_arc) >= FEWEST[0] && mesh.strand >= FEWEST[1];
    enough.then(|| Parameters {
        mesh,
        ..parameters.clone()
    })
}

/// A place on a mesh: an element, and how far along it, from 0 to 1.
#[derive(Clone, Copy)]
struct Spot {
    element: usize,
    along: f64,
}

/// Where `fraction` of `segment` lies.
fn locate(mesh: &BeltMesh, segment: usize, fraction: f64) -> Spot {
    let mut found = Spot { element: 0, along: 0.0 };
    for (element, e) in mesh.elements.iter().enumerate() {
        if e.segment == segment && fraction >= e.start - 1.0e-12 {
            let along = ((fraction - e.start) / e.share).clamp(0.0, 1.0);
            found = Spot { element, along };
        }
    }
    found
}

/// Puts the fields of `from`, a state of `coarse`, into `state`, a state of `fine` that holds as many elements as are to be on the belt.
pub fn prolong(coarse: &VariatorSystem, from: &State, fine: &VariatorSystem, state: &mut State) {
    let wanted: f64 = (0..fine.mesh.cells.len()).map(|i| state.y[fine.layout.amount(i)]).sum();
    state.y_dot.fill(0.0);
    let border = fine.layout.len() - fine.layout.global(Global::Drift, 0);
    for k in 0..border {
        let (to, of) = (
            fine.layout.global(Global::Drift, k),
            coarse.layout.global(Global::Drift, k),
        );
        (state.y[to], state.q[to]) = (from.y[of], from.q[of]);
    }
    if fine.layout.flexible {
        prolong_deflection(coarse, from, fine, state);
    }
    let cells = coarse.mesh.cells_per_element;
    // Cell at a spot, and how far along it.
    let cell_at = |spot: Spot| {
        let along = spot.along * cells as f64;
        let within = (along as usize).min(cells - 1);
        (spot.element * cells + within, along - within as f64)
    };
    let densities: Vec<f64> = per_cell(coarse, from, |_, density| density);
    let frame = coarse
        .curve
        .frame::<f64>(from.q[coarse.layout.global(Global::Theta, 0)]);
    let length = |cell: usize| coarse.element_length(&frame, cell / cells) / cells as f64;
    let count = coarse.mesh.cells.len();
    let fine_cells = fine.mesh.cells_per_element;
    let mut density = vec![0.0; fine.mesh.cells.len()];
    for (i, density) in density.iter_mut().enumerate() {
        let element = fine.mesh.elements[i / fine_cells];
        let spot = |offset: f64| {
            let along = ((i % fine_cells) as f64 + offset) / fine_cells as f64;
            locate(&coarse.mesh, element.segment, element.start + element.share * along)
        };
        let (cell, along) = cell_at(spot(0.0));
        let between = |of: &dyn Fn(usize) -> usize| from.y[of(cell)] * (1.0 - along) + from.y[of(cell + 1)] * along;
        state.y[fine.layout.speed(i)] = between(&|cell| coarse.layout.speed(cell));
        if fine.layout.has_tension() {
            state.y[fine.layout.tension(i)] = between(&|cell| coarse.layout.tension(cell));
        }
        let (cell, along) = cell_at(spot(0.5));
        let next = (cell + if along < 0.5 { count - 1 } else { 1 }) % count;
        let share = (along - 0.5).abs() * length(cell) * 2.0 / (length(cell) + length(next));
        *density = densities[cell] * (1.0 - share) + densities[next] * share;
    }
    let lengths: Vec<f64> = per_cell(fine, state, |length, _| length);
    // What interpolation gains or loses goes into the gaps.
    let amount = |density: &f64, length: &f64| density * length;
    let found: f64 = density.iter().zip(&lengths).map(|(d, l)| amount(d, l)).sum();
    let gap = |density: &f64, length: &f64| (1.0 - density).max(0.0) * length;
    let gaps: f64 = density.iter().zip(&lengths).map(|(d, l)| gap(d, l)).sum();
    let fill = if gaps > 0.0 { (wanted - found) / gaps } else { 0.0 };
    let scale = if gaps > 0.0 { 1.0 } else { wanted / found };
    for (i, (d, l)) in density.iter().zip(&lengths).enumerate() {
        state.y[fine.layout.amount(i)] = scale * amount(d, l) + fill * gap(d, l);
    }
}

/// Nodes on the cubics of the coarse mesh.
fn prolong_deflection(coarse: &VariatorSystem, from: &State, fine: &VariatorSystem, state: &mut State) {
    let frame = coarse
        .curve
        .frame::<f64>(from.q[coarse.layout.global(Global::Theta, 0)]);
    for (node, element) in fine.mesh.elements.iter().enumerate() {
        let spot = locate(&coarse.mesh, element.segment, element.start);
        let length = coarse.element_length(&frame, spot.element);
        let shape = Hermite::<f64>::at(2.0 * spot.along - 1.0);
        for k in (0..2 * fine.layout.components).step_by(2) {
            for (to, of) in [(&mut state.q, &from.q), (&mut state.y, &from.y)] {
                let [left, right] = [spot.element, spot.element + 1]
                    .map(|n| [of[coarse.layout.node(n, k)], of[coarse.layout.node(n, k + 1)] * length]);
                let along = |weights: &[f64; 4]| {
                    weights[0] * left[0] + weights[1] * left[1] + weights[2] * right[0] + weights[3] * right[1]
                };
                to[fine.layout.node(node, k)] = along(&shape.n);
                to[fine.layout.node(node, k + 1)] = along(&shape.dn) * 2.0 / length;
            }
        }
    }
}

/// A figure of each cell from its pitch length, m, and its density.
fn per_cell(system: &VariatorSystem, state: &State, figure: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let survey = system.surveyed(state.view());
    survey
        .samples
        .chunks_exact(system.mesh.points)
        .map(|cell| figure(cell.iter().map(|s| s.lambda * s.weight).sum(), cell[0].density))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::parameters::RingModel;
    use super::super::start::{Start, kinematic_state};
    use super::*;
    use crate::noise::noise;

    const START: Start = Start {
        ratio: 1.7,
        primary_speed: 150.0,
        clamping: [9.0e3, 10.0e3],
    };

    fn on_belt(system: &VariatorSystem, state: &State) -> f64 {
        (0..system.mesh.cells.len())
            .map(|i| state.y[system.layout.amount(i)])
            .sum()
    }

    /// A state with deflections and gaps.
    fn deflected(parameters: &Parameters) -> (VariatorSystem, State) {
        let system = VariatorSystem::new(parameters);
        let mut state = kinematic_state(&system, &START).unwrap();
        let mut noise = noise(7);
        if system.layout.flexible {
            for node in 0..system.layout.elements {
                for k in 0..2 * system.layout.components {
                    state.q[system.layout.node(node, k)] += 1.0e-5 * noise();
                }
            }
        }
        for i in 0..system.mesh.cells.len() {
            state.y[system.layout.amount(i)] *= 1.0 + 1.0e-4 * noise();
            state.y[system.layout.speed(i)] *= 1.0 + 1.0e-3 * noise();
        }
        (system, state)
    }

    #[test]
    fn the_same_mesh_gets_the_same_state() {
        for (ring_model, spatial) in [
            (RingModel::Ale, false),
            (RingModel::Ale, true),
            (RingModel::Ale0, false),
        ] {
            let parameters = Parameters {
                ring_model,
                spatial,
                ..Parameters::default()
            };
            let (system, state) = deflected(&parameters);
            let mut found = state.clone();
            found.q.fill(0.0);
            prolong(&system, &state, &system, &mut found);
            for (a, b) in state.q.iter().zip(&found.q).chain(state.y.iter().zip(&found.y)) {
                assert!((a - b).abs() < 1e-12 * a.abs().max(1.0), "{a} {b}");
            }
        }
    }

    #[test]
    fn a_finer_mesh_gets_its_own_amount_of_elements() {
        for ring_model in [RingModel::Ale, RingModel::Ale0] {
            let fine = Parameters {
                ring_model,
                ..Parameters::default()
            };
            let (system, state) = deflected(&coarser(&fine).expect("the default mesh has a coarse one"));
            let fine = VariatorSystem::new(&fine);
            let mut found = kinematic_state(&fine, &START).unwrap();
            let wanted = on_belt(&fine, &found);
            prolong(&system, &state, &fine, &mut found);
            assert!((on_belt(&fine, &found) / wanted - 1.0).abs() < 1e-13);
            // Every other node is one of the coarse mesh.
            for node in 0..if fine.layout.flexible {
                system.layout.elements
            } else {
                0
            } {
                for k in 0..4 {
                    let (a, b) = (
                        state.q[system.layout.node(node, k)],
                        found.q[fine.layout.node(2 * node, k)],
                    );
                    assert!((a - b).abs() < 1e-15, "{node} {k}: {a} {b}");
                }
            }
        }
    }
}
