//! A steady state on a coarse mesh as the start on a fine one.
//!
//! What a cold solution does most is to find which elements stick, slide and part. A mesh with half the elements knows
//! that nearly as well, and with one cell an element its Jacobian costs a quarter.

use super::layout::Global;
use super::mesh::{BeltMesh, Element};
use super::parameters::{Mesh, Parameters};
use super::ring::TURNING;
use super::system::VariatorSystem;
use crate::reference_curve::{ReferenceCurve, TwoPulleyFrame};
use crate::ring::kinematics::Hermite;
use crate::ring::mesh::find;
use crate::solver::State;
use nalgebra::{Vector2, Vector3};

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

/// A state of a coarse mesh that is looked at from a fine one.
struct Seen<'a> {
    system: &'a VariatorSystem,
    state: &'a State,
    frame: TwoPulleyFrame<f64>,
}

impl<'a> Seen<'a> {
    fn new(system: &'a VariatorSystem, state: &'a State) -> Self {
        let theta = state.q[system.layout.global(Global::Theta, 0)];
        Self {
            system,
            state,
            frame: system.curve.frame(theta),
        }
    }

    /// Where `along` an element of the `fine` mesh lies: an element here, and how far along it, from 0 to 1.
    fn element(&self, fine: &BeltMesh, element: usize, along: f64) -> (usize, f64) {
        let Element { segment, start, share } = fine.elements[element];
        find(&self.system.mesh.elements, segment, start + share * along)
    }

    /// The same for a place along a cell: here a cell, and how far along it.
    fn cell(&self, fine: &BeltMesh, cell: usize, along: f64) -> (usize, f64) {
        let of_fine = fine.cells_per_element;
        let along = ((cell % of_fine) as f64 + along) / of_fine as f64;
        let (element, along) = self.element(fine, cell / of_fine, along);
        let cells = self.system.mesh.cells_per_element;
        let along = along * cells as f64;
        let within = (along as usize).min(cells - 1);
        (element * cells + within, along - within as f64)
    }

    /// Length of a cell on the reference curve, m.
    fn length(&self, cell: usize) -> f64 {
        let cells = self.system.mesh.cells_per_element;
        self.system.element_length(&self.frame, cell / cells) / cells as f64
    }

    /// Nodes on the cubics of this mesh.
    fn put_nodes(&self, fine: &VariatorSystem, state: &mut State) {
        for node in 0..fine.layout.elements {
            let (element, along) = self.element(&fine.mesh, node, 0.0);
            let length = self.system.element_length(&self.frame, element);
            let shape = Hermite::<f64>::at(2.0 * along - 1.0);
            for (to, of) in [(&mut state.q, &self.state.q), (&mut state.y, &self.state.y)] {
                let [left, right] = [element, element + 1].map(|node| {
                    let [a, b] = self.system.node(&self.frame, of, node);
                    [a, b * length]
                });
                let along = |w: &[f64; 4]| left[0] * w[0] + left[1] * w[1] + right[0] * w[2] + right[1] * w[3];
                fine.put_node(
                    &self.frame,
                    to,
                    node,
                    [along(&shape.n), along(&shape.dn) * 2.0 / length],
                );
            }
        }
    }

    /// Speeds of the elements and tensions of the ring, linear between faces.
    fn put_faces(&self, fine: &VariatorSystem, state: &mut State) {
        let layout = &self.system.layout;
        for i in 0..fine.mesh.cells.len() {
            let (cell, along) = self.cell(&fine.mesh, i, 0.0);
            let between = |left: usize, right: usize| self.state.y[left] * (1.0 - along) + self.state.y[right] * along;
            state.y[fine.layout.speed(i)] = between(layout.speed(cell), layout.speed(cell + 1));
            if fine.layout.has_tension() {
                state.y[fine.layout.tension(i)] = between(layout.tension(cell), layout.tension(cell + 1));
            }
        }
    }

    /// Amounts of densities that are linear between the middles of cells, `wanted` of them in all. The nodes are in
    /// place.
    fn put_amounts(&self, fine: &VariatorSystem, state: &mut State, wanted: f64) {
        let count = self.system.mesh.cells.len();
        let known = per_cell(self.system, self.state, |_, density| density);
        let density = |i: usize| {
            let (cell, along) = self.cell(&fine.mesh, i, 0.5);
            let next = (cell + if along < 0.5 { count - 1 } else { 1 }) % count;
            let share = 2.0 * (along - 0.5).abs() * self.length(cell) / (self.length(cell) + self.length(next));
            known[cell] * (1.0 - share) + known[next] * share
        };
        let lengths = per_cell(fine, state, |length, _| length);
        let cells: Vec<(f64, f64)> = lengths
            .iter()
            .enumerate()
            .map(|(i, length)| (density(i), *length))
            .collect();
        // What interpolation gains or loses goes into the gaps, or where there are none, everywhere.
        let found: f64 = cells.iter().map(|(density, length)| density * length).sum();
        let gap = |(density, length): &(f64, f64)| (1.0 - density).max(0.0) * length;
        let mut room: Vec<f64> = cells.iter().map(gap).collect();
        if room.iter().all(|room| *room <= 0.0) {
            room = lengths;
        }
        let share = (wanted - found) / room.iter().sum::<f64>();
        for (i, ((density, length), room)) in cells.iter().zip(&room).enumerate() {
            state.y[fine.layout.amount(i)] = density * length + share * room;
        }
    }
}

impl VariatorSystem {
    /// Tangent and normal of the reference curve at a node.
    fn directions_at(&self, frame: &TwoPulleyFrame<f64>, node: usize) -> [Vector2<f64>; 2] {
        let element = node % self.layout.elements;
        let point = self.reference_point(frame, element, self.mesh.elements[element].start);
        [point.t, point.n]
    }

    /// Deflection of a node and its slope in x, y, z, or their rates where Θ rests, from the vector `of`.
    fn node(&self, frame: &TwoPulleyFrame<f64>, of: &[f64], node: usize) -> [Vector3<f64>; 2] {
        [0, 1].map(|slope| {
            let mut x = Vector3::zeros();
            for k in 0..self.layout.components {
                x[k] = of[self.layout.node(node, 2 * k + slope)];
            }
            if self.ring_kind() == TURNING {
                let [t, n] = self.directions_at(frame, node);
                let turned = t * x[0] + n * x[1];
                (x[0], x[1]) = (turned.x, turned.y);
            }
            x
        })
    }

    /// Puts a deflection and its slope into the vector `to`; the inverse of [`Self::node`].
    fn put_node(&self, frame: &TwoPulleyFrame<f64>, to: &mut [f64], node: usize, values: [Vector3<f64>; 2]) {
        for (slope, mut x) in values.into_iter().enumerate() {
            if self.ring_kind() == TURNING {
                let planar = x.xy();
                let [t, n] = self.directions_at(frame, node);
                (x[0], x[1]) = (t.dot(&planar), n.dot(&planar));
            }
            for k in 0..self.layout.components {
                to[self.layout.node(node, 2 * k + slope)] = x[k];
            }
        }
    }
}

/// Puts the fields of `from`, a state of `coarse`, into `state`, a state of `fine` that holds as many elements as are
/// to be on the belt.
pub fn prolong(coarse: &VariatorSystem, from: &State, fine: &VariatorSystem, state: &mut State) {
    let amounts = 0..fine.mesh.cells.len();
    let wanted = amounts.map(|i| state.y[fine.layout.amount(i)]).sum();
    let globals = |system: &VariatorSystem| system.layout.global(Global::Drift, 0)..system.layout.len();
    state.y_dot.fill(0.0);
    for (to, of) in globals(fine).zip(globals(coarse)) {
        (state.y[to], state.q[to]) = (from.y[of], from.q[of]);
    }
    let seen = Seen::new(coarse, from);
    if fine.layout.flexible {
        seen.put_nodes(fine, state);
    }
    seen.put_faces(fine, state);
    seen.put_amounts(fine, state, wanted);
}

/// A figure of each cell from its pitch length, m, and its density.
fn per_cell(system: &VariatorSystem, state: &State, figure: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let (mesh, survey) = (&system.mesh, system.surveyed(state.view()));
    mesh.cells
        .iter()
        .map(|cell| {
            let sample = |station| survey.sample(mesh, cell, station);
            let length = (0..mesh.points).map(sample).map(|s| s.lambda * s.weight).sum();
            figure(length, sample(0).density)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::parameters::RingModel;
    use super::super::start::{Start, kinematic_state};
    use super::*;
    use pushbelt_lab::noise;

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
        for (ring_model, spatial, reference_directions) in [
            (RingModel::Ale, false, false),
            (RingModel::Ale, true, true),
            (RingModel::Ale0, false, false),
        ] {
            let parameters = Parameters {
                ring_model,
                spatial,
                reference_directions,
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
            let shared = if fine.layout.flexible {
                system.layout.elements
            } else {
                0
            };
            for node in 0..shared {
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
