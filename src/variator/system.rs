//! The variator as an implicit system: cells, pulleys and boundary conditions assembled, with the exact Jacobian.

use super::cell::{CellBalance, CellLaw, CellMotion, NoProbe, Place, PulleyMotion, Sample, Sampler, balance};
use super::evolution::Ledger;
use super::layout::{Global, Layout};
use super::mesh::{BeltMesh, P, S, Station};
use super::parameters::{Parameters, Pulley, RIGID_TILT_STIFFNESS, RingModel, SPEED_LAG};
use crate::chain;
use crate::pulley::Travel;
use crate::reference_curve::{Jet, ReferenceCurve, TwoPulley, TwoPulleyFrame};
use crate::ring::kinematics::{Hermite, Motion, Node, ReferenceMotion};
use crate::scalar::{LANES, Lanes, Real, Tangent};
use crate::solver::arrow::{Arrow, Shape};
use crate::solver::{System, View};
use crate::tape::Tape;
use nalgebra::Vector2;
use num_traits::Zero;

/// Derivative directions of a cell with a deflecting ring: 8 node motions, V, V, N, and six globals.
const FLEXIBLE: usize = 17;
/// Derivative directions of a cell of `ALE0`: V, V, N, T, T, and six globals.
const RIGID: usize = 11;
/// Directions before the globals.
const FLEXIBLE_LOCAL: usize = 11;
const RIGID_LOCAL: usize = 5;

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;

/// Cells that are computed at once, one in each lane. They lie on the same segment, next to each other.
#[derive(Clone, Debug)]
struct Pack {
    /// Cells; the last one repeats where there are fewer than lanes.
    cells: [usize; LANES],
    /// Lanes in use.
    used: usize,
    segment: usize,
    share: Lanes,
    face: Station<Lanes>,
    stations: Vec<Station<Lanes>>,
    axis: Lanes,
    /// Unknowns of the directions.
    at: [[usize; LANES]; FLEXIBLE],
    /// Places of the derivatives in the matrix: row by row, the amount's left out, a direction after the other.
    entries: Vec<[usize; LANES]>,
}

/// Positions, values and rates of the unknowns of a cell, or of one in each lane.
struct Unknowns<L> {
    position: [L; FLEXIBLE],
    value: [L; FLEXIBLE],
    rate: [L; FLEXIBLE],
}

impl<L: Copy> Unknowns<L> {
    #[inline(always)]
    fn gather(view: View<'_>, count: usize, zero: L, pick: impl Fn(&[f64], usize) -> L) -> Self {
        let gather = |from: &[f64]| {
            let mut to = [zero; FLEXIBLE];
            for (k, x) in to[..count].iter_mut().enumerate() {
                *x = pick(from, k);
            }
            to
        };
        Self {
            position: gather(view.q),
            value: gather(view.y),
            rate: gather(view.y_dot),
        }
    }
}

impl Station<Lanes> {
    fn pack(stations: [&Station; LANES]) -> Self {
        let each = |f: &dyn Fn(&Station) -> f64| Lanes::new(stations.map(f));
        Self {
            fraction: each(&|s| s.fraction),
            shape: Hermite {
                n: std::array::from_fn(|k| each(&|s| s.shape.n[k])),
                dn: std::array::from_fn(|k| each(&|s| s.shape.dn[k])),
                ddn: std::array::from_fn(|k| each(&|s| s.shape.ddn[k])),
            },
            weight: each(&|s| s.weight),
            right: each(&|s| s.right),
        }
    }
}

/// How a sheave's axial position is determined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SheaveMode {
    /// By the clamping force, N.
    Force(f64),
    /// It stands still.
    Held,
    /// It goes where Θ takes the value `theta`: the clamping force is `force` + [`RATIO_STIFFNESS`]·(`theta` − Θ), and
    /// whoever solves for a steady state moves `force` to the reaction.
    Ratio {
        /// Θ to go to.
        theta: f64,
        /// Force at `theta`, N.
        force: f64,
    },
}

/// Stiffness with which a steady solution is drawn to its ratio, N per unit of Θ.
pub const RATIO_STIFFNESS: f64 = 2.0e7;

/// How a pulley's speed is determined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedMode {
    /// By the external torque, N·m.
    Torque(f64),
    /// It follows the set point with a lag, rad/s.
    Setpoint(f64),
    /// It stays what it is.
    Fixed,
    /// Secondary only: both speeds change in proportion, ω̇_S/ω_S = ω̇_P/ω_P, under the two external torques, N·m.
    Balanced(f64, f64),
    /// Secondary only: it goes where the belt takes the given torque from the primary shaft, N·m.
    Transmit(f64),
}

/// Boundary conditions, over pulleys [`S`], [`P`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Sheaves.
    pub sheave: [SheaveMode; 2],
    /// Shafts.
    pub speed: [SpeedMode; 2],
}

impl Boundary {
    fn pass(&mut self, tape: &mut Tape<'_>) {
        for sheave in &mut self.sheave {
            if let SheaveMode::Force(force) = sheave {
                tape.real(force);
            }
        }
        for speed in &mut self.speed {
            if let SpeedMode::Torque(load) | SpeedMode::Setpoint(load) = speed {
                tape.real(load);
            }
        }
    }
}

/// How fast the loads of a [`Boundary`] change, over pulleys [`S`], [`P`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadRates {
    /// Of clamping forces, N/s.
    pub force: [f64; 2],
    /// Of external torques, N·m/s, or of speed set points, rad/s².
    pub speed: [f64; 2],
}

/// Loads that change in proportion to time.
#[derive(Clone, Copy, Debug)]
struct Course {
    /// Time at which the loads are those of `start`, s.
    from: f64,
    start: Boundary,
    rates: LoadRates,
}

impl Course {
    fn at(&self, time: f64) -> Boundary {
        let after = time - self.from;
        let mut boundary = self.start;
        for j in [S, P] {
            if let SheaveMode::Force(force) = &mut boundary.sheave[j] {
                // A falling force ends at zero: sheaves are pushed, never pulled.
                *force = (*force + after * self.rates.force[j]).max(0.0);
            }
            if let SpeedMode::Torque(load) | SpeedMode::Setpoint(load) = &mut boundary.speed[j] {
                *load += after * self.rates.speed[j];
            }
        }
        boundary
    }
}

/// The whole dynamic state: unknowns, their rates, positions.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Unknowns y in the order of [`Layout`].
    pub y: Vec<f64>,
    /// Rates ẏ.
    pub y_dot: Vec<f64>,
    /// Positions q with q̇ = y.
    pub q: Vec<f64>,
}

impl State {
    /// View for a residual.
    #[must_use]
    pub fn view(&self) -> View<'_> {
        View {
            y: &self.y,
            y_dot: &self.y_dot,
            q: &self.q,
        }
    }
}

/// Sums over the cells of a pulley.
#[derive(Clone, Copy, Debug, Default)]
struct PulleySum {
    axial: f64,
    tilting: [f64; 2],
    torque: f64,
}

/// A condition of the gauge: its multiplier, two components of nodes and their signs.
type Condition = (usize, [usize; 2], [f64; 2]);

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
    course: Option<Course>,
    /// Time of the boundary conditions while loads change, s.
    clock: f64,
    /// Factor on the pulleys' inertia, 1 in a run. A steady solution takes more, so that speeds follow the belt instead of
    /// running ahead of it.
    pub inertia_factor: f64,
    /// Energies since the start.
    pub ledger: Ledger,
    has_position: Vec<bool>,
    packs: Vec<Pack>,
    flows: Vec<(f64, f64)>,
    sums: [PulleySum; 2],
    flow_slopes: Vec<[[f64; FLEXIBLE]; 2]>,
    /// Places of ∂(flux)/∂(directions of a cell) in the rows of the amounts before and in the cell; then the same for
    /// the directions of the cell before.
    flux_entries: Vec<[[[usize; 2]; FLEXIBLE]; 2]>,
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
        let mesh = BeltMesh::new(&parameters.mesh);
        let layout = Layout::new(&mesh, parameters.ring_model == RingModel::Ale);
        let mut has_position = vec![false; layout.len()];
        if layout.flexible {
            for node in 0..layout.elements {
                for k in 0..4 {
                    has_position[layout.node(node, k)] = true;
                }
            }
        }
        has_position[layout.global(Global::Drift, 0)] = true;
        has_position[layout.global(Global::Theta, 0)] = true;
        for j in [S, P] {
            has_position[layout.global(Global::Sheave, j)] = true;
        }
        let cells = mesh.cells.len();
        let travel = [S, P].map(|j| Travel::new(pulley(parameters, j), r0, sin / cos));
        let mut system = Self {
            law: CellLaw {
                parameters: parameters.clone(),
                wedge: [sin, cos, sin / cos],
                r0,
                axes: [0.0, geometry.center_distance],
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
            clock: 0.0,
            inertia_factor: 1.0,
            ledger: Ledger::default(),
            has_position,
            flows: vec![(0.0, 0.0); cells],
            sums: [PulleySum::default(); 2],
            flow_slopes: vec![[[0.0; FLEXIBLE]; 2]; cells],
            packs: Vec::new(),
            flux_entries: Vec::new(),
        };
        system.pack();
        system
    }

    /// Puts boundary conditions in force that hold at time `from` and whose loads change at `rates`, as they are at `time`.
    /// Of `y_dot` see [`Self::change_boundary`].
    pub fn change_loads(&mut self, from: f64, boundary: Boundary, rates: LoadRates, time: f64, y_dot: &mut [f64]) {
        let course = Course {
            from,
            start: boundary,
            rates,
        };
        self.course = (rates != LoadRates::default()).then_some(course);
        self.clock = time;
        self.change_boundary(self.course.map_or(boundary, |course| course.at(time)), y_dot);
    }

    /// Passes by a tape the loads and how they change. To read, boundary conditions of the same kinds must be in force.
    pub fn pass_loads(&mut self, tape: &mut Tape<'_>) {
        self.boundary.pass(tape);
        let mut changes = self.course.is_some();
        tape.flag(&mut changes);
        if changes {
            let course = self.course.get_or_insert(Course {
                from: 0.0,
                start: self.boundary,
                rates: LoadRates::default(),
            });
            tape.real(&mut course.from);
            course.start.pass(tape);
            tape.reals(&mut course.rates.force);
            tape.reals(&mut course.rates.speed);
        } else {
            self.course = None;
        }
    }

    /// Moves loads that change with time on, or back, to `time`.
    pub fn move_loads(&mut self, time: f64) {
        if let Some(course) = &self.course {
            self.boundary = course.at(time);
            self.clock = time;
        }
    }

    /// Time for which the loads stand while they change, s.
    pub(super) fn load_time(&self) -> f64 {
        self.clock
    }

    /// Packs neighbours, and finds the places of their derivatives.
    fn pack(&mut self) {
        let shape = self.layout.shape();
        let cells = self.mesh.cells.len();
        let segment = |cell: usize| self.mesh.elements[self.mesh.cells[cell].element].segment;
        let directions = |cell: usize| {
            let mut at = [0; FLEXIBLE];
            let count = self.directions(cell, &mut at);
            (at, count)
        };
        let amount = self.amount_direction();
        let mut packs = Vec::new();
        let mut first = 0;
        while first < cells {
            let used = (1..LANES)
                .take_while(|&i| first + i < cells && segment(first + i) == segment(first))
                .count()
                + 1;
            let cell: [usize; LANES] = std::array::from_fn(|lane| first + lane.min(used - 1));
            let member = cell.map(|c| &self.mesh.cells[c]);
            let at = cell.map(directions);
            let count = at[0].1;
            let mut entries = Vec::new();
            for row in (0..count).filter(|&row| row != amount) {
                for column in 0..count {
                    entries
                        .push(at.map(|(at, _)| shape.index(at[row], at[column]).expect("neighbours are in the band")));
                }
            }
            packs.push(Pack {
                cells: cell,
                used,
                segment: segment(first),
                share: Lanes::new(member.map(|c| self.mesh.elements[c.element].share)),
                face: Station::pack(member.map(|c| &c.face)),
                stations: (0..member[0].stations.len())
                    .map(|i| Station::pack(member.map(|c| &c.stations[i])))
                    .collect(),
                axis: Lanes::new(member.map(|c| self.law.axes[c.pulley])),
                at: std::array::from_fn(|k| at.map(|(at, _)| at[k])),
                entries,
            });
            first += used;
        }
        self.flux_entries = (0..cells)
            .map(|cell| {
                let before = (cell + cells - 1) % cells;
                let rows = [self.layout.amount(before), self.layout.amount(cell)];
                [cell, before].map(|of| {
                    let (at, count) = directions(of);
                    std::array::from_fn(|k| {
                        // With one cell in an element, its density's dependence on the far node (ring stretch, reverse
                        // flow only) would leave the band.
                        rows.map(|row| {
                            if k < count {
                                shape.index(row, at[k]).unwrap_or(NOWHERE)
                            } else {
                                NOWHERE
                            }
                        })
                    })
                })
            })
            .collect();
        self.packs = packs;
    }

    /// The direction that is the element amount, whose row the fluxes fill.
    fn amount_direction(&self) -> usize {
        if self.layout.flexible { 10 } else { 2 }
    }

    /// Parameters of a pulley.
    #[must_use]
    pub fn pulley(&self, j: usize) -> &Pulley {
        pulley(&self.law.parameters, j)
    }

    /// Whether a sheave counts as rigid.
    #[must_use]
    pub fn rigid(&self, j: usize) -> bool {
        self.pulley(j).tilt_stiffness >= RIGID_TILT_STIFFNESS
    }

    /// Global indices of a cell's directions: its own unknowns, then s, Θ, z, ψ_x, ψ_y, ω.
    fn directions(&self, cell: usize, out: &mut [usize; FLEXIBLE]) -> usize {
        let layout = &self.layout;
        let place = &self.mesh.cells[cell];
        let local = if layout.flexible {
            for i in 0..2 {
                for k in 0..4 {
                    out[4 * i + k] = layout.node(place.element + i, k);
                }
            }
            out[8] = layout.speed(cell);
            out[9] = layout.speed(cell + 1);
            out[10] = layout.amount(cell);
            FLEXIBLE_LOCAL
        } else {
            out[0] = layout.speed(cell);
            out[1] = layout.speed(cell + 1);
            out[2] = layout.amount(cell);
            out[3] = layout.tension(cell);
            out[4] = layout.tension(cell + 1);
            RIGID_LOCAL
        };
        let j = place.pulley;
        out[local] = layout.global(Global::Drift, 0);
        out[local + 1] = layout.global(Global::Theta, 0);
        out[local + 2] = layout.global(Global::Sheave, j);
        out[local + 3] = layout.global(Global::Tilt, 2 * j);
        out[local + 4] = layout.global(Global::Tilt, 2 * j + 1);
        out[local + 5] = layout.global(Global::Speed, j);
        local + 6
    }

    /// Motion of a cell; `seed` makes a scalar of a value, its direction and its slope.
    #[inline(always)]
    fn motion<T: Real>(
        unknowns: &Unknowns<T::Constant>,
        flexible: bool,
        [alpha, beta]: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> CellMotion<T> {
        let value = |k: usize| seed(unknowns.value[k], k, 1.0);
        let rate = |k: usize| seed(unknowns.rate[k], k, alpha);
        let position = |k: usize| seed(unknowns.position[k], k, beta);
        let (nodes, own, g, tension) = if flexible {
            let node = |i: usize| Motion {
                value: node(i, position),
                rate: node(i, value),
                acceleration: node(i, rate),
            };
            (Some([node(0), node(1)]), 8, FLEXIBLE_LOCAL, [T::zero(); 2])
        } else {
            (None, 0, RIGID_LOCAL, [value(3), value(4)])
        };
        CellMotion {
            nodes,
            speed: [value(own), value(own + 1)],
            speed_dot: [rate(own), rate(own + 1)],
            amount: value(own + 2),
            tension,
            reference: ReferenceMotion {
                theta: Motion {
                    value: position(g + 1),
                    rate: value(g + 1),
                    acceleration: rate(g + 1),
                },
                s_dot: value(g),
                s_ddot: rate(g),
            },
            pulley: PulleyMotion {
                z: position(g + 2),
                z_dot: value(g + 2),
                psi: [value(g + 3), value(g + 4)],
                psi_dot: [rate(g + 3), rate(g + 4)],
                omega: value(g + 5),
            },
        }
    }

    /// Rows of the balance in the order of the directions; the amount has its own balance, the flux.
    #[inline(always)]
    fn rows<T: Real>(b: &CellBalance<T>, flexible: bool) -> [T; FLEXIBLE] {
        let mut rows = [T::zero(); FLEXIBLE];
        let g = if flexible {
            for (i, node) in b.nodes.iter().enumerate() {
                rows[4 * i] = node.a.x;
                rows[4 * i + 1] = node.b.x;
                rows[4 * i + 2] = node.a.y;
                rows[4 * i + 3] = node.b.y;
            }
            rows[8] = b.speed[0];
            rows[9] = b.speed[1];
            FLEXIBLE_LOCAL
        } else {
            rows[0] = b.speed[0];
            rows[1] = b.speed[1];
            rows[3] = b.tension;
            RIGID_LOCAL
        };
        rows[g] = b.drift;
        rows[g + 1] = b.theta;
        rows[g + 2] = b.axial;
        rows[g + 3] = -b.tilting[0];
        rows[g + 4] = -b.tilting[1];
        rows[g + 5] = -b.torque;
        rows
    }

    /// The gauge: s and Θ repeat motions that q_f can make, so two conditions hold the overlay, with multipliers in the
    /// border. They are even in the two pulleys, so swapping these is a symmetry of the discrete system: the deflections
    /// of node 0 and of the node opposite are equal outwards (which fixes what Θ means) and opposite along the curve
    /// (which fixes s). In x and y: (condition, the two unknowns, their signs).
    fn gauge(&self) -> Option<[Condition; 2]> {
        let layout = &self.layout;
        layout.flexible.then(|| {
            [(0, [1.0, 1.0]), (1, [1.0, -1.0])].map(|(k, signs)| {
                let nodes = [0, layout.opposite].map(|node| layout.node(node, 2 * k));
                (layout.global(Global::Gauge, k), nodes, signs)
            })
        })
    }

    /// Evaluates every station; `ENERGY` asks for the energies too.
    pub fn probe<const ENERGY: bool>(&self, view: View<'_>, mut probe: impl FnMut(usize, &Sample)) {
        let frame = self.curve.frame(self.theta(view));
        let mut at = [0; FLEXIBLE];
        for (i, cell) in self.mesh.cells.iter().enumerate() {
            let count = self.directions(i, &mut at);
            let unknowns = Unknowns::gather(view, count, 0.0, |from, k| from[at[k]]);
            let motion = Self::motion(&unknowns, self.layout.flexible, [0.0; 2], |value, _, _| value);
            let element = &self.mesh.elements[cell.element];
            let place = Place {
                face: &cell.face,
                stations: &cell.stations,
                axis: self.law.axes[cell.pulley],
                length: Jet::constant(0.0)
                    .plus_scaled(TwoPulley::segment_length(&frame, element.segment), element.share),
            };
            let reference = |slot: usize| {
                let station = if slot == 0 {
                    &cell.face
                } else {
                    &cell.stations[slot - 1]
                };
                TwoPulley::point(&frame, element.segment, station.fraction)
            };
            let mut sampler = Sampler::<_, ENERGY>(|s: &Sample| probe(i, s));
            balance(&self.law, &place, &motion, reference, &mut sampler);
        }
    }

    fn theta(&self, view: View<'_>) -> f64 {
        view.q[self.layout.global(Global::Theta, 0)]
    }

    /// The balance of a pack of cells.
    #[inline(always)]
    fn pack_balance<T: Real<Constant = Lanes>>(
        &self,
        pack: &Pack,
        frame: &TwoPulleyFrame<T>,
        motion: &CellMotion<T>,
    ) -> CellBalance<T> {
        let place = Place {
            face: &pack.face,
            stations: &pack.stations,
            axis: pack.axis,
            length: Jet::constant(0.0).plus_scaled(TwoPulley::segment_length(frame, pack.segment), pack.share),
        };
        let reference = |slot: usize| {
            let station = if slot == 0 {
                &pack.face
            } else {
                &pack.stations[slot - 1]
            };
            TwoPulley::point(frame, pack.segment, station.fraction)
        };
        balance(&self.law, &place, motion, reference, &mut NoProbe)
    }

    #[inline(always)]
    fn gather(&self, view: View<'_>, pack: &Pack, count: usize) -> Unknowns<Lanes> {
        Unknowns::gather(view, count, Lanes::zero(), |from, k| {
            Lanes::new(pack.at[k].map(|i| from[i]))
        })
    }

    /// Axial force on one sheave, N, and torque of the belt on the pulley, N·m, as of the last residual.
    #[must_use]
    pub fn belt_load(&self, j: usize) -> (f64, f64) {
        (self.sums[j].axial, self.sums[j].torque)
    }

    fn balanced_factor(&self, view: View<'_>) -> f64 {
        let omega = |j| view.y[self.layout.global(Global::Speed, j)];
        let primary = self.pulley(P).inertia * omega(P);
        if primary == 0.0 {
            0.0
        } else {
            self.pulley(S).inertia * omega(S) / primary
        }
    }

    /// One pass over a pack: derivatives in the directions `first` and on.
    #[inline(never)]
    fn pack_pass<const FLEX: bool>(
        &self,
        pack: &Pack,
        frame: &TwoPulleyFrame<Tangent<PASS>>,
        unknowns: &Unknowns<Lanes>,
        slopes: [f64; 2],
        first: usize,
    ) -> ([Tangent<PASS>; FLEXIBLE], Tangent<PASS>, Tangent<PASS>) {
        let seed =
            |value: Lanes, direction: usize, slope: f64| Tangent::seed(value, direction.wrapping_sub(first), slope);
        let motion = Self::motion(unknowns, FLEX, slopes, seed);
        let b = self.pack_balance(pack, frame, &motion);
        (Self::rows(&b, FLEX), b.flow, b.density)
    }

    fn assemble_residual<const FLEX: bool>(&mut self, view: View<'_>, out: &mut [f64]) {
        let count = if FLEX { FLEXIBLE } else { RIGID };
        let amount = self.amount_direction();
        let first_global = if FLEX { FLEXIBLE_LOCAL } else { RIGID_LOCAL } + 2;
        let frame = self.curve.shape(self.theta(view)).frame(Lanes::zero());
        for pack in &self.packs {
            let unknowns = self.gather(view, pack, count);
            let motion = Self::motion(&unknowns, FLEX, [0.0; 2], |value, _, _| value);
            let b = self.pack_balance(pack, &frame, &motion);
            // s and Θ go straight into the residual; the pulley's rows need its whole sum first.
            for (k, (row, at)) in Self::rows(&b, FLEX)[..first_global].iter().zip(&pack.at).enumerate() {
                if k != amount {
                    let row = row.to_array();
                    for lane in 0..pack.used {
                        out[at[lane]] += row[lane];
                    }
                }
            }
            let [axial, torque, x, y, flow, density] =
                [b.axial, b.torque, b.tilting[0], b.tilting[1], b.flow, b.density].map(Lanes::to_array);
            for lane in 0..pack.used {
                let cell = pack.cells[lane];
                let sum = &mut self.sums[self.mesh.cells[cell].pulley];
                sum.axial += axial[lane];
                sum.torque += torque[lane];
                sum.tilting[0] += x[lane];
                sum.tilting[1] += y[lane];
                self.flows[cell] = (flow[lane], density[lane]);
            }
        }
    }

    fn assemble_jacobian<const FLEX: bool>(&mut self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        let (count, theta) = if FLEX {
            (FLEXIBLE, FLEXIBLE_LOCAL + 1)
        } else {
            (RIGID, RIGID_LOCAL + 1)
        };
        let amount = self.amount_direction();
        let shape = self.curve.shape(self.theta(view));
        let still = shape.frame(Tangent::zero());
        let moving = shape.frame(Tangent::seed(Lanes::zero(), theta % PASS, beta));
        for pack in &self.packs {
            let unknowns = self.gather(view, pack, count);
            for first in (0..count).step_by(PASS) {
                let frame = if first == theta / PASS * PASS { &moving } else { &still };
                let pass = first..(first + PASS).min(count);
                let (rows, flow, density) = self.pack_pass::<FLEX>(pack, frame, &unknowns, [alpha, beta], first);
                let rows = rows[..count].iter().enumerate().filter(|(k, _)| *k != amount);
                for ((_, row), entries) in rows.zip(pack.entries.chunks_exact(count)) {
                    for (eps, entry) in row.eps.iter().zip(&entries[pass.clone()]) {
                        let eps = eps.to_array();
                        for lane in 0..pack.used {
                            out.add_at(entry[lane], eps[lane]);
                        }
                    }
                }
                for (lane, (f, d)) in flow.re.to_array().into_iter().zip(density.re.to_array()).enumerate() {
                    self.flows[pack.cells[lane]] = (f, d);
                }
                for ((l, f), d) in pass.clone().zip(&flow.eps).zip(&density.eps) {
                    for (lane, (f, d)) in f.to_array().into_iter().zip(d.to_array()).enumerate() {
                        let [flow, density] = &mut self.flow_slopes[pack.cells[lane]];
                        flow[l] = f;
                        density[l] = d;
                    }
                }
            }
        }
        for cell in 0..self.mesh.cells.len() {
            let row = self.layout.amount(cell);
            out.add(row, row, alpha);
        }
        // Fluxes through the left faces.
        let cells = self.mesh.cells.len();
        for cell in 0..cells {
            let before = (cell + cells - 1) % cells;
            let ((flow, after), (_, density_before)) = (self.flows[cell], self.flows[before]);
            let [by_flow, by_before, by_after] = chain::flux_slopes(flow, density_before, after);
            let [flow, density] = &self.flow_slopes[cell];
            let [_, density_before] = &self.flow_slopes[before];
            let [own, other] = &self.flux_entries[cell];
            for k in 0..count {
                let slope = by_flow * flow[k] + by_after * density[k];
                let slope_before = by_before * density_before[k];
                for (entries, slope) in [(own[k], slope), (other[k], slope_before)] {
                    for (entry, value) in entries.into_iter().zip([slope, -slope]) {
                        if entry != NOWHERE {
                            out.add_at(entry, value);
                        }
                    }
                }
            }
        }
    }

    /// Puts `boundary` in force. External loads act on the pulleys' own inertia alone, so the rates `y_dot` that jump with
    /// them are known; the integrator's error estimate needs them.
    pub fn change_boundary(&mut self, boundary: Boundary, y_dot: &mut [f64]) {
        for j in [S, P] {
            let pulley = self.pulley(j);
            if let (SheaveMode::Force(old), SheaveMode::Force(new)) = (self.boundary.sheave[j], boundary.sheave[j]) {
                y_dot[self.layout.global(Global::Sheave, j)] += (new - old) / pulley.sheave_mass;
            }
            let omega = self.layout.global(Global::Speed, j);
            match (self.boundary.speed[j], boundary.speed[j]) {
                (SpeedMode::Torque(old), SpeedMode::Torque(new)) => y_dot[omega] += (new - old) / pulley.inertia,
                (SpeedMode::Setpoint(old), SpeedMode::Setpoint(new)) => y_dot[omega] += (new - old) / SPEED_LAG,
                _ => {}
            }
        }
        self.boundary = boundary;
    }

    /// Adds the pulleys' own terms to the residual; `sums` hold the belt's.
    fn global_residual(&self, view: View<'_>, out: &mut [f64]) {
        for j in [S, P] {
            let pulley = self.pulley(j);
            let sum = &self.sums[j];
            let z = self.layout.global(Global::Sheave, j);
            out[z] = match self.boundary.sheave[j] {
                SheaveMode::Force(force) => {
                    pulley.sheave_mass * view.y_dot[z] + pulley.sheave_damping * view.y[z] - force + sum.axial
                        - self.travel[j].stop_force(view.q[z], view.y[z]).force
                }
                SheaveMode::Held => HOLD * view.y[z],
                SheaveMode::Ratio { theta, force } => {
                    let off = theta - view.q[self.layout.global(Global::Theta, 0)];
                    let sign = if j == P { 1.0 } else { -1.0 };
                    pulley.sheave_mass * view.y_dot[z] + pulley.sheave_damping * view.y[z] + sum.axial
                        - force
                        - sign * RATIO_STIFFNESS * off
                        - self.travel[j].stop_force(view.q[z], view.y[z]).force
                }
            };
            for k in 0..2 {
                let i = self.layout.global(Global::Tilt, 2 * j + k);
                out[i] = if self.rigid(j) {
                    HOLD * view.y[i]
                } else {
                    pulley.tilt_stiffness * (view.y[i] + pulley.tilt_time * view.y_dot[i]) - sum.tilting[k]
                };
            }
            let i = self.layout.global(Global::Speed, j);
            let inertia = self.inertia_factor * pulley.inertia * view.y_dot[i];
            out[i] = match self.boundary.speed[j] {
                SpeedMode::Torque(torque) => inertia - torque - sum.torque,
                SpeedMode::Setpoint(set) => {
                    inertia - self.inertia_factor * pulley.inertia * (set - view.y[i]) / SPEED_LAG
                }
                SpeedMode::Fixed => inertia,
                SpeedMode::Balanced(own, primary) => {
                    inertia - own - sum.torque + self.balanced_factor(view) * (primary + self.sums[P].torque)
                }
                SpeedMode::Transmit(primary) => inertia + primary + self.sums[P].torque,
            };
        }
    }

    fn global_jacobian(&self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        use num_dual::Dual64;
        for j in [S, P] {
            let pulley = self.pulley(j);
            let z = self.layout.global(Global::Sheave, j);
            match self.boundary.sheave[j] {
                SheaveMode::Force(_) | SheaveMode::Ratio { .. } => {
                    let stop = self.travel[j]
                        .stop_force(Dual64::new(view.q[z], beta), Dual64::new(view.y[z], 1.0))
                        .force
                        .eps;
                    out.add(z, z, pulley.sheave_mass * alpha + pulley.sheave_damping - stop);
                    if let SheaveMode::Ratio { .. } = self.boundary.sheave[j] {
                        let sign = if j == P { 1.0 } else { -1.0 };
                        out.add(z, self.layout.global(Global::Theta, 0), sign * RATIO_STIFFNESS * beta);
                    }
                }
                SheaveMode::Held => out.set_unit_row(z, HOLD),
            }
            for k in 0..2 {
                let i = self.layout.global(Global::Tilt, 2 * j + k);
                if self.rigid(j) {
                    out.set_unit_row(i, HOLD);
                } else {
                    out.add(i, i, pulley.tilt_stiffness * (1.0 + pulley.tilt_time * alpha));
                }
            }
        }
        // Secondary first: its row may need the primary's before that is overwritten.
        let (s, p) = (
            self.layout.global(Global::Speed, S),
            self.layout.global(Global::Speed, P),
        );
        match self.boundary.speed[S] {
            SpeedMode::Balanced(_, primary) => {
                let factor = self.balanced_factor(view);
                out.add_row(s, p, -factor);
                let unbalanced = primary + self.sums[P].torque;
                let omega = view.y[p];
                if omega != 0.0 {
                    out.add(
                        s,
                        s,
                        unbalanced * self.pulley(S).inertia / (self.pulley(P).inertia * omega),
                    );
                }
            }
            SpeedMode::Transmit(_) => {
                out.set_unit_row(s, 0.0);
                out.add_row(s, p, -1.0);
            }
            _ => {}
        }
        for j in [S, P] {
            let i = self.layout.global(Global::Speed, j);
            let inertia = self.inertia_factor * self.pulley(j).inertia;
            match self.boundary.speed[j] {
                SpeedMode::Setpoint(_) => out.set_unit_row(i, inertia * (alpha + 1.0 / SPEED_LAG)),
                SpeedMode::Fixed => out.set_unit_row(i, inertia * alpha.max(1.0)),
                _ => out.add(i, i, inertia * alpha),
            }
        }
    }
}

/// Scale of rows that hold a quantity: of the order of the other entries of its row.
const HOLD: f64 = 1.0e6;

/// Stands for a place outside the matrix.
const NOWHERE: usize = usize::MAX;

/// Node `i` of a cell from its directions.
#[inline(always)]
fn node<T: Real>(i: usize, f: impl Fn(usize) -> T) -> Node<T> {
    Node {
        a: Vector2::new(f(4 * i), f(4 * i + 2)),
        b: Vector2::new(f(4 * i + 1), f(4 * i + 3)),
    }
}

impl System for VariatorSystem {
    fn shape(&self) -> Shape {
        self.layout.shape()
    }

    fn has_position(&self) -> &[bool] {
        &self.has_position
    }

    fn residual(&mut self, view: View<'_>, out: &mut [f64]) {
        out.fill(0.0);
        self.sums = [PulleySum::default(); 2];
        if self.layout.flexible {
            self.assemble_residual::<true>(view, out);
        } else {
            self.assemble_residual::<false>(view, out);
        }
        let cells = self.mesh.cells.len();
        for cell in 0..cells {
            let before = (cell + cells - 1) % cells;
            let flux = chain::flux(self.flows[cell].0, self.flows[before].1, self.flows[cell].1);
            let (into, from) = (self.layout.amount(cell), self.layout.amount(before));
            out[into] += view.y_dot[into] - flux;
            out[from] += flux;
        }
        self.global_residual(view, out);
        for (condition, nodes, signs) in self.gauge().into_iter().flatten() {
            for (node, sign) in nodes.into_iter().zip(signs) {
                out[condition] += HOLD * sign * view.y[node];
                out[node] += HOLD * sign * view.y[condition];
            }
        }
    }

    fn jacobian(&mut self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        out.clear();
        if self.layout.flexible {
            self.assemble_jacobian::<true>(view, alpha, beta, out);
        } else {
            self.assemble_jacobian::<false>(view, alpha, beta, out);
        }
        self.global_jacobian(view, alpha, beta, out);
        for (condition, nodes, signs) in self.gauge().into_iter().flatten() {
            for (node, sign) in nodes.into_iter().zip(signs) {
                out.add(condition, node, HOLD * sign);
                out.add(node, condition, HOLD * sign);
            }
        }
    }

    fn newton_scale(&self, beta: f64, out: &mut [f64]) {
        let layout = &self.layout;
        // What does not matter: 1 nm of ring position (1 N of tension, 5 N/m of contact), 1e-7 of chain strain (1 N),
        // 1e-3 of the friction velocity.
        let velocity = (1.0e-9 / beta).min(1.0e-3);
        let slip = 2.0e-3 * self.law.parameters.friction.velocity;
        if layout.flexible {
            for node in 0..layout.elements {
                for k in 0..4 {
                    out[layout.node(node, k)] = if k % 2 == 0 { velocity } else { velocity * 1.0e3 };
                }
            }
            for k in 0..2 {
                out[layout.global(Global::Gauge, k)] = 1.0 / HOLD;
            }
        }
        for cell in 0..layout.cells() {
            out[layout.speed(cell)] = slip;
            out[layout.amount(cell)] = 1.0e-9;
            if !layout.flexible {
                out[layout.tension(cell)] = 0.1;
            }
        }
        out[layout.global(Global::Drift, 0)] = slip;
        out[layout.global(Global::Theta, 0)] = velocity * 10.0;
        for j in [S, P] {
            out[layout.global(Global::Sheave, j)] = velocity;
            out[layout.global(Global::Tilt, 2 * j)] = 1.0e-8;
            out[layout.global(Global::Tilt, 2 * j + 1)] = 1.0e-8;
            out[layout.global(Global::Speed, j)] = slip / 0.06;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::start::{Start, kinematic_state};
    use super::*;

    /// The Jacobian against central differences, at a state that slides, sticks, pushes and gaps.
    fn check_jacobian(model: RingModel, speed: f64) {
        let mut parameters = Parameters::default();
        parameters.ring_model = model;
        parameters.mesh = crate::variator::parameters::Mesh {
            primary_arc: 4,
            secondary_arc: 4,
            strand: 3,
            cells_per_element: 2,
        };
        let mut system = VariatorSystem::new(&parameters);
        system.boundary = Boundary {
            sheave: [SheaveMode::Force(1.0e4), SheaveMode::Force(1.3e4)],
            speed: [SpeedMode::Torque(-40.0), SpeedMode::Torque(50.0)],
        };
        let start = Start {
            ratio: 1.2,
            primary_speed: speed,
            clamping: [1.0e4, 1.3e4],
        };
        let mut state = kinematic_state(&system, &start).unwrap();
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let n = state.y.len();
        let mut size = vec![0.0; n];
        system.newton_scale(1.0e-4, &mut size);
        let (alpha, beta) = (1.0e4, 1.0e-4);
        for (i, &size) in size.iter().enumerate() {
            state.y[i] += 200.0 * size * random();
            state.y_dot[i] = 2000.0 * size * random();
            if system.has_position[i] {
                state.q[i] += 2000.0 * size * beta * random();
            }
        }
        let mut matrix = Arrow::new(system.shape());
        let mut residual = vec![0.0; n];
        system.residual(state.view(), &mut residual);
        system.jacobian(state.view(), alpha, beta, &mut matrix);
        let mut unit = vec![0.0; n];
        let mut column = vec![0.0; n];
        for j in 0..n {
            unit[j] = 1.0;
            matrix.multiply(&unit, &mut column);
            unit[j] = 0.0;
            let h = size[j] * 0.4;
            let mut shifted = |h: f64| {
                let mut s = state.clone();
                s.y[j] += h;
                s.y_dot[j] += alpha * h;
                s.q[j] += beta * h;
                let mut r = vec![0.0; n];
                system.residual(s.view(), &mut r);
                r
            };
            let (plus, minus, plus2, minus2) = (shifted(h), shifted(-h), shifted(2.0 * h), shifted(-2.0 * h));
            let scale = column.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for i in 0..n {
                let difference = (8.0 * (plus[i] - minus[i]) - plus2[i] + minus2[i]) / (12.0 * h);
                let noise = 1e-15 * (plus[i].abs() + 1e3) / h;
                assert!(
                    (difference - column[i]).abs() < 2e-4 * column[i].abs() + 2e-7 * scale + 20.0 * noise,
                    "row {i} column {j}: {} against {difference} (scale {scale}, speed {speed})",
                    column[i]
                );
            }
        }
    }

    #[test]
    fn jacobian_of_ale_matches_differences() {
        check_jacobian(RingModel::Ale, 200.0);
        check_jacobian(RingModel::Ale, -200.0);
    }

    #[test]
    fn jacobian_of_ale0_matches_differences() {
        check_jacobian(RingModel::Ale0, 200.0);
        check_jacobian(RingModel::Ale0, 0.0);
    }
}
