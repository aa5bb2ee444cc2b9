//! Analytic derivatives of [`balance`](crate::variator::cell::balance::balance) with the own
//! unknowns of a cell and those of its pulley.
//!
//! A node moves only the ring, a sheave only the flanks, and nearly all relations between them are
//! linear: each station has the coefficients of its variation, and nonlinear laws (flanks, stack)
//! are differentiated forward in their few arguments. This takes less than half the time of forward
//! differentiation, with which a test of `variator` compares it. The drift and the coordinates of
//! the curve change every quantity; for them the whole law is differentiated forward.

use crate::ring::kinematics::{LineLoad, RingPoint, RingVariation, WithRate};
use crate::scalar::{Lanes, Tangent, along};
use crate::solver::Factors;
use crate::stack::{Components, PointVariation, StackPoint, StackVariation, Transport};
use crate::variator::cell::laws::{Arguments, FORCES, Forces, OfLaws, Tangents, stack_arguments};
use crate::variator::cell::state::{CellPoints, CellState, StationForces, stack_at_face};
use crate::variator::cell::station_variation::{
    CellVariation, FlankVariation, LinearisedStation, StationVariation,
};
use crate::variator::law::arguments::{CellBalance, CellInput, between, face_weight};
use crate::variator::law::element_rotation::throughput;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::{Degrees, RingForces, StationLoad, VaryingRing};
use num_traits::Zero;

/// A pack of cells and the coefficients of the variations of its balance.
#[derive(Debug)]
pub(crate) struct Linearised<'a, R, const D: usize> {
    given: CellInput<'a, Lanes>,
    ring: &'a R,
    cell: CellState<Lanes>,
    face: &'a RingPoint<Lanes, D>,
    stack_at_face: StackPoint<Lanes>,
    stations: [Option<LinearisedStation<'a, D>>; STATIONS],
    push: Lanes,
    /// Derivatives of the throughput of elements with respect to density and flow.
    throughput_by_density: Lanes,
    throughput_by_flow: Lanes,
    /// Tangents of the push force.
    d_push: &'a Arguments<Lanes>,
    factors: Factors,
}

/// An unknown that a cell has alone, or of its pulley.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// An unknown of the ring: of a node, or (`ALE0`) the tension at a face.
    Ring(usize),
    /// The speed V at a face.
    Speed(usize),
    /// The content N of the cell.
    Content,
    /// ż (0), ψ_x, ψ_y or ω (3) of the pulley.
    Pulley(usize),
}

impl Direction {
    /// That of degree of freedom `k`, which is neither the drift nor one of the curve.
    #[inline(always)]
    pub fn from_index(degrees: &Degrees, k: usize) -> Self {
        match k {
            _ if k >= degrees.sheave => Self::Pulley(k - degrees.sheave),
            _ if k > degrees.content => Self::Ring(k - degrees.content - 1),
            _ if k == degrees.content => Self::Content,
            _ if k >= degrees.nodes => Self::Speed(k - degrees.nodes),
            _ => Self::Ring(k),
        }
    }
}

type CellForces<const D: usize> = [Option<StationForces<Lanes, D>>; STATIONS];

/// Variations at the stations, kilobytes that are written in place.
type VariedStations<const D: usize> = [Option<PointVariation<Lanes, D>>; STATIONS];

impl<'a, R: VaryingRing<Lanes, D>, const D: usize> Linearised<'a, R, D> {
    /// Linearises evaluated cells with this `ring`, ring and stack at their `points`, `forces` at
    /// the stations and `tangents` of the laws.
    #[inline(always)]
    pub fn new(
        ring: &'a R,
        given: CellInput<'a, Lanes>,
        cell: CellState<Lanes>,
        points: &'a CellPoints<Lanes, D>,
        forces: &'a CellForces<D>,
        tangents: &'a OfLaws<Tangents>,
        factors: Factors,
    ) -> Self {
        let face = points.face();
        let mut stations = [None; STATIONS];
        for (i, (to, at)) in stations.iter_mut().zip(points.stations.iter().zip(forces)).enumerate() {
            if let (Some(station), Some(forces)) = at {
                let tangents = &tangents[i * D..][..D];
                *to = Some(LinearisedStation::new(
                    &given, &cell, i, station, forces, tangents, factors,
                ));
            }
        }
        let seed = Tangent::<2>::seed;
        let [throughput_by_density, throughput_by_flow] =
            throughput(seed(cell.density, 0, 1.0), seed(cell.flow, 1, 1.0)).eps;
        Self {
            face,
            stack_at_face: stack_at_face(&given, face),
            push: cell.push(given.law).force,
            throughput_by_density,
            throughput_by_flow,
            d_push: &tangents[given.geometry.stations.len() * D][0],
            given,
            ring,
            cell,
            stations,
            factors,
        }
    }

    /// Variation of balance and ring forces with an unknown that moves the ring (`MOVES`), or
    /// elements or pulley alone. Writes that of the laws' `arguments`.
    #[inline(always)]
    pub fn vary<const MOVES: bool>(
        &self,
        direction: Direction,
        arguments: &mut OfLaws<Arguments<Lanes>>,
    ) -> (CellBalance<Lanes>, RingForces<Lanes, D>) {
        let Factors { alpha, beta } = self.factors;
        let own = match direction {
            Direction::Ring(own) => Some(own),
            _ => None,
        };
        let mut varied = [None; STATIONS];
        let varied_cell = self.vary_cell::<MOVES>(direction, &mut varied);
        arguments[self.given.geometry.stations.len() * D] = stack_arguments(varied_cell.density);
        let mut out = CellBalance {
            speed: [varied_cell.push, -varied_cell.push],
            transport: Transport {
                flow: varied_cell.flow_in,
                density: varied_cell.density.value,
            },
            ..CellBalance::default()
        };
        let mut sum = self.ring.empty();
        for (i, (station, varied)) in self.stations.iter().zip(&varied).enumerate() {
            let (Some(station), Some(by)) = (station, varied) else {
                continue;
            };
            let mut load = LineLoad::zero();
            let tension = self.ring.vary_own_load(i + 1, station.ring, &by.ring, own, &mut load);
            let inertia =
                station.vary_inertia(self.given.law, alpha, by, &self.cell, self.push, &varied_cell);
            let flank = match direction {
                Direction::Pulley(number) => station.by_pulley[number],
                _ => station.vary_kinematics::<MOVES>(&self.given, by),
            };
            let laws = &mut arguments[i * D..][..D];
            let drag = station.vary_arguments::<MOVES>(&self.given, by, &flank, tension, laws);
            let change = StationVariation {
                by,
                flank: &flank,
                tension,
                inertia,
                drag,
                forces: station.vary_forces(laws),
            };
            laws[D - 1][0] = self.add_loads::<MOVES>(i, station, &change, load, &mut out, &mut sum);
        }
        (out, self.ring.varied_forces(&sum, own, beta))
    }

    /// Variation at the face (0) or at a station (1 and up), where V varies by `speed`.
    #[inline(always)]
    fn vary_point<const MOVES: bool>(
        &self,
        at: usize,
        ring: &RingPoint<Lanes, D>,
        stack: &StackPoint<Lanes>,
        direction: Direction,
        speed: Lanes,
    ) -> PointVariation<Lanes, D> {
        let (true, Direction::Ring(own)) = (MOVES, direction) else {
            return PointVariation {
                ring: RingVariation::none(),
                stack: StackVariation::from_speed(stack, speed),
            };
        };
        let by = self.ring.vary(at, ring, own, self.factors);
        let speed = if self.given.law.is_pull_chain() {
            by.t.dot(&ring.r_dot) + ring.t.dot(&by.r_dot) + ring.w * by.stretch
        } else {
            speed
        };
        PointVariation {
            ring: by,
            stack: stack.vary(ring, &by, speed),
        }
    }

    /// Variations of the stack; fills those at the `stations`.
    #[inline(always)]
    fn vary_cell<const MOVES: bool>(
        &self,
        direction: Direction,
        stations: &mut VariedStations<D>,
    ) -> CellVariation {
        let zero = Lanes::zero();
        let (mut speed, mut content) = ([zero; 2], zero);
        match direction {
            _ if self.given.law.is_pull_chain() => {}
            Direction::Speed(face) => speed[face] = Lanes::from(1.0),
            Direction::Content => content = Lanes::from(1.0),
            _ => {}
        }
        let (mut pitch_length, mut by_normal_motion, mut through, mut steepness) = (zero, zero, zero, zero);
        for (i, (varied, station)) in stations.iter_mut().zip(&self.stations).enumerate() {
            let Some(station) = station else { continue };
            let (stack, weight) = (station.stack, station.weight);
            let speed = between(&speed, station.right);
            let by = self.vary_point::<MOVES>(i + 1, station.ring, stack, direction, speed);
            let d_stack = &by.stack;
            pitch_length += weight * by.ring.stretch;
            if MOVES {
                for k in 0..D - 1 {
                    by_normal_motion += weight
                        * (d_stack.curvature[k] * stack.normal_speed[k]
                            + stack.curvature[k] * d_stack.normal_speed[k]);
                }
            }
            through += weight * d_stack.flow;
            steepness += weight * by.ring.strain_gradient;
            *varied = Some(by);
        }
        if MOVES {
            for by in stations.iter_mut().flatten() {
                by.ring.strain_gradient = steepness * self.cell.inverse_length;
            }
        }
        let face = self.vary_point::<MOVES>(0, self.face, &self.stack_at_face, direction, speed[0]);

        let cell = &self.cell;
        let (difference, inverse) = (speed[1] - speed[0], cell.inverse_pitch_length);
        let value = (content - cell.density * pitch_length) * inverse;
        let rate = (cell.density * cell.lengthening * inverse * pitch_length
            - value * cell.lengthening
            - cell.density * (difference - by_normal_motion))
            * inverse;
        let density = WithRate { value, rate };
        CellVariation {
            flow_in: face.stack.flow,
            density,
            push: along(self.d_push, &stack_arguments(density)),
            speed_gradient: difference * cell.inverse_length,
            throughput: self.throughput_by_density * value
                + self.throughput_by_flow * (through * cell.inverse_length),
        }
    }

    /// Calls `record` with the variation of balance and ring forces for a unit variation of each
    /// force of the laws, and the number of the force. Ring friction follows its load by these
    /// tangents, so later ones are exact to first order.
    #[inline(always)]
    pub fn for_each_force(&self, mut record: impl FnMut(usize, CellBalance<Lanes>, RingForces<Lanes, D>)) {
        let [zero, one] = [0.0, 1.0].map(Lanes::from);
        for (i, station) in self.stations.iter().flatten().enumerate() {
            for law in 0..D {
                for force in 0..if law < D - 1 { FORCES } else { 1 } {
                    let mut unit = [[zero; FORCES]; 3];
                    unit[law][force] = one;
                    let (mut out, mut sum) = (CellBalance::default(), self.ring.empty());
                    self.add_unit(i, station, unit, [zero; 2], &mut out, &mut sum);
                    let ring = self.ring.varied_forces(&sum, None, self.factors.beta);
                    record((i * D + law) * FORCES + force, out, ring);
                }
            }
        }
        let (mut out, mut sum) = (CellBalance::default(), self.ring.empty());
        out.speed = [one, -one];
        for (i, station) in self.stations.iter().flatten().enumerate() {
            let forces = [[zero; FORCES]; 3];
            self.add_unit(i, station, forces, station.stack.curvature, &mut out, &mut sum);
        }
        let ring = self.ring.varied_forces(&sum, None, self.factors.beta);
        record(self.given.geometry.stations.len() * D * FORCES, out, ring);
    }

    /// Adds the loads at station `i` of `forces` of its laws and of `inward` forces, where nothing
    /// moves.
    #[inline(always)]
    fn add_unit(
        &self,
        i: usize,
        station: &LinearisedStation<'_, D>,
        forces: [Forces; 3],
        inward: [Lanes; 2],
        out: &mut CellBalance<Lanes>,
        sum: &mut R::Sum,
    ) {
        let zero = Lanes::zero();
        let change = StationVariation {
            by: &PointVariation {
                ring: RingVariation::none(),
                stack: StackVariation::default(),
            },
            flank: &FlankVariation::default(),
            tension: zero,
            inertia: Components {
                along: zero,
                across: inward,
            },
            drag: zero,
            forces,
        };
        self.add_loads::<false>(i, station, &change, LineLoad::zero(), out, sum);
    }

    /// Adds the variation of the loads at station `i`, with that of the ring's own `load`. Returns
    /// that of the load of ring friction, N/m.
    #[inline(always)]
    fn add_loads<const MOVES: bool>(
        &self,
        i: usize,
        station: &LinearisedStation<'_, D>,
        change: &StationVariation<'_, D>,
        mut load: LineLoad<Lanes, D>,
        out: &mut CellBalance<Lanes>,
        sum: &mut R::Sum,
    ) -> Lanes {
        let (ring, weight) = (station.ring, station.weight);
        let by = &change.by.ring;
        let ring_along = load.position.dot(&ring.t);
        let [along, d_friction, d_load] =
            station.add_flank_forces::<MOVES>(&self.given, change, &mut load, out);
        let d_along_ring = d_friction + change.drag;
        let across = load.position.dot(&ring.normals[0]);
        load.position += ring.t * d_along_ring;
        let mut dragged = d_along_ring * ring.stretch;
        if MOVES {
            let along_ring = station.forces.ring_friction + station.forces.layer_drag;
            load.position += by.t * along_ring;
            dragged += along_ring * by.stretch;
        }
        load.drift += dragged;
        let mut ring_along = ring_along + dragged;
        if self.given.law.is_pull_chain() {
            load.position += ring.t * along;
            let mut drift = along * ring.stretch;
            if MOVES {
                let base = station.forces.along(ring, station.stack);
                load.position += by.t * base;
                drift += base * by.stretch;
            }
            load.drift += drift;
            ring_along += drift;
        } else {
            let pressure = station.vary_energy(&self.given, change.flank) * self.cell.inverse_length;
            for (face, pressure) in [pressure, -pressure].into_iter().enumerate() {
                out.speed[face] += (along * face_weight::<Lanes>(face, station.right) + pressure) * weight;
            }
        }
        let station_load = StationLoad {
            load,
            tension: change.tension,
            across,
            along: ring_along,
            weight,
        };
        self.ring
            .apply_varied(sum, i + 1, ring, by, &station.forces.own_load, &station_load);
        d_load
    }
}
