//! Analytic derivatives of [`balance`](crate::variator::cell::balance::balance) with the own unknowns of a cell and those of
//! its pulley.
//!
//! Forward differentiation repeats the whole law for each direction, although a node moves only the ring, a sheave only
//! the flanks, and nearly all relations between them are linear. Here the coefficients of the variation are stored for each
//! station. Nonlinear laws (flanks, stack) are differentiated forward in their few arguments. This takes less than half the
//! time and agrees to rounding: a test of `variator` compares the two. The drift and the coordinates of the curve change
//! every quantity, so they use forward differentiation.

use crate::chain::{ChainPoint, ChainVariation, Transport};
use crate::ring::kinematics::{LineLoad, RingPoint, RingVariation};
use crate::scalar::{Lanes, Tangent, along};
use crate::variator::cell::directions::Directions;
use crate::variator::cell::flank_variation::{FLANK_FORCES, FlankVariation};
use crate::variator::cell::laws::{ARGUMENTS, LawArguments, LawTangents};
use crate::variator::cell::state::{CellInput, CellState, Slots, StationForces, chain_at_face};
use crate::variator::cell::station_variation::{LinearisedStation, StackVariation, StationVariation};
use crate::variator::law::flanks::FlankSum;
use crate::variator::law::place::{CellBalance, between, share};
use crate::variator::law::spin::throughput;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::{Action, RingForces, VaryingRing};
use num_traits::Zero;

/// An evaluated pack of cells: its state, ring and chain, forces at the stations, tangents of the laws.
#[derive(Clone, Copy, Debug)]
pub struct Evaluated<'a, const D: usize> {
    pub given: CellInput<'a, Lanes>,
    pub cell: CellState<Lanes>,
    pub slots: &'a Slots<Lanes, D>,
    pub forces: &'a [Option<StationForces<Lanes, D>>; STATIONS],
    pub laws: &'a LawTangents,
    /// Factors of acceleration and position.
    pub slopes: [f64; 2],
}

/// A pack of cells and the coefficients of the variations of its balance.
#[derive(Debug)]
pub(crate) struct Linearised<'a, R, const D: usize> {
    given: CellInput<'a, Lanes>,
    ring: &'a R,
    cell: CellState<Lanes>,
    face: (&'a RingPoint<Lanes, D>, ChainPoint<Lanes, D>),
    stations: [Option<LinearisedStation<'a, D>>; STATIONS],
    push: Lanes,
    /// Derivatives of the throughput of elements with respect to density and flow.
    throughput: [Lanes; 2],
    /// Tangents of the push force.
    d_push: [Lanes; ARGUMENTS],
    /// Factors of acceleration and position.
    slopes: [f64; 2],
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
    /// That of direction `k`, without those of the drift and the curve.
    #[inline(always)]
    pub fn of<K: Directions>(k: usize) -> Self {
        if k < K::NODES {
            return Self::Ring(k);
        }
        if k < K::DRIFT {
            return match k - K::NODES {
                face @ (0 | 1) => Self::Speed(face),
                2 => Self::Content,
                tension => Self::Ring(tension - 3),
            };
        }
        Self::Pulley(k - K::SHEAVE)
    }

    #[inline(always)]
    fn of_ring(self) -> Option<usize> {
        match self {
            Self::Ring(own) => Some(own),
            _ => None,
        }
    }
}

/// Variations of ring and chain at the stations. Their size is kilobytes, so they are written in place.
type VariedStations<const D: usize> = [Option<(RingVariation<Lanes, D>, ChainVariation<Lanes>)>; STATIONS];

/// Variation of a cell's integrals.
#[derive(Clone, Copy, Debug)]
struct CellVariation {
    /// Flow through the left face, m/s.
    flow_in: Lanes,
    /// Length of the pitch line, m.
    pitch_length: Lanes,
    /// ∫κ̂ n̂·ṙ dξ, m/s.
    carried: Lanes,
    /// ∫J dξ, m²/s.
    through: Lanes,
    /// Difference of V across the cell, m/s.
    difference: Lanes,
}

impl<'a, R: VaryingRing<Lanes, D>, const D: usize> Linearised<'a, R, D> {
    /// Linearises `evaluated` cells with this `ring`.
    #[inline(always)]
    pub fn new(ring: &'a R, evaluated: Evaluated<'a, D>) -> Self {
        let Evaluated {
            given,
            cell,
            slots,
            forces,
            laws,
            slopes,
        } = evaluated;
        let push = cell.push(given.law).force;
        let face = slots.face();
        let mut stations = [None; STATIONS];
        for (i, (to, at)) in stations.iter_mut().zip(slots.stations.iter().zip(forces)).enumerate() {
            if let (Some(station), Some(forces)) = at {
                *to = Some(LinearisedStation::new(
                    &given,
                    (i, station),
                    cell.throughput,
                    (forces, &laws.stations[i]),
                    slopes,
                ));
            }
        }
        Self {
            face: (face, chain_at_face(&given, face)),
            given,
            ring,
            cell,
            stations,
            push,
            throughput: throughput(
                Tangent::<2>::seed(cell.density, 0, 1.0),
                Tangent::seed(cell.flow, 1, 1.0),
            )
            .eps,
            d_push: laws.stack,
            slopes,
        }
    }

    /// Variation of balance and ring forces with an unknown. Writes that of the `arguments` of the laws, which must be zero
    /// before.
    #[inline(always)]
    pub fn vary(
        &self,
        direction: Direction,
        arguments: &mut LawArguments<Lanes>,
    ) -> (CellBalance<Lanes>, RingForces<Lanes, D>) {
        match direction {
            Direction::Ring(_) if R::MOVES => self.column::<true>(direction, arguments),
            _ => self.column::<false>(direction, arguments),
        }
    }

    /// Variation with an unknown that moves the ring (`MOVES`), or elements or pulley alone.
    #[inline(always)]
    fn column<const MOVES: bool>(
        &self,
        direction: Direction,
        arguments: &mut LawArguments<Lanes>,
    ) -> (CellBalance<Lanes>, RingForces<Lanes, D>) {
        let [alpha, beta] = self.slopes;
        let mut varied = [None; STATIONS];
        let cell = self.vary_cell::<MOVES>(direction, &mut varied);
        let stack = self.vary_stack(direction, &cell);
        arguments.stack = stack.arguments;
        let mut out = CellBalance {
            speed: [stack.push[1], -stack.push[1]],
            transport: Transport {
                flow: cell.flow_in,
                density: stack.density[1],
            },
            ..CellBalance::default()
        };
        let mut sum = self.ring.empty();
        for (i, (station, varied)) in self.stations.iter().zip(&varied).enumerate() {
            let (Some(station), Some((by, chain))) = (station, varied) else {
                continue;
            };
            let mut load = LineLoad::zero();
            let tension = self
                .ring
                .vary_own_load(i + 1, station.ring, by, direction.of_ring(), &mut load);
            let (along, inward) = station.vary_inertia(self.given.law, alpha, (by, chain), &stack);
            let flank = match direction {
                Direction::Pulley(number) => station.by_pulley[number],
                _ => station.vary_approach::<MOVES>(&self.given, by, chain),
            };
            let change = StationVariation {
                by,
                chain,
                flank: &flank,
                along,
                inward,
                tension,
            };
            let motions = station.vary_motions(&self.given, &flank);
            let flanks = station.vary_flanks(&self.given, &flank, &motions);
            let (along_ring, of_laws) = station.vary_ring_friction::<MOVES>(&change, &motions);
            self.add_loads::<MOVES>((i, station), &change, (load, &flanks, along_ring), &mut out, &mut sum);
            arguments.stations[i] = of_laws;
        }
        (out, self.ring.varied_forces(&sum, direction.of_ring(), beta))
    }

    /// Variation of ring and chain at the face (0) or at a station (1 and up), where V varies by `speed`.
    #[inline(always)]
    fn vary_slot<const MOVES: bool>(
        &self,
        (slot, ring, chain): (usize, &RingPoint<Lanes, D>, &ChainPoint<Lanes, D>),
        direction: Direction,
        speed: Lanes,
    ) -> (RingVariation<Lanes, D>, ChainVariation<Lanes>) {
        let (true, Direction::Ring(own)) = (MOVES, direction) else {
            return (RingVariation::none(), ChainVariation::of_speed(chain, speed));
        };
        let by = self.ring.vary(slot, ring, own, self.slopes);
        let speed = if self.given.law.is_chain() {
            by.t.dot(&ring.r_dot) + ring.t.dot(&by.r_dot) + ring.w * by.stretch
        } else {
            speed
        };
        (by, chain.vary(ring, &by, speed))
    }

    /// Variation of ring and chain.
    #[inline(always)]
    fn vary_cell<const MOVES: bool>(&self, direction: Direction, stations: &mut VariedStations<D>) -> CellVariation {
        let zero = Lanes::zero();
        let mut speed = [zero; 2];
        if let (Direction::Speed(face), false) = (direction, self.given.law.is_chain()) {
            speed[face] = Lanes::from(1.0);
        }
        let (mut pitch_length, mut carried, mut through, mut steepness) = (zero, zero, zero, zero);
        for (i, (varied, station)) in stations.iter_mut().zip(&self.stations).enumerate() {
            let Some(station) = station else { continue };
            let (chain, weight) = (station.chain, station.weight);
            let slot = (i + 1, station.ring, chain);
            let (by, d_chain) = self.vary_slot::<MOVES>(slot, direction, between(&speed, station.right));
            pitch_length += weight * by.stretch;
            if MOVES {
                for k in 0..D - 1 {
                    carried += weight
                        * (d_chain.curvature[k] * chain.normal_speed[k] + chain.curvature[k] * d_chain.normal_speed[k]);
                }
            }
            through += weight * d_chain.flow;
            steepness += weight * by.strain_gradient;
            *varied = Some((by, d_chain));
        }
        if MOVES {
            for (by, _) in stations.iter_mut().flatten() {
                by.strain_gradient = steepness * self.cell.inverse_length;
            }
        }
        let (ring, chain) = &self.face;
        let (_, face) = self.vary_slot::<MOVES>((0, ring, chain), direction, speed[0]);
        CellVariation {
            flow_in: face.flow,
            pitch_length,
            carried,
            through,
            difference: speed[1] - speed[0],
        }
    }

    /// Variation of the stack with the variation `by` of ring and chain.
    #[inline(always)]
    fn vary_stack(&self, direction: Direction, by: &CellVariation) -> StackVariation {
        let content = if direction == Direction::Content && !self.given.law.is_chain() {
            Lanes::from(1.0)
        } else {
            Lanes::zero()
        };
        let lengthening = by.difference - by.carried;
        let inverse = self.cell.inverse_pitch_length;
        let density = (content - self.cell.density * by.pitch_length) * inverse;
        let thinning = (self.cell.density * self.cell.lengthening * inverse * by.pitch_length
            - density * self.cell.lengthening
            - self.cell.density * lengthening)
            * inverse;
        let arguments = [density, thinning];
        StackVariation {
            arguments,
            density: [self.cell.density, density],
            push: [self.push, along(&self.d_push, &arguments)],
            gradient: [self.cell.speed_gradient(), by.difference * self.cell.inverse_length],
            throughput: along(&self.throughput, &[density, by.through * self.cell.inverse_length]),
        }
    }

    /// Calls `record` with the variation of balance and ring forces for a unit variation of each force of the laws: at each
    /// station those of the flanks and ring friction, then the push force.
    #[inline(always)]
    pub fn for_each_force(&self, mut record: impl FnMut(CellBalance<Lanes>, RingForces<Lanes, D>)) {
        let [zero, one] = [0.0, 1.0].map(Lanes::from);
        for at in self.stations.iter().enumerate() {
            let (i, Some(station)) = at else { continue };
            for flank in 0..D - 1 {
                for force in 0..FLANK_FORCES {
                    let flanks = station.unit_flanks(&self.given, flank, force);
                    let (mut out, mut sum) = (CellBalance::default(), self.ring.empty());
                    self.add_unit((i, station), (&flanks, zero, [zero; 2]), &mut out, &mut sum);
                    record(out, self.ring.varied_forces(&sum, None, self.slopes[1]));
                }
            }
            let (mut out, mut sum) = (CellBalance::default(), self.ring.empty());
            let none = FlankSum::default();
            self.add_unit((i, station), (&none, one, [zero; 2]), &mut out, &mut sum);
            record(out, self.ring.varied_forces(&sum, None, self.slopes[1]));
        }
        let (mut out, mut sum) = (CellBalance::default(), self.ring.empty());
        out.speed = [one, -one];
        for (i, station) in self.stations.iter().enumerate() {
            let Some(station) = station else { continue };
            let pushed = (&FlankSum::default(), zero, station.chain.curvature);
            self.add_unit((i, station), pushed, &mut out, &mut sum);
        }
        record(out, self.ring.varied_forces(&sum, None, self.slopes[1]));
    }

    /// Adds the loads at station `i` of flanks, of ring friction and of a force across the belt, where nothing moves.
    #[inline(always)]
    fn add_unit(
        &self,
        at: (usize, &LinearisedStation<'_, D>),
        (flanks, friction, inward): (&FlankSum<Lanes>, Lanes, [Lanes; 2]),
        out: &mut CellBalance<Lanes>,
        sum: &mut R::Sum,
    ) {
        let zero = Lanes::zero();
        let change = StationVariation {
            by: &RingVariation::none(),
            chain: &ChainVariation::none(),
            flank: &FlankVariation::of_lambda(zero),
            along: zero,
            inward,
            tension: zero,
        };
        self.add_loads::<false>(at, &change, (LineLoad::zero(), flanks, [friction, zero]), out, sum);
    }

    /// Adds the variation of a load on the ring, of the flanks' loads, of ring friction and of the drag of the ring's
    /// layers at station `i`.
    #[inline(always)]
    fn add_loads<const MOVES: bool>(
        &self,
        (i, station): (usize, &LinearisedStation<'_, D>),
        change: &StationVariation<'_, D>,
        (mut load, flanks, [d_friction, d_drag]): (LineLoad<Lanes, D>, &FlankSum<Lanes>, [Lanes; 2]),
        out: &mut CellBalance<Lanes>,
        sum: &mut R::Sum,
    ) {
        let (ring, by, weight) = (station.ring, change.by, station.weight);
        let ring_along = load.position.dot(&ring.t);
        let ([mut along, tangential], force) = station.add_flank_forces::<MOVES>(change, flanks, &mut load);
        station.add_pulley_loads::<MOVES>(change.flank, flanks, force, out);

        let along_ring = station.forces.ring_friction + station.forces.layer_drag;
        let d_along_ring = d_friction + d_drag;
        let across = load.position.dot(&ring.n);
        load.position += ring.t * d_along_ring;
        let mut dragged = d_along_ring * ring.stretch;
        if MOVES {
            load.position += by.t * along_ring;
            dragged += along_ring * by.stretch;
        }
        load.drift += dragged;
        along += (tangential - d_friction) * station.chain.lead;
        let mut ring_along = ring_along + dragged;
        if self.given.law.is_chain() {
            load.position += ring.t * along;
            let mut drift = along * ring.stretch;
            if MOVES {
                let base = station.forces.along(ring, station.chain);
                load.position += by.t * base;
                drift += base * by.stretch;
            }
            load.drift += drift;
            ring_along += drift;
        } else {
            for face in [0, 1] {
                out.speed[face] += along * weight * share::<Lanes>(face, station.right);
            }
        }
        let action = Action {
            load,
            tension: change.tension,
            across,
            along: ring_along,
            weight,
        };
        self.ring
            .apply_varied(sum, i + 1, (ring, by), &station.forces.own_load, &action);
    }
}
