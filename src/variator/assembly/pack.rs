//! Packs of cells, one in each lane of a register: their places on the belt and the indices of their unknowns.

use crate::pulley::Pulley;
use crate::reference_curve::{Jet, MeshCurve};
use crate::ring::kinematics::Hermite;
use crate::ring::mesh::{Element, parts};
use crate::scalar::{LANES, Lanes, Real};
use crate::solver::View;
use crate::solver::arrow::{Arrow, Shape};
use crate::variator::assembly::unknowns::Unknowns;
use crate::variator::belt::Belt;
use crate::variator::belt::sums::ResultantSlopes;
use crate::variator::cell::directions::{Directions, MOST, MOST_ROWS};
use crate::variator::law::place::{CellLaw, Place};
use crate::variator::mesh::belt_mesh::{Group, Station};
use num_traits::Zero;
use std::sync::Arc;

/// Face and stations of the cells of a pack. Elements are divided alike, so most packs share these and they stay in the
/// fastest cache.
#[derive(Debug)]
pub(crate) struct PackStations {
    /// Number of each cell in its element.
    parts: [usize; LANES],
    face: Station<Lanes>,
    stations: Vec<Station<Lanes>>,
}

/// Consecutive rows of a pack's derivatives in the matrix: as many as lanes, or one.
#[derive(Clone, Debug)]
struct Strip {
    /// The first row.
    row: usize,
    /// Whether there are as many rows as lanes.
    is_wide: bool,
    /// Indices of its entries, direction by direction.
    at: Vec<[usize; LANES]>,
}

/// A group of cells with the constants of their evaluation.
#[derive(Clone, Debug)]
pub(crate) struct Pack {
    pub group: Group,
    pub segment: usize,
    /// Start and length of the elements as fractions of the segment.
    pub of_segment: [Lanes; 2],
    slots: Arc<PackStations>,
    axis: Lanes,
    plane: [Lanes; 2],
    /// Unknowns of the directions.
    pub at: [[usize; LANES]; MOST],
    /// Places of the derivatives in the matrix, without the row of the content.
    strips: Vec<Strip>,
}

impl Pack {
    /// Place of its cells on the belt.
    #[inline(always)]
    pub fn place<T: Real<Constant = Lanes>, C: MeshCurve>(&self, law: &CellLaw, frame: &C::Frame<T>) -> Place<'_, T> {
        let arcs = C::arcs(frame);
        let [of_secondary, of_primary] = law.arc_drags(arcs.radius.map(|radius| radius.v), arcs.wraps());
        let on = &self.group.on;
        Place {
            of_segment: self.of_segment,
            face: &self.slots.face,
            stations: &self.slots.stations,
            axis: self.axis,
            plane: self.plane,
            length: Jet::constant(0.0).plus_scaled(C::segment_length(frame, self.segment), self.of_segment[1]),
            layer_drag: of_secondary.layers * on.secondary + of_primary.layers * on.primary,
            spin: of_secondary.spin * on.secondary + of_primary.spin * on.primary,
        }
    }

    /// Adds `rows` of the balance in the own directions of each cell to `out`, without the content.
    #[inline(always)]
    pub fn scatter<K: Directions, const D: usize>(&self, rows: &[Lanes; MOST_ROWS], out: &mut [f64]) {
        let whole = 2 * D - 2 * D % LANES;
        for first in (0..K::NODES).step_by(2 * D) {
            for start in (0..whole).step_by(LANES) {
                let of_cells = Lanes::transposed(std::array::from_fn(|k| rows[first + start + k]));
                for (&at, of_cell) in self.at[first][..self.group.used].iter().zip(of_cells) {
                    let node = &mut out[at + start..][..LANES];
                    (Lanes::read(node) + of_cell).write(node);
                }
            }
        }
        let alone = |k: &usize| *k != K::CONTENT && (*k >= K::NODES || k % (2 * D) >= whole);
        for k in (0..K::DRIFT).filter(alone) {
            for (&at, value) in self.at[k][..self.group.used].iter().zip(rows[k].to_array()) {
                out[at] += value;
            }
        }
    }

    /// Adds derivatives to the matrix from rows of `width` directions each, as far as a row has a strip.
    #[inline(always)]
    pub fn add_derivatives(&self, block: &[Lanes], width: usize, out: &mut Arrow) {
        // The number of lanes is known to the compiler where all are in use.
        if self.group.used == LANES {
            self.add_lanes(block, width, LANES, out);
        } else {
            self.add_lanes(block, width, self.group.used, out);
        }
    }

    #[inline(always)]
    fn add_lanes(&self, block: &[Lanes], width: usize, used: usize, out: &mut Arrow) {
        for Strip { row, is_wide, at } in &self.strips {
            let row = |k: usize| &block[(row + k) * width..][..at.len()];
            if *is_wide {
                let rows: [&[Lanes]; LANES] = std::array::from_fn(row);
                for (k, at) in at.iter().enumerate() {
                    let of_cells = Lanes::transposed(rows.map(|row| row[k]));
                    for (&at, of_cell) in at.iter().zip(of_cells).take(used) {
                        out.add_run(at, of_cell.to_array());
                    }
                }
            } else {
                for (at, value) in at.iter().zip(row(0)) {
                    for (&at, value) in at.iter().zip(value.to_array()).take(used) {
                        out.add_at(at, value);
                    }
                }
            }
        }
    }

    /// Adds the derivatives of the resultants of the contact forces in all directions, and of the shared rows in the shared
    /// directions, from s on: they are first summed over the lanes of each pulley.
    #[inline(always)]
    pub fn add_shared<K: Directions>(
        &self,
        block: &[Lanes],
        belt: &Belt,
        (out, resultants): (&mut Arrow, &mut ResultantSlopes),
    ) {
        // The block has no row of the content.
        let rows = block.chunks_exact(K::COUNT).skip(K::DRIFT - 1);
        for pulley in Pulley::BOTH {
            let on = self.group.on[pulley];
            if on == Lanes::zero() {
                continue;
            }
            let lane = self
                .cells()
                .iter()
                .position(|&cell| belt.mesh.cells[cell].pulley == pulley)
                .unwrap_or_default();
            for (row, slopes) in (K::DRIFT..).zip(rows.clone()) {
                for (k, slope) in slopes.iter().enumerate().skip(K::DRIFT) {
                    let (column, slope) = (self.at[k][lane], (*slope * on).sum());
                    match row.checked_sub(K::COUNT) {
                        None => out.add(self.at[row][lane], column, slope),
                        Some(axis) => resultants.of(pulley, axis)[column] += slope,
                    }
                }
            }
        }
        for (axis, slopes) in rows.skip(K::COUNT - K::DRIFT).enumerate() {
            for (lane, &cell) in self.cells().iter().enumerate() {
                let resultants = resultants.of(belt.mesh.cells[cell].pulley, axis);
                for (at, slope) in self.at.iter().zip(&slopes[..K::DRIFT]) {
                    resultants[at[lane]] += slope.lane(lane);
                }
            }
        }
    }

    /// Copies the unknowns of the pack.
    #[inline(always)]
    pub fn gather<K: Directions>(&self, view: View<'_>, to: &mut Unknowns<Lanes>) {
        for (from, to) in [view.q, view.y, view.y_dot].into_iter().zip(&mut to.0) {
            let (of_nodes, others) = to.split_at_mut(K::NODES);
            for (node, to) in of_nodes.chunks_exact_mut((K::NODES / 2).max(1)).enumerate() {
                self.gather_node(from, node * to.len(), to);
            }
            for (at, to) in self.at[K::NODES..K::COUNT].iter().zip(others) {
                *to = Lanes::new(at.map(|i| from[i]));
            }
        }
    }

    /// Copies the unknowns of a node from direction `first` on, which are contiguous.
    #[inline(always)]
    fn gather_node(&self, from: &[f64], first: usize, to: &mut [Lanes]) {
        let nodes = self.at[first].map(|i| &from[i..][..to.len()]);
        let whole = to.len() - to.len() % LANES;
        let (runs, rest) = to.split_at_mut(whole);
        for (run, to) in runs.chunks_exact_mut(LANES).enumerate() {
            to.copy_from_slice(&Lanes::transposed(nodes.map(|node| Lanes::read(&node[LANES * run..]))));
        }
        for (k, to) in rest.iter_mut().enumerate() {
            *to = Lanes::new(nodes.map(|node| node[whole + k]));
        }
    }

    /// Cells of the lanes in use.
    pub fn cells(&self) -> &[usize] {
        &self.group.cells[..self.group.used]
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

/// Index of a place outside the matrix.
pub(crate) const NOWHERE: usize = usize::MAX;

/// Places of ∂(flux)/∂(directions of a cell) in the rows of the contents of the previous cell and of the cell, then the same
/// for the directions of the previous cell.
pub(crate) type FluxEntries = [[[usize; 2]; MOST]; 2];

/// The packs of a belt, around the loop.
pub(crate) fn packs<K: Directions>(belt: &Belt) -> Vec<Pack> {
    let mesh = &belt.mesh;
    let shape = belt.layout.shape();
    let whole = Element {
        segment: 0,
        start: 0.0,
        share: 1.0,
    };
    let element = parts(&whole, mesh.cells_per_element, mesh.points);
    let mut known: Vec<Arc<PackStations>> = Vec::new();
    let mut slots_of = |cells: [usize; LANES]| {
        let parts = cells.map(|c| c % mesh.cells_per_element);
        if let Some(slots) = known.iter().find(|slots| slots.parts == parts) {
            return slots.clone();
        }
        let of_parts = parts.map(|part| &element[part]);
        let slots = Arc::new(PackStations {
            parts,
            face: Station::pack(of_parts.map(|(face, _)| face)),
            stations: (0..mesh.points)
                .map(|i| Station::pack(of_parts.map(|(_, stations)| &stations[i])))
                .collect(),
        });
        known.push(slots.clone());
        slots
    };
    let pack = |group: &Group| {
        let member = group.cells.map(|c| &mesh.cells[c]);
        let at = group.cells.map(|cell| unknowns_of::<K>(belt, cell));
        let lanes = |of: &dyn Fn(usize) -> f64| Lanes::new(member.map(|c| of(c.element)));
        let of_pulley = |of: &dyn Fn(Pulley) -> f64| Lanes::new(member.map(|c| of(c.pulley)));
        Pack {
            group: group.clone(),
            segment: mesh.elements[member[0].element].segment,
            of_segment: [
                lanes(&|element| mesh.elements[element].start),
                lanes(&|element| mesh.elements[element].share),
            ],
            slots: slots_of(group.cells),
            axis: of_pulley(&|pulley| belt.law.axes[pulley]),
            plane: [
                of_pulley(&|pulley| belt.law.planes[pulley].side),
                of_pulley(&|pulley| belt.law.planes[pulley].middle),
            ],
            at: std::array::from_fn(|k| at.map(|at| at[k])),
            strips: strips::<K>(&shape, &at),
        }
    };
    mesh.groups.iter().map(pack).collect()
}

/// Places of the derivatives of a pack in the matrix, without those of [`Pack::add_shared`].
fn strips<K: Directions>(shape: &Shape, at: &[[usize; MOST]; LANES]) -> Vec<Strip> {
    let places = |row: usize| -> Vec<[usize; LANES]> {
        // The block has no row of the content.
        let of_row = row + usize::from(row >= K::CONTENT);
        let columns = if of_row < K::DRIFT { K::COUNT } else { K::DRIFT };
        let place =
            |column: usize| at.map(|at| shape.index(at[of_row], at[column]).expect("neighbours are in the band"));
        (0..columns).map(place).collect()
    };
    let follow = |first: &[[usize; LANES]], then: &[[usize; LANES]], by: usize| {
        let mut pairs = first.as_flattened().iter().zip(then.as_flattened());
        first.len() == then.len() && pairs.all(|(first, then)| first + by == *then)
    };
    let rows: Vec<_> = (0..K::COUNT - 1).map(places).collect();
    let mut strips = Vec::new();
    let mut row = 0;
    while let Some(at) = rows.get(row) {
        let is_wide = (1..LANES).all(|k| rows.get(row + k).is_some_and(|then| follow(at, then, k)));
        strips.push(Strip {
            row,
            is_wide,
            at: at.clone(),
        });
        row += if is_wide { LANES } else { 1 };
    }
    strips
}

/// Places of the derivatives of the fluxes, for each cell.
pub(crate) fn flux_entries<K: Directions>(belt: &Belt) -> Vec<FluxEntries> {
    let shape = belt.layout.shape();
    let cells = belt.mesh.cells.len();
    (0..cells)
        .map(|cell| {
            let before = (cell + cells - 1) % cells;
            let rows = [before, cell].map(|cell| belt.cells_at[cell].content);
            [cell, before].map(|of| {
                let at = unknowns_of::<K>(belt, of);
                std::array::from_fn(|k| {
                    // With one cell per element, the derivative of its density with respect to the far node (ring
                    // stretch, reverse flow only) would be outside the band.
                    rows.map(|row| {
                        if k < K::COUNT {
                            shape.index(row, at[k]).unwrap_or(NOWHERE)
                        } else {
                            NOWHERE
                        }
                    })
                })
            })
        })
        .collect()
}

/// Unknowns of a cell's directions: its own, then s, the coordinates of the curve, z, ψ_x, ψ_y, ω.
fn unknowns_of<K: Directions>(belt: &Belt, cell: usize) -> [usize; MOST] {
    let layout = &belt.layout;
    let place = &belt.mesh.cells[cell];
    let mut at = [0; MOST];
    let size = K::NODES / 2;
    for (k, at) in at[..K::NODES].iter_mut().enumerate() {
        *at = layout.node(place.element + k / size, k % size);
    }
    let of_cell = &mut at[K::NODES..];
    of_cell[0] = layout.belt_speed(cell);
    of_cell[1] = layout.belt_speed(cell + 1);
    of_cell[2] = layout.content(cell);
    for face in 0..K::TENSIONS {
        of_cell[3 + face] = layout.tension(cell + face);
    }
    at[K::DRIFT] = layout.drift();
    at[K::THETA] = layout.theta();
    for centre in 1..K::COORDINATES {
        at[K::THETA + centre] = layout.centre(centre - 1);
    }
    let of_pulley = [
        layout.sheave(place.pulley),
        layout.tilt(place.pulley, 0),
        layout.tilt(place.pulley, 1),
        layout.shaft_speed(place.pulley),
    ];
    at[K::SHEAVE..K::COUNT].copy_from_slice(&of_pulley);
    at
}
