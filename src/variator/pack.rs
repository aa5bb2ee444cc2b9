//! Cells in packs, one in each lane of a register: which unknowns a cell has, where they stand, and what motion they
//! are.

use super::cell::{CellBalance, CellMotion, Place};
use super::kept::Kept;
use super::layout::Global;
use super::mesh::{Group, Station};
use super::ring::{GUIDED, RingForces};
use super::system::VariatorSystem;
use super::variation::Direction;
use crate::reference_curve::{Jet, ReferenceCurve, TwoPulley, TwoPulleyFrame, Unaligned};
use crate::ring::kinematics::{Hermite, Motion, Node};
use crate::ring::mesh::{Element, parts};
use crate::scalar::{LANES, Lanes, Real};
use crate::solver::View;
use nalgebra::SVector;
use num_traits::Zero;
use std::sync::Arc;

/// Most derivative directions of a cell: 12 node motions in space, V, V, N, and six globals.
pub(super) const MOST: usize = 21;

/// Directions of a cell that are motions of its nodes: the first ones. V, V, N follow, and in `ALE0` T, T.
pub(super) const fn node_directions(kind: u8, components: usize) -> usize {
    if kind == GUIDED { 0 } else { 4 * components }
}

/// The direction that is the element amount, whose row the fluxes fill.
pub(super) const fn amount_direction(kind: u8, components: usize) -> usize {
    node_directions(kind, components) + 2
}

/// Directions of a cell before the globals.
pub(super) const fn own_directions(kind: u8, components: usize) -> usize {
    node_directions(kind, components) + if kind == GUIDED { 5 } else { 3 }
}

/// All directions of a cell.
pub(super) const fn directions(kind: u8, components: usize) -> usize {
    own_directions(kind, components) + 6
}

/// What varies in a direction of a cell; nothing that [`super::variation`] knows for Θ.
pub(super) fn direction(kind: u8, components: usize, k: usize) -> Option<Direction> {
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

/// Face and stations in elements of which each is divided alike: most packs share them, so they stay in the fastest
/// cache.
#[derive(Debug)]
pub(super) struct Slots {
    /// Which part of its element each cell is.
    parts: [usize; LANES],
    face: Station<Lanes>,
    stations: Vec<Station<Lanes>>,
}

/// A group of cells, with what their evaluation needs.
#[derive(Clone, Debug)]
pub(super) struct Pack {
    pub group: Group,
    pub segment: usize,
    /// Start and length of the elements as fractions of the segment.
    pub of_segment: [Lanes; 2],
    pub slots: Arc<Slots>,
    pub axis: Lanes,
    pub plane: [Lanes; 2],
    /// Unknowns of the directions.
    pub at: [[usize; LANES]; MOST],
    /// Places of the derivatives in the matrix: row by row, the amount's left out, a direction after the other.
    pub entries: Vec<[usize; LANES]>,
}

impl Pack {
    /// Where its cells lie.
    #[inline(always)]
    pub fn place<T: Real<Constant = Lanes>, C: Standing>(&self, frame: &C::Frame<T>) -> Place<'_, T> {
        Place {
            of_segment: self.of_segment,
            face: &self.slots.face,
            stations: &self.slots.stations,
            axis: self.axis,
            plane: self.plane,
            length: Jet::constant(0.0).plus_scaled(C::segment_length(frame, self.segment), self.of_segment[1]),
        }
    }

    /// Adds `rows` of the balance of each cell, its own directions', to `out`; the amount has its own balance.
    #[inline(always)]
    pub fn scatter<const KIND: u8, const D: usize>(&self, rows: &[Lanes; MOST], out: &mut [f64]) {
        let (nodes, own) = (node_directions(KIND, D), own_directions(KIND, D));
        let rows = rows.map(Lanes::to_array);
        for lane in 0..self.group.used {
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

/// Positions, values and rates of the unknowns of a cell, or of one in each lane.
#[derive(Clone, Debug)]
pub(super) struct Unknowns<L> {
    pub position: [L; MOST],
    pub value: [L; MOST],
    pub rate: [L; MOST],
}

/// What is told of an unknown.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    Position,
    Value,
    Rate,
}

/// Tells the unknowns of a cell, or of one in each lane, by their directions.
pub(super) trait Tell<L> {
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
pub(super) struct InPlace<'a> {
    pub pack: &'a Pack,
    pub view: View<'a>,
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
    pub fn gather(&self, count: usize) -> Unknowns<Lanes> {
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
pub(super) const NOWHERE: usize = usize::MAX;

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
        Self::frame_of(curve, frame)
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
        for group in &self.mesh.groups {
            let cell = group.cells;
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
                group: group.clone(),
                segment: self.mesh.elements[member[0].element].segment,
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
}

/// Motion of the nodes (`ALE`).
#[inline(always)]
pub(super) fn nodes<T: Real, const D: usize>(
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
pub(super) fn tensions<T: Real>(
    unknowns: &impl Tell<T::Constant>,
    seed: impl Fn(T::Constant, usize, f64) -> T,
) -> [T; 2] {
    [3, 4].map(|k| seed(unknowns.tell(Part::Value, k), k, 1.0))
}

/// Motion of a cell; `seed` makes a scalar of a value, its direction and its slope.
#[inline(always)]
pub(super) fn motion<T: Real, const KIND: u8, const D: usize>(
    unknowns: &impl Tell<T::Constant>,
    [alpha, beta]: [f64; 2],
    seed: impl Fn(T::Constant, usize, f64) -> T,
) -> CellMotion<T> {
    let value = |k: usize| seed(unknowns.tell(Part::Value, k), k, 1.0);
    let rate = |k: usize| seed(unknowns.tell(Part::Rate, k), k, alpha);
    let position = |k: usize| seed(unknowns.tell(Part::Position, k), k, beta);
    CellMotion::of_directions(
        [node_directions(KIND, D), own_directions(KIND, D)],
        position,
        value,
        rate,
    )
}

/// Rows of the balance in the order of the directions; the amount has its own balance, the flux.
#[inline(always)]
pub(super) fn rows<T: Real, const KIND: u8, const D: usize>(b: &CellBalance<T>, ring: &RingForces<T, D>) -> [T; MOST] {
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
