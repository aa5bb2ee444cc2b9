//! One cell of the belt: the virtual-power statement of ring, chain and contact.
//!
//! δP = ∫ [ring inertia·δv + δV_elastic] + ∫ m_e νλ a_e·δv_p − Q·δ(lengthening) − ∫ 2λ (contact force)·δ(its own point)
//!    − ∫ f_r δ(sliding of ring on elements) − ∫ f_l δ(ring along itself) + ∫ f_s δV = 0.
//!
//! Each force is multiplied by the velocity Jacobian of its own point: tangential flank forces at the pitch line (v_p),
//! radial ones at the ring centre line (v_e), ring friction at the difference of ring and element velocity there, drag
//! of the ring's layers at the ring alone, drag of elements that start to turn at V alone, the push force at the
//! shortening of the stack. Power between ring, chain and
//! pulleys and moments on the arcs are thus balanced.
//!
//! A pull chain has neither stack nor ring friction. Its pins move with the ring, which stands for the whole chain: forces along
//! the belt act on the ring.

use crate::chain::Transport;
use crate::contact::FlankForce;
use crate::reference_curve::ReferencePoint;
use crate::ring::kinematics::RingPoint;
use crate::scalar::{Lanes, Real};
use crate::variator::cell::laws::{Direct, FLANK_FORCES, Laws};
use crate::variator::cell::observer::{AtStation, StationObserver};
use crate::variator::cell::state::{
    CellInput, CellState, Slots, StationForces, StationLoads, StationState, chain_at_face,
};
use crate::variator::law::place::CellBalance;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::{Action, CellRing, EulerianRing, RingForces};

/// The balance of a cell, or of one in each lane of `T`, with this `ring`. `reference` returns the reference curve at the
/// face (0) and at the stations (1 and up); `observer` is called at every station.
#[inline(always)]
pub fn balance<T: Real, const D: usize, R: CellRing<T, D>, P: StationObserver<T, D>>(
    given: &CellInput<'_, T>,
    ring: &mut R,
    reference: impl Fn(usize) -> ReferencePoint<T>,
    observer: &mut P,
) -> CellBalance<T> {
    let point = |ring: &R, slot: usize| ring.point(slot, reference(slot));
    balance_in(given, ring, (None, point), &mut Direct, &mut Slots::empty(), observer)
}

/// [`balance`] with these `laws` and the ring at `point`; fills the empty `slots`, without the face if the flow through it is
/// given.
#[inline(always)]
pub(crate) fn balance_in<T: Real, const D: usize, R: CellRing<T, D>, P: StationObserver<T, D>>(
    given: &CellInput<'_, T>,
    ring: &mut R,
    (flow, point): (Option<T>, impl Fn(&R, usize) -> RingPoint<T, D>),
    laws: &mut impl Laws<T>,
    slots: &mut Slots<T, D>,
    observer: &mut P,
) -> CellBalance<T> {
    let first = usize::from(flow.is_some());
    let cell = CellState::new(given, first, |slot| point(ring, slot), slots);
    let push = laws.stack(given, cell.stack_arguments());
    let mut out = CellBalance {
        speed: [push.force, -push.force],
        transport: Transport {
            flow: flow.unwrap_or_else(|| chain_at_face(given, slots.ring(0)).flow),
            density: cell.density,
        },
        ..CellBalance::zero()
    };
    for (i, station) in slots.stations.iter().enumerate() {
        let Some(station) = station else { continue };
        let forces = StationForces::new(given, &cell, (i, station), ring, push.force, laws);
        apply(given, (i, station), &forces.loads(station), ring, &mut out);
        observer.observe(&AtStation {
            given,
            cell: &cell,
            push: &push,
            face: slots.face.as_ref(),
            index: i,
            station,
            forces: &forces,
            ring,
        });
    }
    out
}

/// Balance and forces of an `unloaded` ring for each unit force of the laws, in their order, at these forces: the rows L of
/// [`laws`](crate::variator::cell::laws).
#[inline(always)]
pub(crate) fn unit_forces<const D: usize, R: EulerianRing<Lanes, D>>(
    given: &CellInput<'_, Lanes>,
    (slots, forces): (&Slots<Lanes, D>, &[Option<StationForces<Lanes, D>>; STATIONS]),
    unloaded: &R,
    mut record: impl FnMut(&CellBalance<Lanes>, &RingForces<Lanes, D>),
) {
    let [zero, one] = [0.0, 1.0].map(Lanes::from);
    let none = [zero; FLANK_FORCES];
    let of = (given.law, given.place.plane[0]);
    let stations = || (slots.stations.iter().zip(forces)).enumerate();
    let mut respond = |at: std::ops::Range<usize>, push: Lanes, flanks: [[Lanes; FLANK_FORCES]; 2], friction: Lanes| {
        let (mut out, mut ring) = (CellBalance::zero(), unloaded.clone());
        out.speed = [push, -push];
        for (i, at) in stations().filter(|(i, _)| at.contains(i)) {
            let (Some(station), Some(forces)) = at else { continue };
            let loads = forces.loads_of_laws(of, station, (flanks.map(FlankForce::of), push, friction));
            apply(given, (i, station), &loads, &mut ring, &mut out);
        }
        record(&out, &ring.forces());
    };
    respond(0..STATIONS, one, [none; 2], zero);
    for station in 0..given.place.stations.len() {
        let at = station..station + 1;
        for flank in 0..D - 1 {
            for force in 0..FLANK_FORCES {
                let mut unit = [none; 2];
                unit[flank][force] = one;
                if D == 2 {
                    unit[1] = unit[0];
                }
                respond(at.clone(), zero, unit, zero);
            }
        }
        respond(at, zero, [none; 2], one);
    }
}

/// Adds the loads at station `i` to the forces on ring, elements and pulley.
#[inline(always)]
pub(crate) fn apply<T: Real, const D: usize, R: CellRing<T, D>>(
    given: &CellInput<'_, T>,
    (i, station): (usize, &StationState<T, D>),
    loads: &StationLoads<T, D>,
    ring: &mut R,
    out: &mut CellBalance<T>,
) {
    let StationState {
        ring: point,
        chain,
        weight,
    } = station;
    let (weight, right) = (*weight, given.place.stations[i].right);
    let mut load = loads.own_load;
    let ring_along = load.position.dot(&point.t);
    for (normal, inward) in chain.normals.iter().zip(loads.inward).take(D - 1) {
        load.position += normal * inward;
    }
    let across = load.position.dot(&point.n);
    let dragged = loads.along_ring * point.stretch;
    load.drift += dragged;
    load.position += point.t * loads.along_ring;
    let mut ring_along = ring_along + dragged;
    let along = loads.along;
    if given.law.is_chain() {
        load.position += point.t * along;
        load.drift += along * point.stretch;
        ring_along += along * point.stretch;
    } else {
        out.speed[0] += along * weight * (-right + 1.0);
        out.speed[1] += along * weight * right;
    }
    let action = Action {
        load,
        tension: loads.tension,
        across,
        along: ring_along,
        weight,
    };
    ring.apply(i + 1, point, &action);

    out.axial += loads.axial * weight;
    out.tilting[0] += loads.tilting[0] * weight;
    out.tilting[1] -= loads.tilting[1] * weight;
    out.torque += loads.torque * weight;
    out.resultant[0] += loads.resultant[0] * weight;
    out.resultant[1] += loads.resultant[1] * weight;
}
