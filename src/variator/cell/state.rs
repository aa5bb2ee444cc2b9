//! The state of a cell and of its stations, used by its balance and by the derivatives of the balance.

use crate::chain::ChainPoint;
use crate::contact::{FlankForce, Friction};
use crate::ring::kinematics::{LineLoad, RingPoint, embed, in_plane};
use crate::scalar::Real;
use crate::variator::cell::laws::Laws;
use crate::variator::law::flanks::{Approach, BothFlanks};
use crate::variator::law::place::{CellLaw, CellMotion, Place, between};
use crate::variator::law::ring_friction::pressing;
use crate::variator::law::spin::{passing, spin_drag};
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::CellRing;
use nalgebra::{SVector, Vector2};

/// Arguments of the cell law: constants, friction, place and motion.
#[derive(Debug)]
pub struct CellInput<'a, T: Real> {
    /// Constants of the laws.
    pub law: &'a CellLaw,
    /// Friction in force.
    pub friction: &'a Friction,
    /// Place of the cell on the belt.
    pub place: &'a Place<'a, T>,
    /// State of the cell without the ring.
    pub motion: &'a CellMotion<T>,
}

/// Ring and chain at a station, and its quadrature weight.
#[derive(Clone, Copy, Debug)]
pub struct StationState<T: Real, const D: usize> {
    /// The ring.
    pub ring: RingPoint<T, D>,
    /// The push elements.
    pub chain: ChainPoint<T, D>,
    /// dξ, m.
    pub weight: T,
}

/// The ring at the left face of a cell, ring and chain at its stations. Their size is kilobytes, so they are written in
/// place.
#[derive(Clone, Copy, Debug)]
pub struct Slots<T: Real, const D: usize> {
    pub face: Option<RingPoint<T, D>>,
    pub stations: [Option<StationState<T, D>>; STATIONS],
}

impl<T: Real, const D: usize> Slots<T, D> {
    #[inline(always)]
    pub fn empty() -> Self {
        Self {
            face: None,
            stations: [None; STATIONS],
        }
    }

    /// The ring at the face (0) or at a station (1 and up).
    #[inline(always)]
    pub fn ring(&self, slot: usize) -> &RingPoint<T, D> {
        match slot.checked_sub(1) {
            Some(i) => &self.stations[i].as_ref().expect("a station of the cell").ring,
            None => self.face.as_ref().expect("slot 0 is the face"),
        }
    }
}

/// Speed V of the elements where the right face of a cell has the weight `right`: linear between the faces. The pins of a chain
/// have that of the ring.
#[inline(always)]
fn element_speed<T: Real, const D: usize>(given: &CellInput<'_, T>, ring: &RingPoint<T, D>, right: T::Constant) -> T {
    if given.law.is_chain() {
        ring.t.dot(&ring.r_dot) + ring.w * ring.stretch
    } else {
        between(&given.motion.speed, right)
    }
}

/// The chain at the left face of a cell.
#[inline(always)]
pub fn chain_at_face<T: Real, const D: usize>(given: &CellInput<'_, T>, face: &RingPoint<T, D>) -> ChainPoint<T, D> {
    let theta_dot = given.motion.reference.theta.rate;
    let speed = element_speed(given, face, given.place.face.right);
    ChainPoint::new(given.law.chain.pitch_offset, face, theta_dot, speed)
}

/// Arguments of the laws of a cell's stack.
#[derive(Clone, Copy, Debug)]
pub struct CellState<T: Real> {
    /// Reciprocals of the length of the pitch line and of the cell, 1/m.
    pub inverse_pitch_length: T,
    pub inverse_length: T,
    /// Density ν.
    pub density: T,
    /// Difference of V across the cell, m/s.
    pub difference: T,
    /// Rate of the stack's lengthening, m/s.
    pub lengthening: T,
    /// Mean flow through the cell, m/s.
    pub flow: T,
    /// Amount of elements [`passing`], m/s.
    pub passing: T,
}

impl<T: Real> CellState<T> {
    /// The state of a cell; fills `slots` from the `first` on. `point` returns the ring at the face (0) and at the stations (1
    /// and up). One loop evaluates all slots, so that the code for a slot is inlined once.
    #[inline(always)]
    pub fn new<const D: usize>(
        given: &CellInput<'_, T>,
        first: usize,
        point: impl Fn(usize) -> RingPoint<T, D>,
        slots: &mut Slots<T, D>,
    ) -> Self {
        let CellInput { law, place, motion, .. } = *given;
        let e = law.chain.pitch_offset;
        let theta_dot = motion.reference.theta.rate;
        let length = place.length.v;
        let (mut pitch_length, mut carried, mut through, mut steepness) = (T::zero(), T::zero(), T::zero(), T::zero());
        for slot in first..=place.stations.len() {
            let point = point(slot);
            let Some(i) = slot.checked_sub(1) else {
                slots.face = Some(point);
                continue;
            };
            let station = &place.stations[i];
            let speed = element_speed(given, &point, station.right);
            let chain = ChainPoint::new(e, &point, theta_dot, speed);
            let weight = length * station.weight;
            pitch_length += weight * chain.lambda;
            for k in 0..D - 1 {
                carried += weight * chain.curvature[k] * chain.normal_speed[k];
            }
            through += weight * chain.flow;
            steepness += weight * point.strain_gradient;
            slots.stations[i] = Some(StationState {
                ring: point,
                chain,
                weight,
            });
        }
        let inverse_pitch_length = pitch_length.recip();
        let difference = motion.speed[1] - motion.speed[0];
        let cell_length: T = place.stations.iter().fold(T::zero(), |sum, s| sum + length * s.weight);
        let inverse_length = cell_length.recip();
        // The gradient of the strain is its mean over the cell (see `ring/ale.rs`).
        let strain_gradient = steepness * inverse_length;
        for station in slots.stations.iter_mut().flatten() {
            station.ring.strain_gradient = strain_gradient;
        }
        // The pins of a chain are on it as they were mounted: one per dξ.
        let amount = if law.is_chain() { cell_length } else { motion.amount };
        let density = amount * inverse_pitch_length;
        let flow = through * inverse_length;
        Self {
            inverse_pitch_length,
            inverse_length,
            density,
            difference,
            lengthening: difference - carried,
            flow,
            passing: passing(density, flow),
        }
    }

    /// Arguments of the push force: ν and its material rate.
    #[inline(always)]
    pub fn stack_arguments(&self) -> [T; 2] {
        let thinning = -(self.density * self.lengthening * self.inverse_pitch_length);
        [self.density, thinning]
    }

    /// ∂V/∂ξ, 1/s.
    #[inline(always)]
    pub fn speed_gradient(&self) -> T {
        self.difference * self.inverse_length
    }
}

/// Forces at a station per dξ.
#[derive(Clone, Copy, Debug)]
pub struct StationForces<T: Real, const D: usize> {
    /// Own load of the ring, and its tension, N.
    pub own_load: LineLoad<T, D>,
    pub tension: T,
    /// Mass of the elements per dξ, kg/m, and their inertia along the belt, N/m.
    pub mass: T,
    pub inertia: T,
    /// Velocities at the pitch line and at the ring centre line, m/s.
    pub v_p: SVector<T, D>,
    pub v_e: SVector<T, D>,
    pub approach: Approach<T>,
    pub flanks: BothFlanks<T>,
    pub on_elements: OnElements<T>,
    /// T − m_r ṡ², N, sliding speed of the ring on the elements, m/s, and its friction, N/m.
    pub pressing: T,
    pub sliding: T,
    pub ring_friction: T,
    /// Speed of the ring along itself, m/s, and drag of its layers, N/m.
    pub ring_speed: T,
    pub layer_drag: T,
    /// Drag of elements that start and stop turning, N/m.
    pub spin_drag: T,
}

impl<T: Real, const D: usize> StationForces<T, D> {
    /// Forces at station `i` of a cell under the push force `push`, N, and the forces of the `laws`.
    #[inline(always)]
    pub fn new<R: CellRing<T, D>>(
        given: &CellInput<'_, T>,
        cell: &CellState<T>,
        (i, station): (usize, &StationState<T, D>),
        ring: &R,
        push: T,
        laws: &mut impl Laws<T>,
    ) -> Self {
        let CellInput { law, place, motion, .. } = given;
        let StationState { ring: point, chain, .. } = station;
        let mut own_load = LineLoad::zero();
        let tension = ring.own_load(i + 1, point, &mut own_load);
        let speed_dot = between(&motion.speed_dot, place.stations[i].right);
        let mass = cell.density * chain.lambda * law.chain.mass_per_length;
        let acceleration = chain.acceleration(point, speed_dot, cell.speed_gradient());

        let v_p = chain.pitch_velocity(point);
        let v_e = chain.ring_line_velocity(point);
        let approach = Approach::new(law, place.axis, &motion.pulley, point, [&v_e, &v_p]);
        let of_flanks = approach.flanks(law, place.plane, &motion.pulley, point, &v_e);
        let movable = laws.flank(given, [i, 0], &of_flanks.1[0]);
        let fixed = if D == 2 {
            movable
        } else {
            laws.flank(given, [i, 1], &of_flanks.1[1])
        };

        let pressing = pressing(law.saddle_mass, tension, motion.reference.s_dot);
        let ring_speed = point.t.dot(&point.r_dot) + point.w * point.stretch;
        let sliding = ring_speed - chain.ring_line_speed();
        let kappa = point.reference.kappa;
        let ring_friction = laws.ring(given, i, [pressing, sliding, kappa]);
        let flanks = approach.both_flanks::<D>(law, place.plane[0], of_flanks, [movable, fixed], chain.lambda);
        let own = acceleration.1.map(|across| mass * across);
        let on_elements = OnElements::new(station, &approach, &flanks, own, [push, ring_friction]);
        Self {
            own_load,
            tension,
            mass,
            inertia: mass * acceleration.0,
            v_p,
            v_e,
            approach,
            flanks,
            on_elements,
            pressing,
            sliding,
            ring_friction,
            ring_speed,
            layer_drag: laws.layers(i, [place.layer_drag, pressing, kappa, ring_speed]),
            spin_drag: spin_drag(place.spin, kappa, [cell.passing, chain.speed]),
        }
    }

    /// The loads at this place where the laws alone act: flanks, push force and friction between ring and elements.
    #[inline(always)]
    pub fn loads_of_laws(
        &self,
        (law, side): (&CellLaw, T::Constant),
        station: &StationState<T, D>,
        (forces, push, ring_friction): ([FlankForce<T>; 2], T, T),
    ) -> StationLoads<T, D> {
        let of_flanks = (self.flanks.offset, self.flanks.motions);
        let (approach, zero) = (&self.approach, T::zero());
        let flanks = approach.both_flanks::<D>(law, side, of_flanks, forces, station.chain.lambda);
        let on_elements = OnElements::new(station, approach, &flanks, [zero; 2], [push, ring_friction]);
        let own = (LineLoad::zero(), zero);
        loads(
            station,
            own,
            (approach, &flanks, &on_elements),
            [ring_friction, zero],
            zero,
        )
    }
}

/// Forces on the elements at a station per dξ.
#[derive(Clone, Copy, Debug)]
pub struct OnElements<T: Real> {
    /// Those of the flanks at the pitch line along t̂, N/m.
    along: T,
    /// All along the normals, inwards, N/m.
    inward: [T; 2],
    /// Conjugate of v_e·t̂: flanks and ring friction, N/m.
    tangential: T,
}

impl<T: Real> OnElements<T> {
    /// With the inertia `inward` along the normals, under push force and ring friction.
    #[inline(always)]
    fn new<const D: usize>(
        StationState { ring, chain, .. }: &StationState<T, D>,
        approach: &Approach<T>,
        flanks: &BothFlanks<T>,
        mut inward: [T; 2],
        [push, ring_friction]: [T; 2],
    ) -> Self {
        let (at_pitch_line, at_ring_line) = flank_forces::<T, D>(approach, flanks);
        for (k, inward) in inward.iter_mut().enumerate().take(D - 1) {
            let normal = &chain.normals[k];
            *inward =
                *inward + push * chain.curvature[k] + at_pitch_line.dot(&in_plane(normal)) + at_ring_line.dot(normal);
        }
        Self {
            along: at_pitch_line.dot(&in_plane(&ring.t)),
            inward,
            tangential: at_ring_line.dot(&ring.t) - ring_friction,
        }
    }
}

/// Loads at a station per dξ, in which the balance of its cell is linear.
#[derive(Clone, Copy, Debug)]
pub struct StationLoads<T: Real, const D: usize> {
    /// Own load of the ring, and its tension, N.
    pub own_load: LineLoad<T, D>,
    pub tension: T,
    /// Forces along the normals, inwards, N/m.
    pub inward: [T; 2],
    /// Friction and drag on the ring along itself, N/m.
    pub along_ring: T,
    /// Inertia less forces along the belt, conjugate to V, N/m.
    pub along: T,
    /// Axial load on the movable sheave, N/m, moments of the mean axial load, N, and torque on the pulley, N.
    pub axial: T,
    pub tilting: [T; 2],
    pub torque: T,
    /// Resultant of the contact forces on the belt, N/m.
    pub resultant: [T; 2],
}

impl<T: Real, const D: usize> StationLoads<T, D> {
    /// Applies `f` to each.
    #[inline(always)]
    pub fn map<U: Real>(&self, f: impl Fn(T) -> U) -> StationLoads<U, D> {
        let vector = |v: &SVector<T, D>| v.map(&f);
        let load = &self.own_load;
        StationLoads {
            own_load: LineLoad {
                position: vector(&load.position),
                slope: vector(&load.slope),
                bend: vector(&load.bend),
                drift: f(load.drift),
                theta: f(load.theta),
            },
            tension: f(self.tension),
            inward: self.inward.map(&f),
            along_ring: f(self.along_ring),
            along: f(self.along),
            axial: f(self.axial),
            tilting: self.tilting.map(&f),
            torque: f(self.torque),
            resultant: self.resultant.map(&f),
        }
    }
}

impl<T: Real, const D: usize> StationForces<T, D> {
    /// The loads of these forces on ring, elements and pulley.
    #[inline(always)]
    pub fn loads(&self, station: &StationState<T, D>) -> StationLoads<T, D> {
        let along_ring = self.ring_friction + self.layer_drag;
        let place = (&self.approach, &self.flanks, &self.on_elements);
        loads(
            station,
            (self.own_load, self.tension),
            place,
            [along_ring, self.inertia],
            self.spin_drag,
        )
    }
}

/// The loads at a station: own load and tension of the ring, forces of the flanks and on the elements, friction and drag on the
/// ring along itself, inertia and drag of the elements along the belt.
#[inline(always)]
fn loads<T: Real, const D: usize>(
    StationState { chain, .. }: &StationState<T, D>,
    (own_load, tension): (LineLoad<T, D>, T),
    (at, flanks, on_elements): (&Approach<T>, &BothFlanks<T>, &OnElements<T>),
    [along_ring, inertia]: [T; 2],
    spin_drag: T,
) -> StationLoads<T, D> {
    // Both sheaves have the same tilt, under the mean of their moments.
    let moment = flanks.loads.axial * 0.5 * at.rho;
    StationLoads {
        own_load,
        tension,
        inward: on_elements.inward,
        along_ring,
        along: inertia + on_elements.along + on_elements.tangential * chain.lead + spin_drag,
        axial: flanks.on_movable,
        tilting: [moment * at.e_r.x, moment * at.e_r.y],
        torque: flanks.loads.torque,
        resultant: (at.e_r * flanks.loads.radial + at.e_t * flanks.loads.around).into(),
    }
}

/// Forces of the flanks at the pitch line (tangential) and at the ring centre line, N/m.
#[inline(always)]
fn flank_forces<T: Real, const D: usize>(
    approach: &Approach<T>,
    flanks: &BothFlanks<T>,
) -> (Vector2<T>, SVector<T, D>) {
    let mut at_ring_line: SVector<T, D> = embed(approach.e_r * -flanks.loads.radial);
    if D > 2 {
        at_ring_line[D - 1] += flanks.lateral;
    }
    (approach.e_t * -flanks.loads.around, at_ring_line)
}
