//! Packs of cells, one in each lane of a register: their places on the belt and the indices of
//! their unknowns.

use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::{Jet, TwoPulleyFrame};
use crate::ring::kinematics::Hermite;
use crate::ring::mesh::{Element, parts};
use crate::scalar::{LANES, Lanes, Real};
use crate::solver::View;
use crate::solver::arrow::{Arrow, Shape};
use crate::variator::belt::Belt;
use crate::variator::belt::equations::ResultantDerivatives;
use crate::variator::law::arguments::{CellGeometry, CellLaw, Extent, SheavePlane};
use crate::variator::mesh::belt_mesh::{Group, Station};
use crate::variator::rings::{Degrees, MOST, MOST_ROWS};
use num_traits::Zero;
use std::array::from_fn;
use std::sync::Arc;

/// Unknowns of a pack for each [`StateComponent`](crate::variator::law::arguments::StateComponent),
/// by their directions.
pub(crate) type Unknowns = [[Lanes; MOST]; 3];

/// Face and stations of the cells of a pack. Elements are divided alike, so most packs share these
/// and they stay in the fastest cache.
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
    /// Places of the elements.
    pub extent: Extent<Lanes>,
    points: Arc<PackStations>,
    axis: Lanes,
    plane: SheavePlane<Lanes>,
    /// Unknowns of the directions.
    pub at: [[usize; LANES]; MOST],
    strips: Vec<Strip>,
}

impl Pack {
    /// Geometry of its cells.
    #[inline(always)]
    pub fn geometry<T: Real<Constant = Lanes>>(
        &self,
        law: &CellLaw,
        frame: &TwoPulleyFrame<T>,
    ) -> CellGeometry<'_, T> {
        let drags = law.arc_drags(frame.radius.map(|radius| radius.v), frame.wraps());
        let on = &self.group.on;
        let mean = |drag: PerPulley<T>| drag.secondary * on.secondary + drag.primary * on.primary;
        CellGeometry {
            extent: self.extent,
            face: &self.points.face,
            stations: &self.points.stations,
            axis: self.axis,
            plane: self.plane,
            length: Jet::constant(0.0).plus_scaled(frame.segment_length(self.segment), self.extent.length),
            layer_drag: mean(drags.layers),
            rotation_drag: mean(drags.rotation),
        }
    }

    /// Adds `rows` of the balance in the own directions of each cell to `out`, without the content.
    #[inline(always)]
    pub fn scatter<const D: usize>(&self, degrees: &Degrees, rows: &[Lanes; MOST_ROWS], out: &mut [f64]) {
        let whole = 2 * D - 2 * D % LANES;
        for first in (0..degrees.nodes).step_by(2 * D) {
            for start in (0..whole).step_by(LANES) {
                let of_cells = Lanes::transposed(from_fn(|k| rows[first + start + k]));
                for (&at, of_cell) in self.at[first][..self.group.used].iter().zip(of_cells) {
                    let node = &mut out[at + start..][..LANES];
                    (Lanes::read(node) + of_cell).write(node);
                }
            }
        }
        let alone = |k: &usize| *k != degrees.content && (*k >= degrees.nodes || k % (2 * D) >= whole);
        for k in (0..degrees.drift).filter(alone) {
            for (&at, value) in self.at[k][..self.group.used].iter().zip(rows[k].to_array()) {
                out[at] += value;
            }
        }
    }

    /// Adds derivatives to the matrix from rows of `width` directions each, as far as a row has a
    /// strip.
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
                let rows: [&[Lanes]; LANES] = from_fn(row);
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

    /// Adds the derivatives of the resultants of the contact forces in all directions, and of the
    /// shared rows in the shared directions, from s on: they are first summed over the lanes of
    /// each pulley.
    #[inline(always)]
    pub fn add_shared(
        &self,
        degrees: &Degrees,
        block: &[Lanes],
        belt: &Belt,
        matrix: &mut Arrow,
        resultants: &mut ResultantDerivatives,
    ) {
        let rows = block.chunks_exact(degrees.count).enumerate().skip(degrees.drift);
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
            for (row, of_row) in rows.clone() {
                for (k, &derivative) in of_row.iter().enumerate().skip(degrees.drift) {
                    let (column, sum) = (self.at[k][lane], (derivative * on).sum());
                    match row.checked_sub(degrees.count) {
                        None => matrix.add(self.at[row][lane], column, sum),
                        Some(axis) => resultants.of(pulley, axis)[column] += sum,
                    }
                }
            }
        }
        for (row, of_row) in rows.skip(degrees.count - degrees.drift) {
            for (lane, &cell) in self.cells().iter().enumerate() {
                let resultants = resultants.of(belt.mesh.cells[cell].pulley, row - degrees.count);
                for (at, derivative) in self.at.iter().zip(&of_row[..degrees.drift]) {
                    resultants[at[lane]] += derivative.lane(lane);
                }
            }
        }
    }

    /// Copies the unknowns of the pack.
    #[inline(always)]
    pub fn gather(&self, degrees: &Degrees, view: View<'_>, to: &mut Unknowns) {
        for (from, to) in [view.q, view.y, view.y_dot].into_iter().zip(to) {
            let (of_nodes, others) = to.split_at_mut(degrees.nodes);
            for (node, to) in of_nodes.chunks_exact_mut((degrees.nodes / 2).max(1)).enumerate() {
                self.gather_node(from, node * to.len(), to);
            }
            for (at, to) in self.at[degrees.nodes..degrees.count].iter().zip(others) {
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
                n: from_fn(|k| each(&|s| s.shape.n[k])),
                dn: from_fn(|k| each(&|s| s.shape.dn[k])),
                ddn: from_fn(|k| each(&|s| s.shape.ddn[k])),
            },
            weight: each(&|s| s.weight),
            right: each(&|s| s.right),
        }
    }
}

/// Places of ∂(flux)/∂(directions of a cell) in the rows of the contents of the previous cell and
/// of the cell, then the same for the directions of the previous cell; `None` outside the matrix.
pub(crate) type FluxEntries = [[[Option<usize>; 2]; MOST]; 2];

pub(crate) fn packs(belt: &Belt, degrees: &Degrees) -> Vec<Pack> {
    let mesh = &belt.mesh;
    let shape = belt.layout.shape;
    let whole = Element {
        segment: 0,
        start: 0.0,
        length: 1.0,
    };
    let element = parts(&whole, mesh.cells_per_element, mesh.points);
    let mut known: Vec<Arc<PackStations>> = Vec::new();
    let mut points_of = |cells: [usize; LANES]| {
        let parts = cells.map(|c| c % mesh.cells_per_element);
        if let Some(points) = known.iter().find(|points| points.parts == parts) {
            return points.clone();
        }
        let of_parts = parts.map(|part| &element[part]);
        let points = Arc::new(PackStations {
            parts,
            face: Station::pack(of_parts.map(|(face, _)| face)),
            stations: (0..mesh.points)
                .map(|i| Station::pack(of_parts.map(|(_, stations)| &stations[i])))
                .collect(),
        });
        known.push(points.clone());
        points
    };
    let pack = |group: &Group| {
        let member = group.cells.map(|c| &mesh.cells[c]);
        let at = group.cells.map(|cell| unknowns_of(belt, degrees, cell));
        let lanes = |of: &dyn Fn(usize) -> f64| Lanes::new(member.map(|c| of(c.element)));
        let of_pulley = |of: &dyn Fn(Pulley) -> f64| Lanes::new(member.map(|c| of(c.pulley)));
        Pack {
            group: group.clone(),
            segment: mesh.elements[member[0].element].segment,
            extent: Extent {
                start: lanes(&|element| mesh.elements[element].start),
                length: lanes(&|element| mesh.elements[element].length),
            },
            points: points_of(group.cells),
            axis: of_pulley(&|pulley| belt.law.axes[pulley]),
            plane: SheavePlane {
                side: of_pulley(&|pulley| belt.law.planes[pulley].side),
                middle: of_pulley(&|pulley| belt.law.planes[pulley].middle),
            },
            at: from_fn(|k| at.map(|at| at[k])),
            strips: strips(degrees, &shape, &at),
        }
    };
    mesh.groups.iter().map(pack).collect()
}

/// Places of the derivatives of a pack in the matrix, without those of [`Pack::add_shared`].
fn strips(degrees: &Degrees, shape: &Shape, at: &[[usize; MOST]; LANES]) -> Vec<Strip> {
    let places = |row: usize| -> Vec<[usize; LANES]> {
        let columns = if row < degrees.drift {
            degrees.count
        } else {
            degrees.drift
        };
        let entries = |column: usize| {
            at.map(|at| shape.index(at[row], at[column]).expect("neighbours are in the band"))
        };
        (0..columns).map(entries).collect()
    };
    let follow = |first: &[[usize; LANES]], then: &[[usize; LANES]], by: usize| {
        let mut pairs = first.as_flattened().iter().zip(then.as_flattened());
        first.len() == then.len() && pairs.all(|(first, then)| first + by == *then)
    };
    let rows: Vec<_> = (0..degrees.count).map(places).collect();
    let mut strips = Vec::new();
    let mut row = 0;
    while let Some(at) = rows.get(row) {
        // The content has no strip, so a wide one doesn't begin with it.
        let is_wide = row != degrees.content
            && (1..LANES).all(|k| rows.get(row + k).is_some_and(|then| follow(at, then, k)));
        if row != degrees.content {
            let at = at.clone();
            strips.push(Strip { row, is_wide, at });
        }
        row += if is_wide { LANES } else { 1 };
    }
    strips
}

pub(crate) fn flux_entries(belt: &Belt, degrees: &Degrees) -> Vec<FluxEntries> {
    let shape = belt.layout.shape;
    let cells = belt.mesh.cells.len();
    (0..cells)
        .map(|cell| {
            let before = (cell + cells - 1) % cells;
            let rows = [before, cell].map(|cell| belt.cells_at[cell].content);
            [cell, before].map(|of| {
                let at = unknowns_of(belt, degrees, of);
                // With one cell per element, the derivative of its density with respect to the far
                // node (ring stretch, reverse flow only) would be outside the band.
                let entry =
                    |row: usize, k: usize| (k < degrees.count).then(|| shape.index(row, at[k])).flatten();
                from_fn(|k| rows.map(|row| entry(row, k)))
            })
        })
        .collect()
}

/// Unknowns of a cell's directions: its own, then s, the coordinates of the curve, z, ψ_x, ψ_y, ω.
fn unknowns_of(belt: &Belt, degrees: &Degrees, cell: usize) -> [usize; MOST] {
    let layout = &belt.layout;
    let place = &belt.mesh.cells[cell];
    let mut at = [0; MOST];
    let (of_nodes, others) = at.split_at_mut(degrees.nodes);
    let size = degrees.nodes / 2;
    for (k, at) in of_nodes.iter_mut().enumerate() {
        *at = layout.node(place.element + k / size, k % size);
    }
    let own = [
        layout.belt_speed(cell),
        layout.belt_speed(cell + 1),
        layout.content(cell),
    ];
    let tensions = (0..degrees.tensions).map(|face| layout.tension(cell + face));
    let curve = [layout.drift(), layout.theta()].into_iter().chain(layout.centres());
    let of_pulley = [
        layout.sheave(place.pulley),
        layout.tilt(place.pulley, 0),
        layout.tilt(place.pulley, 1),
        layout.shaft_speed(place.pulley),
    ];
    let order = own.into_iter().chain(tensions).chain(curve).chain(of_pulley);
    others.iter_mut().zip(order).for_each(|(at, of)| *at = of);
    at
}
