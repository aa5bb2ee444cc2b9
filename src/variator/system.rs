//! The variator as an implicit system: cells, pulleys and boundary conditions assembled, with the exact Jacobian.

use super::assembly::PulleySum;
use super::boundary::{Boundary, Course, SheaveMode, SpeedMode};
use super::cell::{CellLaw, SheavePlane};
use super::evolution::Ledger;
use super::kept::Kept;
use super::layout::{Global, Layout};
use super::mesh::{BeltMesh, P, S};
use super::order::{self, Order, Travelling};
use super::pack::{MOST, Pack, for_kind};
use super::parameters::{Parameters, Pulley, RIGID_TILT_STIFFNESS, RingModel};
use super::ring::{FIXED, GUIDED, TURNING};
use super::transports::Transports;
use super::travelling::{CellSlopes, MeanTension, TravellingRing, with_ring};
use crate::chain::Transport;
use crate::pulley::Travel;
use crate::reference_curve::{ReferenceCurve, TwoPulley, ratio_of_theta};
use crate::solver::arrow::{Arrow, Shape};
use crate::solver::{System, View};
use std::sync::Arc;

/// The assembled variator.
#[derive(Clone, Debug)]
pub struct VariatorSystem {
    /// Constants of the cells.
    pub law: CellLaw,
    /// Mesh.
    pub mesh: BeltMesh,
    /// Order of the unknowns.
    pub layout: Layout,
    /// Reference curve.
    pub curve: TwoPulley,
    /// Axial travel of the pulleys.
    pub travel: [Travel; 2],
    /// Boundary conditions in force.
    pub boundary: Boundary,
    /// What they follow while loads change.
    pub(super) course: Option<Course>,
    /// Factor on the pulleys' inertia, 1 in a run. A steady solution takes more, so that speeds follow the belt instead
    /// of running ahead of it.
    pub inertia_factor: f64,
    /// Energies since the start.
    pub ledger: Ledger,
    has_position: Vec<bool>,
    pub(super) packs: Vec<Pack>,
    /// Derivatives of each pack.
    pub(super) kept: Vec<Kept>,
    /// How often packs of cells were differentiated.
    pub(super) differentiations: u64,
    /// Where V at its left face and the element amount of each cell stand.
    pub(super) cells_at: Vec<[usize; 2]>,
    /// What the balance of the amounts needs of each cell.
    pub(super) transports: Transports,
    /// Its slopes in the cell's directions: kept as those of the packs are.
    pub(super) transport_slopes: Vec<Transport<[f64; MOST]>>,
    pub(super) sums: [PulleySum; 2],
    /// Places of ∂(flux)/∂(directions of a cell) in the rows of the amounts before and in the cell; then the same for
    /// the directions of the cell before.
    pub(super) flux_entries: Vec<[[[usize; 2]; MOST]; 2]>,
    /// The ring that travels with its mesh, if it does, with its working memory.
    pub(super) travelling: Option<Arc<TravellingRing>>,
    pub(super) mean_tensions: Vec<MeanTension>,
    pub(super) passing_slopes: Vec<CellSlopes>,
    pub(super) order: Order,
}

/// Shapes of the curve for which the matrix must hold every coupling.
const SHAPES: u32 = 16;

/// Nodes and blocks of a ring that travels with its mesh.
fn travelling(
    ring: &TravellingRing,
    layout: &Layout,
    mesh: &BeltMesh,
    parameters: &Parameters,
    curve: &TwoPulley,
) -> Travelling {
    let (nodes, block) = ring.size();
    let without_blocks = Travelling {
        nodes,
        block,
        length: curve.length() / nodes as f64,
        blocks: [0; 2],
    };
    let layout = Layout {
        travelling: Some(without_blocks),
        ..*layout
    };
    let lowest = (parameters.secondary.min_radius / parameters.primary.max_radius).ln();
    let highest = (parameters.secondary.max_radius / parameters.primary.min_radius).ln();
    let thetas: Vec<f64> = (0..=SHAPES)
        .map(|k| (lowest + (highest - lowest) * f64::from(k) / f64::from(SHAPES)).exp())
        .chain([parameters.initial.ratio])
        .filter(|&ratio| curve.radii(ratio).is_ok())
        .map(ratio_of_theta)
        .collect();
    Travelling {
        blocks: order::blocks(&layout, mesh, &without_blocks, &thetas, curve),
        ..without_blocks
    }
}

/// Parameters of pulley `j`.
fn pulley(parameters: &Parameters, j: usize) -> &Pulley {
    if j == P {
        &parameters.primary
    } else {
        &parameters.secondary
    }
}

impl VariatorSystem {
    /// Assembles a variator.
    ///
    /// # Panics
    /// With parameters that [`Parameters::validate`] rejects.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let geometry = &parameters.geometry;
        let curve = TwoPulley::new(geometry.center_distance, geometry.belt_length);
        let (radius, _) = curve.radii(1.0).expect("validated geometry closes at ratio 1");
        let r0 = radius - parameters.belt.pitch_offset;
        let (sin, cos) = geometry.wedge_angle.sin_cos();
        let mesh = BeltMesh::new(&parameters.mesh, parameters.ring_model);
        let mut layout = Layout::new(
            &mesh,
            parameters.ring_model == RingModel::Ale,
            if parameters.spatial { 3 } else { 2 },
        );
        let ring = TravellingRing::new(parameters, &curve);
        if let Some(ring) = &ring {
            layout.travelling = Some(travelling(ring, &layout, &mesh, parameters, &curve));
        }
        let mut has_position = vec![false; layout.len()];
        if layout.flexible {
            for node in 0..layout.elements {
                for k in 0..2 * layout.components {
                    has_position[layout.node(node, k)] = true;
                }
            }
        }
        if let Some(travelling) = &layout.travelling {
            for k in 0..travelling.nodes * travelling.block {
                has_position[layout.node(0, 0) + k] = true;
            }
        }
        has_position[layout.global(Global::Drift, 0)] = true;
        has_position[layout.global(Global::Theta, 0)] = true;
        for j in [S, P] {
            has_position[layout.global(Global::Sheave, j)] = true;
        }
        let cells = mesh.cells.len();
        let travel = [S, P].map(|j| {
            let pulley = pulley(parameters, j);
            Travel::new((pulley.min_radius, pulley.max_radius), r0, sin / cos)
        });
        let mut system = Self {
            law: CellLaw {
                parameters: parameters.clone(),
                wedge: [sin, cos, sin / cos],
                r0,
                axes: [0.0, geometry.center_distance],
                planes: SheavePlane::pair(geometry.pulley_offset),
                has_lag: mesh.cells_per_element > 1,
            },
            mesh,
            layout,
            curve,
            travel,
            boundary: Boundary {
                sheave: [SheaveMode::Held; 2],
                speed: [SpeedMode::Fixed; 2],
            },
            course: None,
            inertia_factor: 1.0,
            ledger: Ledger::default(),
            has_position,
            cells_at: (0..cells)
                .map(|cell| [layout.speed(cell), layout.amount(cell)])
                .collect(),
            transports: Transports::new(cells),
            sums: [PulleySum::default(); 2],
            transport_slopes: vec![Transport::default().map(|()| [0.0; MOST]); cells],
            packs: Vec::new(),
            kept: Vec::new(),
            differentiations: 0,
            flux_entries: Vec::new(),
            mean_tensions: vec![MeanTension::default(); layout.travelling.map_or(0, |t| t.nodes)],
            passing_slopes: Vec::new(),
            order: Order::default(),
            travelling: ring.map(Arc::new),
        };
        system.pack();
        system
    }

    /// The next Jacobian takes every derivative anew.
    pub(super) fn forget_derivatives(&mut self) {
        self.kept.iter_mut().for_each(Kept::forget);
    }

    /// Takes the derivatives that are kept once more: after they were read from a tape.
    pub(super) fn retake_derivatives(&mut self) {
        for_kind!(&mut *self, retake());
    }

    /// How often packs of cells were differentiated.
    #[must_use]
    pub fn differentiations(&self) -> u64 {
        self.differentiations
    }

    /// Parameters of a pulley.
    #[must_use]
    pub fn pulley(&self, j: usize) -> &Pulley {
        pulley(&self.law.parameters, j)
    }

    /// Middles of the pulleys along z, m.
    #[must_use]
    pub fn middles(&self, view: View<'_>) -> [f64; 2] {
        [S, P].map(|j| self.law.planes[j].middle(view.q[self.layout.global(Global::Sheave, j)]))
    }

    /// Whether a sheave counts as rigid.
    #[must_use]
    pub fn rigid(&self, j: usize) -> bool {
        self.pulley(j).tilt_stiffness >= RIGID_TILT_STIFFNESS
    }

    pub(super) fn theta(&self, view: View<'_>) -> f64 {
        view.q[self.layout.global(Global::Theta, 0)]
    }

    /// Axial force of the belt on one sheave as of the last residual, N.
    #[must_use]
    pub fn belt_load(&self, j: usize) -> f64 {
        self.sums[j].axial
    }

    /// What the ring does in the cells: [`GUIDED`], [`FIXED`] or [`TURNING`].
    pub(super) fn ring_kind(&self) -> u8 {
        match (self.layout.flexible, self.law.parameters.reference_directions) {
            (false, _) => GUIDED,
            (true, false) => FIXED,
            (true, true) => TURNING,
        }
    }

    /// The gauge: s and Θ repeat motions that q_f can make, so two conditions hold the overlay, with multipliers in the
    /// border. They are even in the two pulleys, so swapping these is a symmetry of the discrete system: the
    /// deflections of node 0 and of the node opposite are equal outwards (which fixes what Θ means) and opposite along
    /// the curve (which fixes s). In directions of the curve these are the same two conditions in the other order: t of
    /// node 0 is along y, n along x, and opposite both are reversed.
    fn gauge(&self) -> impl Iterator<Item = Condition> + use<> {
        let layout = self.layout;
        let components = [(0, [1.0, 1.0]), (1, [1.0, -1.0])];
        components
            .into_iter()
            .filter(move |_| layout.flexible)
            .map(move |(k, signs)| Condition {
                multiplier: layout.global(Global::Gauge, k),
                nodes: [0, layout.opposite].map(|node| layout.node(node, 2 * k)),
                signs,
            })
    }
}

/// A condition on the velocities of two nodes, a·`signs` = 0, with the unknown that is its multiplier.
struct Condition {
    multiplier: usize,
    nodes: [usize; 2],
    signs: [f64; 2],
}

/// A pulley's radius, roughly, m.
const RADIUS: f64 = 0.06;

/// Scale of rows that hold a quantity: of the order of the other entries of its row.
pub(super) const HOLD: f64 = 1.0e6;

impl System for VariatorSystem {
    fn shape(&self) -> Shape {
        self.layout.shape()
    }

    fn has_position(&self) -> &[bool] {
        &self.has_position
    }

    fn residual(&mut self, time: f64, view: View<'_>, out: &mut [f64]) {
        self.move_loads(time);
        out.fill(0.0);
        self.sums = [PulleySum::default(); 2];
        if let Some(travelling) = self.travelling.clone() {
            with_ring!(&*travelling, ring => self.travelling_residual(ring, view, out));
        } else {
            for_kind!(&mut *self, assemble_residual(view, out));
        }
        self.global_residual(view, out);
        for c in self.gauge() {
            for (node, sign) in c.nodes.into_iter().zip(c.signs) {
                out[c.multiplier] += HOLD * sign * view.y[node];
                out[node] += HOLD * sign * view.y[c.multiplier];
            }
        }
    }

    fn jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        self.forget_derivatives();
        self.renew_jacobian(time, view, alpha, beta, out);
    }

    fn renew_jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        self.move_loads(time);
        out.clear();
        if let Some(travelling) = self.travelling.clone() {
            with_ring!(&*travelling, ring => self.travelling_jacobian(ring, view, alpha, beta, out));
        } else {
            for_kind!(&mut *self, assemble_jacobian(view, alpha, beta, out));
        }
        self.global_jacobian(view, alpha, beta, out);
        for c in self.gauge() {
            for (node, sign) in c.nodes.into_iter().zip(c.signs) {
                out.add(c.multiplier, node, HOLD * sign);
                out.add(node, c.multiplier, HOLD * sign);
            }
        }
    }

    fn newton_scale(&self, beta: f64, out: &mut [f64]) {
        let layout = &self.layout;
        // What does not matter: 1 nm of ring position (1 N of tension, 5 N/m of contact), 1e-7 of chain strain (1 N),
        // 2e-3 of the friction velocity; 0.1 N of tension where it is an unknown.
        let velocity = (1.0e-9 / beta).min(1.0e-3);
        let slip = 2.0e-3 * self.law.parameters.friction.velocity;
        if layout.flexible {
            for node in 0..layout.elements {
                for k in 0..2 * layout.components {
                    out[layout.node(node, k)] = if k % 2 == 0 { velocity } else { velocity * 1.0e3 };
                }
            }
        }
        if let (Some(t), Some(ring)) = (&layout.travelling, &self.travelling) {
            // Steps are short, so errors of velocity matter, not those of a step's way: they slide.
            let moving = velocity.min(10.0 * slip);
            for node in 0..t.nodes {
                for k in 0..t.block {
                    let length = if ring.is_length(k) { 1.0 } else { 1.0e3 };
                    out[layout.node(node, k)] = moving * length;
                }
            }
            out[layout.free()].fill(1.0);
        }
        if layout.flexible || layout.travelling.is_some() {
            for k in 0..2 {
                out[layout.global(Global::Gauge, k)] = 1.0 / HOLD;
            }
        }
        for (cell, &[speed, amount]) in self.cells_at.iter().enumerate() {
            out[speed] = slip;
            out[amount] = 1.0e-9;
            if layout.has_tension() {
                out[layout.tension(cell)] = 0.1;
            }
        }
        out[layout.global(Global::Drift, 0)] = slip;
        out[layout.global(Global::Theta, 0)] = velocity * 10.0;
        for j in [S, P] {
            out[layout.global(Global::Sheave, j)] = velocity;
            out[layout.global(Global::Tilt, 2 * j)] = 1.0e-8;
            out[layout.global(Global::Tilt, 2 * j + 1)] = 1.0e-8;
            out[layout.global(Global::Speed, j)] = slip / RADIUS;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::start::{Start, kinematic_state};
    use super::*;
    use crate::solver::State;
    use crate::solver::differences::compare;
    use pushbelt_lab::noise;

    /// A small variator with this ring, in the plane, on the aligned mesh.
    fn small(ring_model: RingModel) -> Parameters {
        let mut parameters = Parameters {
            ring_model,
            ..Parameters::default()
        };
        parameters.geometry.pulley_offset = 5.0e-4;
        (parameters.mesh.primary_arc, parameters.mesh.secondary_arc) = (4, 4);
        parameters.mesh.strand = 3;
        parameters
    }

    /// A variator at a state that slides, sticks, pushes and gaps.
    fn disturbed(parameters: &Parameters, speed: f64) -> (VariatorSystem, State) {
        let travels = parameters.ring_model.travels();
        let mut system = VariatorSystem::new(parameters);
        system.boundary = Boundary {
            sheave: [SheaveMode::Force(1.0e4), SheaveMode::Force(1.3e4)],
            speed: [SpeedMode::Torque(-40.0), SpeedMode::Torque(50.0)],
        };
        let start = Start {
            ratio: 1.2,
            primary_speed: speed,
            clamping: [1.0e4, 1.3e4],
        };
        let mut state = if travels {
            let ale = Parameters {
                ring_model: RingModel::Ale,
                ..parameters.clone()
            };
            let ale = VariatorSystem::new(&ale);
            system.lay_on(&ale, &kinematic_state(&ale, &start).unwrap())
        } else {
            kinematic_state(&system, &start).unwrap()
        };
        let mut random = noise(7);
        let n = state.y.len();
        let mut size = vec![0.0; n];
        let beta = 1.0e-4;
        system.newton_scale(beta, &mut size);
        for (i, &size) in size.iter().enumerate() {
            state.y[i] += 200.0 * size * random();
            state.y_dot[i] = 2000.0 * size * random();
            if system.has_position[i] {
                state.q[i] += 2000.0 * size * beta * random();
            }
        }
        if travels {
            state.q[system.layout.global(Global::Drift, 0)] += 0.0123;
        }
        (system, state)
    }

    /// The Jacobian against central differences.
    fn check_jacobian(parameters: &Parameters, speed: f64) {
        check_jacobian_by(parameters, speed, 0.4);
    }

    /// The same with steps of this share of what does not matter.
    fn check_jacobian_by(parameters: &Parameters, speed: f64, step: f64) {
        let (mut system, state) = disturbed(parameters, speed);
        let (alpha, beta) = (1.0e4, 1.0e-4);
        let mut size = vec![0.0; state.y.len()];
        system.newton_scale(beta, &mut size);
        // Strains of a ring that travels are differences of places: EA·ε of rounding in each force.
        let layout = system.layout;
        let coarse: Vec<bool> = (0..size.len())
            .map(|i| {
                layout.travelling.is_some_and(|t| {
                    let first = layout.node(0, 0);
                    let length = |k: usize| system.travelling.as_ref().is_some_and(|ring| ring.is_length(k));
                    (first..first + t.nodes * t.block).contains(&i) && length((i - first) % t.block)
                })
            })
            .collect();
        let h = |i: usize| size[i] * if coarse[i] { 2.0 } else { step };
        compare(&mut system, 0.0, &state, [alpha, beta], h, |entry| {
            let noise = 1e-15 * (entry.rounded + 1e3 / h(entry.column));
            let allowed = 2e-4 * entry.exact.abs() + 2e-7 * entry.largest + 20.0 * noise;
            assert!(
                (entry.difference - entry.exact).abs() < allowed,
                "{speed} rad/s, row {}: {entry:?}",
                entry.row
            );
        });
    }

    /// The derivatives by hand are those that forward differentiation finds, to rounding.
    #[test]
    fn derivatives_by_hand_are_those_of_forward_differentiation() {
        let of = |model: RingModel, spatial: bool, aligned: bool, tilt: f64| {
            let mut parameters = small(model);
            parameters.spatial = spatial;
            parameters.mesh.aligned = aligned;
            parameters.primary.tilt_stiffness = tilt;
            for speed in [200.0, -200.0, 0.0] {
                let (system, state) = disturbed(&parameters, speed);
                let worst = for_kind!(&system, worst_derivative(state.view(), 1.0e4));
                assert!(worst < 1e-9, "{model:?}, in space {spatial}, {speed} rad/s: {worst:e}");
            }
        };
        of(RingModel::Ale, false, true, 7e5);
        of(RingModel::Ale, true, true, 7e5);
        of(RingModel::Ale, false, false, 7e5);
        of(RingModel::Ale0, false, true, 1e12);
        of(RingModel::Ale0, false, false, 7e5);
    }

    /// Where nothing has changed derivatives are kept; a cell that begins to slip is differentiated again, with those
    /// that share its face; another step size asks for all of them.
    #[test]
    fn derivatives_are_kept_until_they_change() {
        let (mut system, mut state) = disturbed(&small(RingModel::Ale), 200.0);
        let shape = system.shape();
        let renewed = |system: &mut VariatorSystem, state: &State, alpha: f64| {
            let (before, mut matrix) = (system.differentiations(), Arrow::new(shape));
            system.renew_jacobian(0.0, state.view(), alpha, 1.0 / alpha, &mut matrix);
            (system.differentiations() - before, matrix)
        };
        let x = vec![1.0; shape.len()];
        let product = |matrix: &Arrow| {
            let mut product = vec![0.0; shape.len()];
            matrix.multiply(&x, &mut product);
            product
        };
        let packs = system.packs.len() as u64;
        let (all, first) = renewed(&mut system, &state, 1.0e4);
        let (none, again) = renewed(&mut system, &state, 1.0e4);
        assert_eq!((all, none), (packs, 0));
        assert_eq!(product(&first), product(&again));
        // In the middle of the primary arc, where the belt sticks.
        let face = system.layout.speed(14);
        state.y[face] += 0.5;
        let (some, changed) = renewed(&mut system, &state, 1.0e4);
        assert!((1..=2).contains(&some), "{some} of {packs}");
        let mut exact = Arrow::new(shape);
        system.jacobian(0.0, state.view(), 1.0e4, 1.0e-4, &mut exact);
        assert_ne!(product(&first)[face], product(&changed)[face]);
        assert_eq!(product(&exact)[face], product(&changed)[face]);
        assert_eq!(renewed(&mut system, &state, 2.0e4).0, packs);
    }

    /// The nodes of a ring that travels are interchangeable: counted from another one, with s an element on, the
    /// residual is the same.
    #[test]
    fn a_travelling_ring_may_be_counted_from_any_node() {
        for model in [RingModel::Rcm, RingModel::Ancf] {
            let (mut system, state) = disturbed(&small(model), 200.0);
            let (layout, n) = (system.layout, state.y.len());
            let travelling = layout.travelling.expect("it travels");
            // Where an unknown stands when the nodes are counted from the one before.
            let counted_on = |i: usize| {
                let first = layout.node(0, 0);
                let nodes = first..first + travelling.nodes * travelling.block;
                if nodes.contains(&i) {
                    first + (i - first + travelling.block) % nodes.len()
                } else {
                    i
                }
            };
            let mut other = state.clone();
            for i in 0..n {
                other.y[counted_on(i)] = state.y[i];
                other.y_dot[counted_on(i)] = state.y_dot[i];
                other.q[counted_on(i)] = state.q[i];
            }
            for _ in 0..travelling.nodes + 1 {
                other.q[layout.global(Global::Drift, 0)] -= travelling.length;
            }
            let mut residuals = [vec![0.0; n], vec![0.0; n]];
            system.residual(0.0, state.view(), &mut residuals[0]);
            system.residual(0.0, other.view(), &mut residuals[1]);
            let largest = residuals[0].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for i in 0..n {
                let [one, two] = [residuals[0][i], residuals[1][counted_on(i)]];
                assert!((one - two).abs() < 1e-9 * largest, "row {i}: {one} {two}, {largest}");
            }
        }
    }

    #[test]
    fn jacobians_of_rings_that_travel_match_differences() {
        check_jacobian(&small(RingModel::Rcm), 200.0);
        check_jacobian(&small(RingModel::Ancf), -200.0);
    }

    #[test]
    fn jacobian_of_ale_matches_differences() {
        check_jacobian(&small(RingModel::Ale), 200.0);
        check_jacobian(&small(RingModel::Ale), -200.0);
    }

    #[test]
    fn jacobian_on_evenly_spaced_elements_matches_differences() {
        let even = |model, spatial| {
            let mut parameters = small(model);
            (parameters.mesh.aligned, parameters.spatial) = (false, spatial);
            parameters
        };
        check_jacobian(&even(RingModel::Ale, false), 200.0);
        check_jacobian(&even(RingModel::Ale, true), -200.0);
        check_jacobian(&even(RingModel::Ale0, false), 200.0);
    }

    #[test]
    fn jacobian_in_directions_of_the_curve_matches_differences() {
        for spatial in [false, true] {
            let parameters = Parameters {
                reference_directions: true,
                spatial,
                ..small(RingModel::Ale)
            };
            // Friction bends more sharply over a step of these coordinates.
            check_jacobian_by(&parameters, if spatial { -200.0 } else { 200.0 }, 0.16);
        }
    }

    #[test]
    fn jacobian_in_space_matches_differences() {
        let spatial = Parameters {
            spatial: true,
            ..small(RingModel::Ale)
        };
        check_jacobian_by(&spatial, 200.0, 0.2);
        check_jacobian_by(&spatial, -200.0, 0.2);
    }

    /// Space mirrored in the plane of the drive: sheaves on the other sides, w the other way, everything else alike.
    #[test]
    fn mirrored_in_the_plane() {
        let mut parameters = Parameters {
            spatial: true,
            ..Parameters::default()
        };
        parameters.geometry.pulley_offset = 7.0e-4;
        let mut system = VariatorSystem::new(&parameters);
        let start = Start {
            ratio: 1.6,
            primary_speed: 200.0,
            clamping: [1.0e4, 1.3e4],
        };
        let mut state = kinematic_state(&system, &start).unwrap();
        let mut random = noise(3);
        let mut size = vec![0.0; state.y.len()];
        system.newton_scale(1.0e-4, &mut size);
        for (i, &size) in size.iter().enumerate() {
            state.y[i] += 200.0 * size * random();
            state.q[i] += 0.1 * size * random();
        }
        let mut other = system.clone();
        for plane in &mut other.law.planes {
            (plane.side, plane.middle) = (-plane.side, -plane.middle);
        }
        other.pack();
        let mut mirrored = state.clone();
        let places: Vec<usize> = (0..system.layout.elements)
            .flat_map(|node| [4, 5].map(|k| system.layout.node(node, k)))
            .collect();
        for &i in &places {
            for values in [&mut mirrored.y, &mut mirrored.y_dot, &mut mirrored.q] {
                values[i] = -values[i];
            }
        }
        let (mut rows, mut reflected) = (vec![0.0; size.len()], vec![0.0; size.len()]);
        system.residual(0.0, state.view(), &mut rows);
        other.residual(0.0, mirrored.view(), &mut reflected);
        for &i in &places {
            reflected[i] = -reflected[i];
        }
        assert!(places.iter().any(|&i| rows[i].abs() > 1.0));
        assert_eq!(rows, reflected);
    }

    #[test]
    fn jacobian_of_ale0_matches_differences() {
        check_jacobian(&small(RingModel::Ale0), 200.0);
        check_jacobian(&small(RingModel::Ale0), 0.0);
    }
}
