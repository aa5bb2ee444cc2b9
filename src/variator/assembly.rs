//! Cells gathered into the residual and, with the exact Jacobian, into the matrix: several at once, one in each lane.

use super::cell::{CellBalance, CellMotion, NoProbe, Place, Probe, PulleyMotion, Sample, Sampler, balance};
use super::kept::{Kept, Look, Regime};
use super::layout::Global;
use super::mesh::Station;
use super::ring::{Deflecting, GUIDED, Guided, RingForces, TURNING, Turning, VaryingRing};
use super::system::VariatorSystem;
use super::travelling::with_ring;
use super::variation::{Direction, Linearised};
use crate::chain::{self, Transport};
use crate::reference_curve::{
    Jet, ReferenceCurve, ReferencePoint, TwoPulley, TwoPulleyFrame, TwoPulleyShape, Unaligned,
};
use crate::ring::kinematics::{Hermite, Motion, Node, ReferenceMotion};
use crate::ring::mesh::{Element, parts};
use crate::scalar::{LANES, Lanes, Real, Tangent};
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::tape::Tape;
use nalgebra::SVector;
use num_traits::Zero;
use std::sync::Arc;

/// Most derivative directions of a cell: 12 node motions in space, V, V, N, and six globals.
pub(super) const MOST: usize = 21;

/// Directions of a cell that are motions of its nodes: the first ones. V, V, N follow, and in `ALE0` T, T.
const fn node_directions(kind: u8, components: usize) -> usize {
    if kind == GUIDED { 0 } else { 4 * components }
}

/// The direction that is the element amount, whose row the fluxes fill.
const fn amount_direction(kind: u8, components: usize) -> usize {
    node_directions(kind, components) + 2
}

/// Directions of a cell before the globals.
const fn own_directions(kind: u8, components: usize) -> usize {
    node_directions(kind, components) + if kind == GUIDED { 5 } else { 3 }
}

/// All directions of a cell.
const fn directions(kind: u8, components: usize) -> usize {
    own_directions(kind, components) + 6
}

/// What varies in a direction of a cell; nothing that [`super::variation`] knows for Θ.
fn direction(kind: u8, components: usize, k: usize) -> Option<Direction> {
    let (nodes, own) = (node_directions(kind, components), own_directions(kind, components));
    if k < nodes {
        return Some(Direction::Ring(k));
    }
    if k < own {
        return Some(match k - nodes {
            face @ (0 | 1) => Direction::Speed(face),
            2 => Direction::Amount,
            tension => Direction::Ring(tension - 3),
        });
    }
    match k - own {
        0 => Some(Direction::Drift),
        1 => None,
        2 => Some(Direction::Sheave),
        axis @ (3 | 4) => Some(Direction::Tilt(axis - 3)),
        _ => Some(Direction::Shaft),
    }
}

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;

/// Face and stations in elements of which each is divided alike: most packs share them, so they stay in the fastest cache.
#[derive(Debug)]
struct Slots {
    /// Which part of its element each cell is.
    parts: [usize; LANES],
    face: Station<Lanes>,
    stations: Vec<Station<Lanes>>,
}

/// Cells that are computed at once, one in each lane. They lie on the same segment, next to each other.
#[derive(Clone, Debug)]
pub(super) struct Pack {
    /// Cells; the last one repeats where there are fewer than lanes.
    cells: [usize; LANES],
    /// Lanes in use.
    used: usize,
    segment: usize,
    /// Start and length of the elements as fractions of the segment.
    of_segment: [Lanes; 2],
    slots: Arc<Slots>,
    axis: Lanes,
    plane: [Lanes; 2],
    /// Unknowns of the directions.
    at: [[usize; LANES]; MOST],
    /// Places of the derivatives in the matrix: row by row, the amount's left out, a direction after the other.
    entries: Vec<[usize; LANES]>,
}

impl Pack {
    /// Where its cells lie.
    #[inline(always)]
    fn place<T: Real<Constant = Lanes>, C: Standing>(&self, frame: &C::Frame<T>) -> Place<'_, T> {
        Place {
            of_segment: self.of_segment,
            face: &self.slots.face,
            stations: &self.slots.stations,
            axis: self.axis,
            plane: self.plane,
            length: Jet::constant(0.0).plus_scaled(C::segment_length(frame, self.segment), self.of_segment[1]),
        }
    }

    /// The sum over its cells.
    #[inline(always)]
    fn counted(&self, of: Lanes) -> f64 {
        of.to_array()[..self.used].iter().sum()
    }

    /// Adds `rows` of the balance of each cell, its own directions', to `out`; the amount has its own balance.
    #[inline(always)]
    fn scatter<const KIND: u8, const D: usize>(&self, rows: &[Lanes; MOST], out: &mut [f64]) {
        let (nodes, own) = (node_directions(KIND, D), own_directions(KIND, D));
        let rows = rows.map(Lanes::to_array);
        for lane in 0..self.used {
            for first in (0..nodes).step_by(2 * D) {
                let node = &mut out[self.at[first][lane]..][..2 * D];
                for (k, x) in node.iter_mut().enumerate() {
                    *x += rows[first + k][lane];
                }
            }
            for k in (nodes..own).filter(|k| *k != amount_direction(KIND, D)) {
                out[self.at[k][lane]] += rows[k][lane];
            }
        }
    }
}

/// Sums over the cells of a pulley.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PulleySum {
    pub axial: f64,
    pub tilting: [f64; 2],
    pub torque: f64,
}

/// Positions, values and rates of the unknowns of a cell, or of one in each lane.
#[derive(Clone, Debug)]
pub(super) struct Unknowns<L> {
    pub position: [L; MOST],
    pub value: [L; MOST],
    pub rate: [L; MOST],
}

/// What is told of an unknown.
#[derive(Clone, Copy, Debug)]
enum Part {
    Position,
    Value,
    Rate,
}

/// Tells the unknowns of a cell, or of one in each lane, by their directions.
trait Tell<L> {
    /// The unknown of direction `k`.
    fn tell(&self, part: Part, k: usize) -> L;

    /// Those of a node in D components, whose first direction is `first`.
    #[inline(always)]
    fn tell_node<const D: usize>(&self, part: Part, first: usize) -> impl Fn(usize) -> L {
        move |k| self.tell(part, first + k)
    }
}

impl<L: Copy> Tell<L> for Unknowns<L> {
    #[inline(always)]
    fn tell(&self, part: Part, k: usize) -> L {
        match part {
            Part::Position => self.position[k],
            Part::Value => self.value[k],
            Part::Rate => self.rate[k],
        }
    }
}

/// The unknowns of a pack where they stand.
struct InPlace<'a> {
    pack: &'a Pack,
    view: View<'a>,
}

impl InPlace<'_> {
    #[inline(always)]
    fn part(&self, part: Part) -> &[f64] {
        match part {
            Part::Position => self.view.q,
            Part::Value => self.view.y,
            Part::Rate => self.view.y_dot,
        }
    }

    /// All of them, in `count` directions.
    #[inline(always)]
    fn gather(&self, count: usize) -> Unknowns<Lanes> {
        let all = |part: Part| {
            let mut to = [Lanes::zero(); MOST];
            for (k, x) in to[..count].iter_mut().enumerate() {
                *x = self.tell(part, k);
            }
            to
        };
        Unknowns {
            position: all(Part::Position),
            value: all(Part::Value),
            rate: all(Part::Rate),
        }
    }
}

impl Tell<Lanes> for InPlace<'_> {
    #[inline(always)]
    fn tell(&self, part: Part, k: usize) -> Lanes {
        let from = self.part(part);
        Lanes::new(self.pack.at[k].map(|i| from[i]))
    }

    /// They follow each other.
    #[inline(always)]
    fn tell_node<const D: usize>(&self, part: Part, first: usize) -> impl Fn(usize) -> Lanes {
        let from = self.part(part);
        let nodes = self.pack.at[first].map(|i| &from[i..][..2 * D]);
        move |k| Lanes::new(nodes.map(|of| of[k]))
    }
}

impl Station<Lanes> {
    pub(super) fn pack(stations: [&Station; LANES]) -> Self {
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

/// Stands for a place outside the matrix.
const NOWHERE: usize = usize::MAX;

/// The reference curve as a mesh stands on it.
pub(super) trait Standing: ReferenceCurve {
    /// What a frame of the curve is to the mesh.
    fn stand<T: Real>(curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> Self::Frame<T>;
}

/// Element borders follow the arc borders.
impl Standing for TwoPulley {
    #[inline(always)]
    fn stand<T: Real>(_curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> TwoPulleyFrame<T> {
        frame
    }
}

/// Elements stand still.
impl Standing for Unaligned<TwoPulley> {
    fn stand<T: Real>(curve: &TwoPulley, frame: TwoPulleyFrame<T>) -> Self::Frame<T> {
        Self::seen(curve, frame)
    }
}

/// Calls a method for the ring and the mesh of a system: what nodes do, in how many components, on which curve.
macro_rules! for_kind {
    ($system:expr, $method:ident($($argument:expr),*)) => {{
        use $crate::reference_curve::{TwoPulley, Unaligned};
        use $crate::variator::ring::{FIXED, GUIDED, TURNING};
        let system = $system;
        match (system.mesh.aligned, system.ring_kind(), system.layout.components) {
            (true, GUIDED, _) => system.$method::<GUIDED, 2, TwoPulley>($($argument),*),
            (true, FIXED, 3) => system.$method::<FIXED, 3, TwoPulley>($($argument),*),
            (true, FIXED, _) => system.$method::<FIXED, 2, TwoPulley>($($argument),*),
            (true, _, 3) => system.$method::<TURNING, 3, TwoPulley>($($argument),*),
            (true, ..) => system.$method::<TURNING, 2, TwoPulley>($($argument),*),
            (false, GUIDED, _) => system.$method::<GUIDED, 2, Unaligned<TwoPulley>>($($argument),*),
            (false, _, 3) => system.$method::<FIXED, 3, Unaligned<TwoPulley>>($($argument),*),
            (false, ..) => system.$method::<FIXED, 2, Unaligned<TwoPulley>>($($argument),*),
        }
    }};
}
pub(super) use for_kind;

impl VariatorSystem {
    /// Packs neighbours, and finds the places of their derivatives.
    pub(super) fn pack(&mut self) {
        if self.travelling.is_some() {
            return;
        }
        let shape = self.layout.shape();
        let cells = self.mesh.cells.len();
        let segment = |cell: usize| self.mesh.elements[self.mesh.cells[cell].element].segment;
        let directions = |cell: usize| {
            let mut at = [0; MOST];
            let count = self.directions(cell, &mut at);
            (at, count)
        };
        let amount = amount_direction(self.ring_kind(), self.layout.components);
        let whole = Element {
            segment: 0,
            start: 0.0,
            share: 1.0,
        };
        let element = parts(&whole, self.mesh.cells_per_element, self.mesh.points);
        let mut known: Vec<Arc<Slots>> = Vec::new();
        let mut packs = Vec::new();
        let mut first = 0;
        while first < cells {
            let used = (1..LANES)
                .take_while(|&i| first + i < cells && segment(first + i) == segment(first))
                .count()
                + 1;
            let cell: [usize; LANES] = std::array::from_fn(|lane| first + lane.min(used - 1));
            let member = cell.map(|c| &self.mesh.cells[c]);
            let parts = cell.map(|c| c % self.mesh.cells_per_element);
            let slots = known.iter().find(|slots| slots.parts == parts).cloned();
            let slots = slots.unwrap_or_else(|| {
                let cells = parts.map(|part| &element[part]);
                known.push(Arc::new(Slots {
                    parts,
                    face: Station::pack(cells.map(|(face, _)| face)),
                    stations: (0..self.mesh.points)
                        .map(|i| Station::pack(cells.map(|(_, stations)| &stations[i])))
                        .collect(),
                }));
                known[known.len() - 1].clone()
            });
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
                of_segment: [
                    Lanes::new(member.map(|c| self.mesh.elements[c.element].start)),
                    Lanes::new(member.map(|c| self.mesh.elements[c.element].share)),
                ],
                slots,
                axis: Lanes::new(member.map(|c| self.law.axes[c.pulley])),
                plane: [
                    Lanes::new(member.map(|c| self.law.planes[c.pulley].side)),
                    Lanes::new(member.map(|c| self.law.planes[c.pulley].middle)),
                ],
                at: std::array::from_fn(|k| at.map(|(at, _)| at[k])),
                entries,
            });
            first += used;
        }
        self.flux_entries = (0..cells)
            .map(|cell| {
                let before = (cell + cells - 1) % cells;
                let rows = [before, cell].map(|cell| self.cells_at[cell][1]);
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
        self.kept = packs.iter().map(|pack| Kept::new(pack.entries.len())).collect();
        self.packs = packs;
    }

    /// Passes by a tape where the derivatives that are kept were taken: for packs of as many cells only.
    pub(super) fn pass_kept(&mut self, tape: &mut Tape<'_>) {
        let mut lanes = LANES as u64;
        tape.counter(&mut lanes);
        if lanes != LANES as u64 {
            tape.reject();
        }
        let count = directions(self.ring_kind(), self.layout.components);
        for (pack, kept) in self.packs.iter().zip(&mut self.kept) {
            kept.pass(tape, count, pack.used);
        }
    }

    /// Length of an element, m.
    pub(super) fn element_length(&self, frame: &TwoPulleyFrame<f64>, element: usize) -> f64 {
        let element = &self.mesh.elements[element];
        let segment = if self.mesh.aligned {
            TwoPulley::segment_length(frame, element.segment).v
        } else {
            self.curve.length()
        };
        segment * element.share
    }

    /// The reference curve at a fraction of the segment of an element.
    pub(super) fn reference_point(
        &self,
        frame: &TwoPulleyFrame<f64>,
        element: usize,
        fraction: f64,
    ) -> ReferencePoint<f64> {
        if self.mesh.aligned {
            TwoPulley::point(frame, self.mesh.elements[element].segment, fraction)
        } else {
            self.curve.at(frame, fraction * self.curve.length())
        }
    }

    /// Global indices of a cell's directions: its own unknowns, then s, Θ, z, ψ_x, ψ_y, ω.
    fn directions(&self, cell: usize, out: &mut [usize; MOST]) -> usize {
        let layout = &self.layout;
        let place = &self.mesh.cells[cell];
        let local = own_directions(self.ring_kind(), layout.components);
        if layout.flexible {
            let size = 2 * layout.components;
            for i in 0..2 {
                for k in 0..size {
                    out[size * i + k] = layout.node(place.element + i, k);
                }
            }
            out[2 * size] = layout.speed(cell);
            out[2 * size + 1] = layout.speed(cell + 1);
            out[2 * size + 2] = layout.amount(cell);
        } else {
            out[0] = layout.speed(cell);
            out[1] = layout.speed(cell + 1);
            out[2] = layout.amount(cell);
            out[3] = layout.tension(cell);
            out[4] = layout.tension(cell + 1);
        }
        let j = place.pulley;
        out[local] = layout.global(Global::Drift, 0);
        out[local + 1] = layout.global(Global::Theta, 0);
        out[local + 2] = layout.global(Global::Sheave, j);
        out[local + 3] = layout.global(Global::Tilt, 2 * j);
        out[local + 4] = layout.global(Global::Tilt, 2 * j + 1);
        out[local + 5] = layout.global(Global::Speed, j);
        local + 6
    }

    /// Motion of the nodes (`ALE`).
    #[inline(always)]
    fn nodes<T: Real, const D: usize>(
        unknowns: &impl Tell<T::Constant>,
        [alpha, beta]: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> [Motion<Node<T, D>>; 2] {
        [0, 2 * D].map(|first| {
            let node = |part: Part, slope: f64| {
                let told = unknowns.tell_node::<D>(part, first);
                let seeded = |k: usize| seed(told(k), first + k, slope);
                Node {
                    a: SVector::from_fn(|k, _| seeded(2 * k)),
                    b: SVector::from_fn(|k, _| seeded(2 * k + 1)),
                }
            };
            Motion {
                value: node(Part::Position, beta),
                rate: node(Part::Value, 1.0),
                acceleration: node(Part::Rate, alpha),
            }
        })
    }

    /// Ring tension at the faces (`ALE0`), N.
    #[inline(always)]
    fn tensions<T: Real>(unknowns: &impl Tell<T::Constant>, seed: impl Fn(T::Constant, usize, f64) -> T) -> [T; 2] {
        [3, 4].map(|k| seed(unknowns.tell(Part::Value, k), k, 1.0))
    }

    /// Motion of a cell; `seed` makes a scalar of a value, its direction and its slope.
    #[inline(always)]
    fn motion<T: Real, const KIND: u8, const D: usize>(
        unknowns: &impl Tell<T::Constant>,
        [alpha, beta]: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> CellMotion<T> {
        let value = |k: usize| seed(unknowns.tell(Part::Value, k), k, 1.0);
        let rate = |k: usize| seed(unknowns.tell(Part::Rate, k), k, alpha);
        let position = |k: usize| seed(unknowns.tell(Part::Position, k), k, beta);
        let (own, g) = (node_directions(KIND, D), own_directions(KIND, D));
        CellMotion {
            speed: [value(own), value(own + 1)],
            speed_dot: [rate(own), rate(own + 1)],
            amount: value(own + 2),
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
    fn rows<T: Real, const KIND: u8, const D: usize>(b: &CellBalance<T>, ring: &RingForces<T, D>) -> [T; MOST] {
        let mut rows = [T::zero(); MOST];
        let g = own_directions(KIND, D);
        if KIND != GUIDED {
            for (i, node) in ring.nodes.iter().enumerate() {
                for k in 0..D {
                    rows[2 * (D * i + k)] = node.a[k];
                    rows[2 * (D * i + k) + 1] = node.b[k];
                }
            }
            rows[4 * D] = b.speed[0];
            rows[4 * D + 1] = b.speed[1];
        } else {
            rows[0] = b.speed[0];
            rows[1] = b.speed[1];
            rows[3] = ring.tension;
        }
        rows[g] = ring.drift;
        rows[g + 1] = ring.theta;
        rows[g + 2] = b.axial;
        rows[g + 3] = -b.tilting[0];
        rows[g + 4] = -b.tilting[1];
        rows[g + 5] = -b.torque;
        rows
    }

    /// Samples of all stations, in the order of ξ.
    pub(super) fn sample(&self, view: View<'_>, out: &mut Vec<Sample>) {
        let cells = self.mesh.cells.len();
        out.resize(cells * self.mesh.points, Sample::default());
        if let Some(travelling) = &self.travelling {
            with_ring!(&**travelling, ring => self.sample_travelling(ring, view, out));
        } else {
            for_kind!(self, sample_packs(view, out));
        }
    }

    fn sample_packs<const KIND: u8, const D: usize, C: Standing>(&self, view: View<'_>, out: &mut [Sample]) {
        let points = self.mesh.points;
        let frame = C::stand(&self.curve, self.curve.shape(self.theta(view)).frame(Lanes::zero()));
        for pack in &self.packs {
            let mut station = 0;
            self.sampled_balance::<KIND, D, C>(pack, &frame, &InPlace { pack, view }, &mut |sample| {
                for (&cell, sample) in pack.cells[..pack.used].iter().zip(sample.lanes()) {
                    out[cell * points + station] = sample;
                }
                station += 1;
            });
        }
    }

    /// The balance of a pack of cells while `take` sees every station.
    #[inline(never)]
    fn sampled_balance<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Lanes>,
        unknowns: &impl Tell<Lanes>,
        take: &mut dyn FnMut(Sample<Lanes>),
    ) -> CellBalance<Lanes> {
        let seed = |value, _, _| value;
        self.pack_balance::<_, _, KIND, D, C>(pack, frame, unknowns, [0.0; 2], seed, &mut Sampler(take))
            .0
    }

    /// The balance of a pack of cells; `seed` makes a scalar of a value, its direction and its slope.
    #[inline(always)]
    fn pack_balance<T: Real<Constant = Lanes>, S: Probe<T>, const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<T>,
        unknowns: &impl Tell<Lanes>,
        slopes: [f64; 2],
        seed: impl Fn(Lanes, usize, f64) -> T,
        probe: &mut S,
    ) -> (CellBalance<T>, RingForces<T, D>) {
        let motion = Self::motion::<T, KIND, D>(unknowns, slopes, &seed);
        let place = pack.place::<T, C>(frame);
        let reference = |slot: usize| C::point(frame, pack.segment, place.fraction(slot));
        let (law, ring) = (&self.law, &self.law.parameters.ring);
        if KIND == GUIDED {
            let tensions = Self::tensions(unknowns, &seed);
            let mut ring = Guided::new(ring, &place, &motion.reference, tensions);
            let b = balance(law, &place, &motion, &mut ring, reference, probe);
            return (b, ring.forces());
        }
        let nodes = Self::nodes(unknowns, slopes, &seed);
        if KIND == TURNING {
            let curve = |fraction| C::turning(frame, pack.segment, fraction);
            let [start, share] = pack.of_segment;
            let ends = [start, start + share];
            let mut ring = Turning::new(ring, &place, &motion.reference, nodes, ends, curve);
            let b = balance(law, &place, &motion, &mut ring, reference, probe);
            (b, ring.forces())
        } else {
            let mut ring = Deflecting::new(ring, &place, &motion.reference, &nodes);
            let b = balance(law, &place, &motion, &mut ring, reference, probe);
            (b, ring.forces())
        }
    }

    /// One pass over a pack: derivatives in the directions `first` and on.
    #[inline(never)]
    fn pack_pass<const N: usize, const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Tangent<N>>,
        unknowns: &Unknowns<Lanes>,
        slopes: [f64; 2],
        first: usize,
    ) -> ([Tangent<N>; MOST], Transport<Tangent<N>>) {
        let seed =
            |value: Lanes, direction: usize, slope: f64| Tangent::seed(value, direction.wrapping_sub(first), slope);
        let (b, ring) = self.pack_balance::<_, _, KIND, D, C>(pack, frame, unknowns, slopes, seed, &mut NoProbe);
        (Self::rows::<_, KIND, D>(&b, &ring), b.transport)
    }

    /// Hands `put` the derivatives of a pack in all directions but Θ: rows of the balance, and what the balance of the
    /// amounts needs.
    #[inline(never)]
    fn vary_pack<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Lanes>,
        unknowns: &Unknowns<Lanes>,
        slopes: [f64; 2],
        put: impl FnMut(usize, &[Lanes; MOST], &Transport<Lanes>),
    ) {
        let plain = |value, _, _| value;
        let motion = Self::motion::<Lanes, KIND, D>(unknowns, slopes, plain);
        let place = pack.place::<Lanes, C>(frame);
        let reference = |slot: usize| C::point(frame, pack.segment, place.fraction(slot));
        let (law, ring) = (&self.law, &self.law.parameters.ring);
        if KIND == GUIDED {
            let tensions = Self::tensions::<Lanes>(unknowns, plain);
            let ring = Guided::new(ring, &place, &motion.reference, tensions);
            let linear = Linearised::new(law, &place, &motion, &ring, reference, slopes);
            Self::columns::<_, KIND, 2>(&linear, put);
        } else {
            let nodes = Self::nodes::<Lanes, D>(unknowns, slopes, plain);
            let mut ring = Deflecting::new(ring, &place, &motion.reference, &nodes);
            balance(law, &place, &motion, &mut ring, reference, &mut NoProbe);
            let linear = Linearised::new(law, &place, &motion, &ring, reference, slopes);
            Self::columns::<_, KIND, D>(&linear, put);
        }
    }

    #[inline(always)]
    fn columns<R: VaryingRing<Lanes, D>, const KIND: u8, const D: usize>(
        linear: &Linearised<'_, R, D>,
        mut put: impl FnMut(usize, &[Lanes; MOST], &Transport<Lanes>),
    ) {
        for k in 0..directions(KIND, D) {
            if let Some(direction) = direction(KIND, D, k) {
                let (b, ring) = linear.vary(direction);
                put(k, &Self::rows::<_, KIND, D>(&b, &ring), &b.transport);
            }
        }
    }

    pub(super) fn assemble_residual<const KIND: u8, const D: usize, C: Standing>(
        &mut self,
        view: View<'_>,
        out: &mut [f64],
    ) {
        let own = own_directions(KIND, D);
        let frame = C::stand(&self.curve, self.curve.shape(self.theta(view)).frame(Lanes::zero()));
        let (mut drift, mut theta) = (0.0, 0.0);
        for pack in &self.packs {
            let (b, ring) = self.pack_balance::<_, _, KIND, D, C>(
                pack,
                &frame,
                &InPlace { pack, view },
                [0.0; 2],
                |value, _, _| value,
                &mut NoProbe,
            );
            let rows = Self::rows::<_, KIND, D>(&b, &ring);
            pack.scatter::<KIND, D>(&rows, out);
            drift += pack.counted(rows[own]);
            theta += pack.counted(rows[own + 1]);
            // The pulley's rows need its whole sum first.
            let [axial, torque, x, y] = [b.axial, b.torque, b.tilting[0], b.tilting[1]].map(Lanes::to_array);
            for lane in 0..pack.used {
                let cell = pack.cells[lane];
                let sum = &mut self.sums[self.mesh.cells[cell].pulley];
                sum.axial += axial[lane];
                sum.torque += torque[lane];
                sum.tilting[0] += x[lane];
                sum.tilting[1] += y[lane];
                self.transports[cell] = b.transport.map(|of| of.to_array()[lane]);
            }
        }
        out[self.layout.global(Global::Drift, 0)] += drift;
        out[self.layout.global(Global::Theta, 0)] += theta;
        self.add_fluxes(view, out);
    }

    /// Adds the balance of the amounts: fluxes through the left faces.
    pub(super) fn add_fluxes(&self, view: View<'_>, out: &mut [f64]) {
        let cells = self.mesh.cells.len();
        let before = |cell: usize| if cell == 0 { cells - 1 } else { cell - 1 };
        for first in (0..cells).step_by(LANES) {
            let last = cells.min(first + LANES);
            let pack: [usize; LANES] = std::array::from_fn(|lane| (first + lane).min(last - 1));
            let [left, right] = [pack.map(before), pack].map(|of| self.packed_transport(of));
            for (cell, flux) in (first..last).zip(chain::flux(&left, &right).to_array()) {
                let [into, from] = [cell, before(cell)].map(|cell| self.cells_at[cell][1]);
                out[into] += view.y_dot[into] - flux;
                out[from] += flux;
            }
        }
    }

    /// What the balance of the amounts needs of these cells.
    fn packed_transport(&self, of: [usize; LANES]) -> Transport<Lanes> {
        let of = of.map(|cell| &self.transports[cell]);
        Transport {
            flow: Lanes::new(of.map(|t| t.flow)),
            density: Lanes::new(of.map(|t| t.density)),
            lag: Lanes::new(of.map(|t| t.lag)),
        }
    }

    /// Values of a pack and the regime that it is in.
    fn look<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Lanes>,
        unknowns: &Unknowns<Lanes>,
        alpha: f64,
    ) -> (Regime, Transport<Lanes>) {
        let mut regime = Regime::new();
        let mut look = Look {
            law: &self.law,
            alpha,
            ring_speed: unknowns.value[own_directions(KIND, D)],
            regime: &mut regime,
        };
        let b = self.sampled_balance::<KIND, D, C>(pack, frame, unknowns, &mut |sample| look.take(&sample));
        let own = node_directions(KIND, D);
        let [left, right] = [unknowns.value[own], unknowns.value[own + 1]];
        regime.see_difference(right - left);
        (regime, b.transport)
    }

    /// Differentiates a pack where `kept` says.
    fn differentiate<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frames: &Frames<C>,
        kept: &mut Kept,
        transports: &mut [Transport<[f64; MOST]>],
    ) {
        if KIND == TURNING {
            self.differentiate_forward::<KIND, D, C>(pack, frames, kept, transports);
            return;
        }
        let (count, theta) = (directions(KIND, D), own_directions(KIND, D) + 1);
        let amount = amount_direction(KIND, D);
        let mut put = |direction: usize, rows: &[Lanes; MOST], transport: &Transport<Lanes>| {
            let rows = rows[..count].iter().enumerate().filter(|(k, _)| *k != amount);
            for ((_, row), block) in rows.zip(kept.block.chunks_exact_mut(count)) {
                block[direction] = *row;
            }
            for (figure, slope) in transport.each().into_iter().enumerate() {
                for (&cell, slope) in pack.cells[..pack.used].iter().zip(slope.to_array()) {
                    transports[cell].each_mut()[figure][direction] = slope;
                }
            }
        };
        self.vary_pack::<KIND, D, C>(pack, &frames.plain, &kept.unknowns, kept.slopes, &mut put);
        let (rows, transport) =
            self.pack_pass::<1, KIND, D, C>(pack, &frames.of_theta, &kept.unknowns, kept.slopes, theta);
        put(theta, &rows.map(|row| row.eps[0]), &transport.map(|of| of.eps[0]));
    }

    /// The same by forward differentiation alone.
    fn differentiate_forward<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frames: &Frames<C>,
        kept: &mut Kept,
        transports: &mut [Transport<[f64; MOST]>],
    ) {
        let (count, theta) = (directions(KIND, D), own_directions(KIND, D) + 1);
        let amount = amount_direction(KIND, D);
        for first in (0..count).step_by(PASS) {
            let frame = if first == theta / PASS * PASS {
                &frames.moving
            } else {
                &frames.still
            };
            let pass = first..(first + PASS).min(count);
            let (rows, transport) = self.pack_pass::<PASS, KIND, D, C>(pack, frame, &kept.unknowns, kept.slopes, first);
            let rows = rows[..count].iter().enumerate().filter(|(k, _)| *k != amount);
            for ((_, row), block) in rows.zip(kept.block.chunks_exact_mut(count)) {
                block[pass.clone()].copy_from_slice(&row.eps[..pass.len()]);
            }
            for (figure, of) in transport.each().into_iter().enumerate() {
                for (k, slope) in pass.clone().zip(&of.eps) {
                    for (&cell, slope) in pack.cells[..pack.used].iter().zip(slope.to_array()) {
                        transports[cell].each_mut()[figure][k] = slope;
                    }
                }
            }
        }
    }

    /// Largest difference between derivatives by hand and by forward differentiation, as a share of the largest entry of its
    /// column, and of all figures that the amounts need.
    #[cfg(test)]
    pub(super) fn worst_derivative<const KIND: u8, const D: usize, C: Standing>(
        &self,
        view: View<'_>,
        alpha: f64,
    ) -> f64 {
        let (count, theta) = (directions(KIND, D), own_directions(KIND, D) + 1);
        let frames = Frames::<C>::new(&self.curve, &self.curve.shape(self.theta(view)), theta, 1.0 / alpha);
        let mut worst = 0.0_f64;
        for (pack, kept) in self.packs.iter().zip(&self.kept) {
            let mut kept = [kept.clone(), kept.clone()];
            let mut transports = [self.transport_slopes.clone(), self.transport_slopes.clone()];
            for k in &mut kept {
                (k.unknowns, k.slopes) = (InPlace { pack, view }.gather(count), [alpha, 1.0 / alpha]);
            }
            self.differentiate::<KIND, D, C>(pack, &frames, &mut kept[0], &mut transports[0]);
            self.differentiate_forward::<KIND, D, C>(pack, &frames, &mut kept[1], &mut transports[1]);
            for lane in 0..pack.used {
                let [hand, forward] = kept.each_ref().map(|kept| {
                    let entry = |row: usize, column: usize| kept.block[row * count + column].to_array()[lane];
                    let column = |column| (0..count - 1).map(move |row| entry(row, column)).collect::<Vec<_>>();
                    (0..count).map(column).collect::<Vec<_>>()
                });
                let [of_hand, of_forward] = transports
                    .each_ref()
                    .map(|t| t[pack.cells[lane]].each().map(|of| of[..count].to_vec()));
                let pairs = hand.iter().zip(&forward).chain(of_hand.iter().zip(&of_forward));
                for (hand, forward) in pairs {
                    let scale = forward.iter().fold(1e-300_f64, |most, x| most.max(x.abs()));
                    for (a, b) in hand.iter().zip(forward) {
                        worst = worst.max((a - b).abs() / scale);
                    }
                }
            }
        }
        worst
    }

    /// Takes the derivatives that are kept once more, where they were taken.
    pub(super) fn retake<const KIND: u8, const D: usize, C: Standing>(&mut self) {
        let theta = own_directions(KIND, D) + 1;
        let (mut all, mut transports) = (
            std::mem::take(&mut self.kept),
            std::mem::take(&mut self.transport_slopes),
        );
        for (pack, kept) in self.packs.iter().zip(&mut all) {
            if !kept.slopes[0].is_nan() {
                let shape = self.curve.shape(kept.unknowns.position[theta].re());
                let frames = Frames::<C>::new(&self.curve, &shape, theta, kept.slopes[1]);
                (kept.regime, _) = self.look::<KIND, D, C>(pack, &frames.plain, &kept.unknowns, kept.slopes[0]);
                self.differentiate::<KIND, D, C>(pack, &frames, kept, &mut transports);
            }
        }
        (self.kept, self.transport_slopes) = (all, transports);
    }

    pub(super) fn assemble_jacobian<const KIND: u8, const D: usize, C: Standing>(
        &mut self,
        view: View<'_>,
        alpha: f64,
        beta: f64,
        out: &mut Arrow,
    ) {
        let (count, theta) = (directions(KIND, D), own_directions(KIND, D) + 1);
        let frames = Frames::<C>::new(&self.curve, &self.curve.shape(self.theta(view)), theta, beta);
        let (mut all, mut transports) = (
            std::mem::take(&mut self.kept),
            std::mem::take(&mut self.transport_slopes),
        );
        for (pack, kept) in self.packs.iter().zip(&mut all) {
            let unknowns = InPlace { pack, view }.gather(count);
            let (regime, transport) = self.look::<KIND, D, C>(pack, &frames.plain, &unknowns, alpha);
            let length = C::segment_length(&frames.plain, pack.segment).v * pack.of_segment[1];
            if !kept.holds(
                &regime,
                &unknowns,
                length,
                [if KIND == GUIDED { 0 } else { D }, theta],
                alpha,
            ) {
                self.differentiations += 1;
                (kept.unknowns, kept.regime, kept.slopes) = (unknowns, regime, [alpha, beta]);
                self.differentiate::<KIND, D, C>(pack, &frames, kept, &mut transports);
            }
            for (entry, value) in pack.entries.iter().zip(&kept.block) {
                let value = value.to_array();
                for lane in 0..pack.used {
                    out.add_at(entry[lane], value[lane]);
                }
            }
            for lane in 0..pack.used {
                self.transports[pack.cells[lane]] = transport.map(|of| of.to_array()[lane]);
            }
        }
        (self.kept, self.transport_slopes) = (all, transports);
        for cell in 0..self.mesh.cells.len() {
            let [_, row] = self.cells_at[cell];
            out.add(row, row, alpha);
        }
        // Fluxes through the left faces.
        let cells = self.mesh.cells.len();
        for cell in 0..cells {
            let before = (cell + cells - 1) % cells;
            let [by_before, by_own] = chain::flux_slopes(&self.transports[before], &self.transports[cell]);
            let (of_before, of_own) = (&self.transport_slopes[before], &self.transport_slopes[cell]);
            let [own, other] = &self.flux_entries[cell];
            for k in 0..count {
                let (slope, slope_before) = (by_own.along(of_own, k), by_before.along(of_before, k));
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
}

/// The curve as it stands: without derivatives, in passes whose directions don't move it, and in that of Θ.
struct Frames<C: Standing> {
    plain: C::Frame<Lanes>,
    still: C::Frame<Tangent<PASS>>,
    moving: C::Frame<Tangent<PASS>>,
    of_theta: C::Frame<Tangent<1>>,
}

impl<C: Standing> Frames<C> {
    /// Frames at `shape`; `theta` is the direction of Θ, and `beta` its slope.
    fn new(curve: &TwoPulley, shape: &TwoPulleyShape, theta: usize, beta: f64) -> Self {
        Self {
            plain: C::stand(curve, shape.frame(Lanes::zero())),
            still: C::stand(curve, shape.frame(Tangent::zero())),
            moving: C::stand(curve, shape.frame(Tangent::seed(Lanes::zero(), theta % PASS, beta))),
            of_theta: C::stand(curve, shape.frame(Tangent::seed(Lanes::zero(), 0, beta))),
        }
    }
}
