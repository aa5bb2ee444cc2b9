//! Cells in packs, one in each lane of a register: their places on the belt, and the places of their unknowns.

use crate::pulley::Pulley;
use crate::reference_curve::Jet;
use crate::ring::kinematics::Hermite;
use crate::ring::mesh::{Element, parts};
use crate::scalar::{LANES, Lanes, Real};
use crate::solver::View;
use crate::solver::arrow::{Arrow, Shape};
use crate::variator::assembly::kinds::MeshCurve;
use crate::variator::assembly::sums::ResultantSlopes;
use crate::variator::assembly::unknowns::{Part, ReadUnknowns, Unknowns};
use crate::variator::belt::Belt;
use crate::variator::cell::directions::{Directions, MOST, MOST_ROWS};
use crate::variator::law::place::{CellLaw, Place};
use crate::variator::mesh::belt_mesh::{Group, Station};
use crate::variator::mesh::layout::Layout;
use num_traits::Zero;
use std::sync::Arc;

/// Face and stations in elements of which each is divided alike: most packs share them, so they stay in the fastest
/// cache.
#[derive(Debug)]
pub(crate) struct Slots {
    /// Number of each cell in its element.
    parts: [usize; LANES],
    face: Station<Lanes>,
    stations: Vec<Station<Lanes>>,
}

/// A group of cells, with what their evaluation needs.
#[derive(Clone, Debug)]
pub(crate) struct Pack {
    pub group: Group,
    pub segment: usize,
    /// Start and length of the elements as fractions of the segment.
    pub of_segment: [Lanes; 2],
    slots: Arc<Slots>,
    axis: Lanes,
    plane: [Lanes; 2],
    /// Unknowns of the directions.
    pub at: [[usize; LANES]; MOST],
    /// Places of the derivatives in the matrix: row by row, the amount's left out, a direction after the other.
    pub entries: Vec<[usize; LANES]>,
}

impl Pack {
    /// Place of its cells on the belt.
    #[inline(always)]
    pub fn place<T: Real<Constant = Lanes>, C: MeshCurve>(&self, law: &CellLaw, frame: &C::Frame<T>) -> Place<'_, T> {
        let radii = C::arc_radii(frame).map(|radius| radius - law.chain.pitch_offset);
        let [of_secondary, of_primary] = law.layers.drag_shares(radii);
        Place {
            of_segment: self.of_segment,
            face: &self.slots.face,
            stations: &self.slots.stations,
            axis: self.axis,
            plane: self.plane,
            length: Jet::constant(0.0).plus_scaled(C::segment_length(frame, self.segment), self.of_segment[1]),
            layer_drag: of_secondary * self.group.on.secondary + of_primary * self.group.on.primary,
        }
    }

    /// Adds `rows` of the balance of each cell, its own directions', to `out`; the amount has its own balance.
    #[inline(always)]
    pub fn scatter<K: Directions, const D: usize>(&self, rows: &[Lanes; MOST_ROWS], out: &mut [f64]) {
        let rows = rows.map(Lanes::to_array);
        for lane in 0..self.group.used {
            for first in (0..K::NODES).step_by(2 * D) {
                let node = &mut out[self.at[first][lane]..][..2 * D];
                for (k, x) in node.iter_mut().enumerate() {
                    *x += rows[first + k][lane];
                }
            }
            for k in (K::NODES..K::DRIFT).filter(|k| *k != K::AMOUNT) {
                out[self.at[k][lane]] += rows[k][lane];
            }
        }
    }

    /// Adds derivatives to the matrix, at places from [`Pack::entries`].
    #[inline(always)]
    pub fn add_entries(&self, values: &[Lanes], entries: &[[usize; LANES]], out: &mut Arrow) {
        for (entry, value) in entries.iter().zip(values) {
            let value = value.to_array();
            for lane in 0..self.group.used {
                out.add_at(entry[lane], value[lane]);
            }
        }
    }

    /// Adds derivatives in its first directions to those of a component of the resultants.
    #[inline(always)]
    pub fn add_resultant(&self, values: &[Lanes], axis: usize, belt: &Belt, out: &mut ResultantSlopes) {
        for (at, value) in self.at.iter().zip(values) {
            let value = value.to_array();
            for (lane, &cell) in self.cells().iter().enumerate() {
                out.add(belt.mesh.cells[cell].pulley, axis, at[lane], value[lane]);
            }
        }
    }

    /// Cells of its lanes in use.
    pub fn cells(&self) -> &[usize] {
        &self.group.cells[..self.group.used]
    }
}

/// The unknowns of a pack, read from the vectors of the state.
pub(crate) struct InPlace<'a> {
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

    /// Copies of them all, in `count` directions.
    #[inline(always)]
    pub fn gather(&self, count: usize) -> Unknowns<Lanes> {
        let all = |part: Part| {
            let mut to = [Lanes::zero(); MOST];
            for (k, x) in to[..count].iter_mut().enumerate() {
                *x = self.read(part, k);
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

impl ReadUnknowns<Lanes> for InPlace<'_> {
    #[inline(always)]
    fn read(&self, part: Part, k: usize) -> Lanes {
        let from = self.part(part);
        Lanes::new(self.pack.at[k].map(|i| from[i]))
    }

    /// The unknowns of a node are contiguous.
    #[inline(always)]
    fn read_node<const D: usize>(&self, part: Part, first: usize) -> impl Fn(usize) -> Lanes {
        let from = self.part(part);
        let nodes = self.pack.at[first].map(|i| &from[i..][..2 * D]);
        move |k| Lanes::new(nodes.map(|of| of[k]))
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

/// Places of ∂(flux)/∂(directions of a cell) in the rows of the amounts before and in the cell; then the same for the
/// directions of the cell before.
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
    let mut known: Vec<Arc<Slots>> = Vec::new();
    let mut slots_of = |cells: [usize; LANES]| {
        let parts = cells.map(|c| c % mesh.cells_per_element);
        if let Some(slots) = known.iter().find(|slots| slots.parts == parts) {
            return slots.clone();
        }
        let of_parts = parts.map(|part| &element[part]);
        let slots = Arc::new(Slots {
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
            entries: entries::<K>(&shape, &at),
        }
    };
    mesh.groups.iter().map(pack).collect()
}

/// Places of the derivatives of a pack in the matrix.
fn entries<K: Directions>(shape: &Shape, at: &[[usize; MOST]; LANES]) -> Vec<[usize; LANES]> {
    let mut entries = Vec::new();
    for row in (0..K::COUNT).filter(|&row| row != K::AMOUNT) {
        for column in 0..K::COUNT {
            entries.push(at.map(|at| shape.index(at[row], at[column]).expect("neighbours are in the band")));
        }
    }
    entries
}

/// Places of the derivatives of the fluxes, for each cell.
pub(crate) fn flux_entries<K: Directions>(belt: &Belt) -> Vec<FluxEntries> {
    let shape = belt.layout.shape();
    let cells = belt.mesh.cells.len();
    (0..cells)
        .map(|cell| {
            let before = (cell + cells - 1) % cells;
            let rows = [before, cell].map(|cell| belt.cells_at[cell].amount);
            [cell, before].map(|of| {
                let at = unknowns_of::<K>(belt, of);
                std::array::from_fn(|k| {
                    // With one cell in an element, its density's dependence on the far node (ring stretch, reverse
                    // flow only) would leave the band.
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
    of_cell[2] = layout.amount(cell);
    for face in 0..K::TENSIONS {
        of_cell[3 + face] = layout.tension(cell + face);
    }
    global_unknowns::<K>(layout, place.pulley, &mut at);
    at
}

/// Unknowns of the directions from s on, of a cell on that pulley.
pub(crate) fn global_unknowns<K: Directions>(layout: &Layout, pulley: Pulley, at: &mut [usize; MOST]) {
    at[K::DRIFT] = layout.drift();
    at[K::THETA] = layout.theta();
    for centre in 1..K::COORDINATES {
        at[K::THETA + centre] = layout.centre(centre - 1);
    }
    let of_pulley = [
        layout.sheave(pulley),
        layout.tilt(pulley, 0),
        layout.tilt(pulley, 1),
        layout.shaft_speed(pulley),
    ];
    at[K::SHEAVE..K::COUNT].copy_from_slice(&of_pulley);
}
