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
use crate::variator::system::VariatorSystem;
use nalgebra::Vector3;

/// Fewest elements of an arc and of a strand on a coarse mesh.
const FEWEST: [i32; 2] = [6, 3];

/// Parameters with half the elements and one cell in each; none if a belt needs more.
#[must_use]
pub fn coarser(parameters: &Parameters) -> Option<Parameters> {
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

/// A state of a coarse mesh.
struct Coarse<'a> {
    system: &'a VariatorSystem,
    belt: &'a Belt,
    state: &'a State,
    frame: TwoPulleyFrame<f64>,
}

impl<'a> Coarse<'a> {
    fn new(system: &'a VariatorSystem, state: &'a State) -> Self {
        let belt = &*system.belt;
        Self {
            system,
            belt,
            state,
            frame: belt.curve.frame(belt.theta(state.view())),
        }
    }

    /// Element of this mesh at a place `along` an element of the `fine` mesh, and the place along it, from 0 to 1.
    fn element(&self, fine: &BeltMesh, element: usize, along: f64) -> (usize, f64) {
        let Element { segment, start, share } = fine.elements[element];
        find(&self.belt.mesh.elements, segment, start + share * along)
    }

    /// Cell of this mesh at a place `along` a cell of the `fine` mesh, and the place along it, from 0 to 1.
    fn cell(&self, fine: &BeltMesh, cell: usize, along: f64) -> (usize, f64) {
        let of_fine = fine.cells_per_element;
        let along = ((cell % of_fine) as f64 + along) / of_fine as f64;
        let (element, along) = self.element(fine, cell / of_fine, along);
        let cells = self.belt.mesh.cells_per_element;
        let along = along * cells as f64;
        let within = (along as usize).min(cells - 1);
        (element * cells + within, along - within as f64)
    }

    /// Length of a cell on the reference curve, m.
    fn length(&self, cell: usize) -> f64 {
        let cells = self.belt.mesh.cells_per_element;
        self.belt.element_length(&self.frame, cell / cells) / cells as f64
    }

    /// Nodes on the cubics of this mesh.
    fn write_nodes(&self, fine: &Belt, state: &mut State) {
        for node in 0..fine.layout.elements {
            let (element, along) = self.element(&fine.mesh, node, 0.0);
            let length = self.belt.element_length(&self.frame, element);
            let shape = Hermite::<f64>::at(2.0 * along - 1.0);
            for (to, of) in [(&mut state.q, &self.state.q), (&mut state.y, &self.state.y)] {
                let [left, right] = [element, element + 1].map(|node| {
                    let [a, b] = read_node(self.belt, &self.frame, of, node);
                    [a, b * length]
                });
                let along = |w: &[f64; 4]| left[0] * w[0] + left[1] * w[1] + right[0] * w[2] + right[1] * w[3];
                write_node(
                    fine,
                    &self.frame,
                    to,
                    node,
                    [along(&shape.n), along(&shape.dn) * 2.0 / length],
                );
            }
        }
    }

    /// Speeds of the elements and tensions of the ring, linear between faces.
    fn write_faces(&self, fine: &Belt, state: &mut State) {
        let layout = &self.belt.layout;
        for i in 0..fine.mesh.cells.len() {
            let (cell, along) = self.cell(&fine.mesh, i, 0.0);
            let between = |left: usize, right: usize| self.state.y[left] * (1.0 - along) + self.state.y[right] * along;
            state.y[fine.layout.belt_speed(i)] = between(layout.belt_speed(cell), layout.belt_speed(cell + 1));
            if fine.layout.has_tension() {
                state.y[fine.layout.tension(i)] = between(layout.tension(cell), layout.tension(cell + 1));
            }
        }
    }

    /// Amounts from densities that are linear between the middles of cells, with the sum `total`. The nodes are already set.
    fn write_amounts(&self, fine_system: &VariatorSystem, state: &mut State, total: f64) {
        let fine = &*fine_system.belt;
        let count = self.belt.mesh.cells.len();
        let known = per_cell(self.system, self.state, |_, density| density);
        let density = |i: usize| {
            let (cell, along) = self.cell(&fine.mesh, i, 0.5);
            let next = (cell + if along < 0.5 { count - 1 } else { 1 }) % count;
            let share = 2.0 * (along - 0.5).abs() * self.length(cell) / (self.length(cell) + self.length(next));
            known[cell] * (1.0 - share) + known[next] * share
        };
        let lengths = per_cell(fine_system, state, |length, _| length);
        let cells: Vec<(f64, f64)> = lengths
            .iter()
            .enumerate()
            .map(|(i, length)| (density(i), *length))
            .collect();
        // The error of the interpolated sum is distributed over the gaps or, where there are none, over all cells.
        let found: f64 = cells.iter().map(|(density, length)| density * length).sum();
        let gap = |(density, length): &(f64, f64)| (1.0 - density).max(0.0) * length;
        let mut room: Vec<f64> = cells.iter().map(gap).collect();
        if room.iter().all(|room| *room <= 0.0) {
            room = lengths;
        }
        let share = (total - found) / room.iter().sum::<f64>();
        for (i, ((density, length), room)) in cells.iter().zip(&room).enumerate() {
            state.y[fine.layout.amount(i)] = density * length + share * room;
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

/// Writes the fields of `from`, a state of `coarse`, into `state`, a state of `system` whose number of elements is kept.
pub fn prolong(coarse: &VariatorSystem, from: &State, system: &VariatorSystem, state: &mut State) {
    let fine = &*system.belt;
    let wanted = fine.cells_at.iter().map(|at| state.y[at.amount]).sum();
    let globals = |belt: &Belt| belt.layout.drift()..belt.layout.len();
    state.y_dot.fill(0.0);
    for (to, of) in globals(fine).zip(globals(&coarse.belt)) {
        (state.y[to], state.q[to]) = (from.y[of], from.q[of]);
    }
    let coarse = Coarse::new(coarse, from);
    if fine.layout.components() > 0 {
        coarse.write_nodes(fine, state);
    }
    coarse.write_faces(fine, state);
    if !fine.law.is_chain() {
        coarse.write_amounts(system, state, wanted);
    }
}

/// A value for each cell from its pitch length, m, and its density.
fn per_cell(system: &VariatorSystem, state: &State, figure: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let (mesh, diagnostics) = (&system.belt.mesh, BeltDiagnostics::of(system, state.view()));
    mesh.cells
        .iter()
        .map(|cell| {
            let sample = |station| diagnostics.sample(mesh, cell, station);
            let length = (0..mesh.points).map(sample).map(|s| s.lambda * s.weight).sum();
            figure(length, sample(0).density)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variator::settings::parameters::RingModel;
    use crate::variator::steady::start::{Start, kinematic_state};
    use pushbelt_support::noise;

    const START: Start = Start {
        ratio: 1.7,
        primary_speed: 150.0,
        clamping: crate::pulley::PerPulley {
            secondary: 9.0e3,
            primary: 10.0e3,
        },
    };

    fn on_belt(system: &VariatorSystem, state: &State) -> f64 {
        system.belt.cells_at.iter().map(|at| state.y[at.amount]).sum()
    }

    /// A state with deflections and gaps.
    fn deflected(parameters: &Parameters) -> (VariatorSystem, State) {
        let system = VariatorSystem::new(parameters);
        let mut state = kinematic_state(&system.belt, &START).unwrap();
        let mut noise = noise(7);
        let layout = &system.belt.layout;
        if layout.components() > 0 {
            for node in 0..layout.elements {
                for k in 0..2 * layout.components() {
                    state.q[layout.node(node, k)] += 1.0e-5 * noise();
                }
            }
        }
        for at in &system.belt.cells_at {
            state.y[at.amount] *= 1.0 + 1.0e-4 * noise();
            state.y[at.speed] *= 1.0 + 1.0e-3 * noise();
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
            let mut found = kinematic_state(&fine.belt, &START).unwrap();
            let wanted = on_belt(&fine, &found);
            prolong(&system, &state, &fine, &mut found);
            assert!((on_belt(&fine, &found) / wanted - 1.0).abs() < 1e-13);
            // Every other node is one of the coarse mesh.
            let shared = if fine.belt.layout.components() > 0 {
                system.belt.layout.elements
            } else {
                0
            };
            for node in 0..shared {
                for k in 0..4 {
                    let (a, b) = (
                        state.q[system.belt.layout.node(node, k)],
                        found.q[fine.belt.layout.node(2 * node, k)],
                    );
                    assert!((a - b).abs() < 1e-15, "{node} {k}: {a} {b}");
                }
            }
        }
    }
}
