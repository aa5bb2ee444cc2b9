//! One cell of the belt: the virtual-power statement of ring, stack and contact (`docs/theory.md`,
//! section 1).
//!
//! δP = ∫ [ring inertia·δv + δV_elastic] + ∫ m_e νλ a_e·δv_p − Q·δ(lengthening) − ∫ 2λ (contact
//! force)·δ(its own point)
//!    + ∫ f_r δ(sliding of ring on elements) + ∫ f_l δ(ring along itself) + ∫ f_s δV = 0
//!
//! with the drags f against these motions. Each force acts on the velocity of its own point:
//! tangential flank forces on v_p, radial ones on v_e, ring friction on the sliding at the
//! innermost layer. The elastic force −∂E/∂ξ of the flanks along the belt is integrated by parts,
//! so the mean of E over a cell acts like a push force. A pull chain has neither stack nor ring
//! friction: its pins move with the ring, on which the forces along the belt act.

use crate::scalar::Real;
use crate::stack::Transport;
use crate::variator::cell::sample::AtStation;
use crate::variator::cell::state::{CellPoints, CellState, StationForces, StationState, stack_at_face};
use crate::variator::law::arguments::{CellBalance, CellInput, PulleyLoad};
use crate::variator::rings::{CellRing, StationLoad};

/// The balance of a cell, or of one in each lane of `T`, with this `ring`, and its state. Fills the
/// empty `points`, and calls `observe` at every station.
#[inline(always)]
pub fn balance<T: Real, const D: usize, R: CellRing<T, D>>(
    given: &CellInput<'_, T>,
    ring: &mut R,
    points: &mut CellPoints<T, D>,
    mut observe: impl FnMut(&AtStation<'_, T, D>),
) -> (CellBalance<T>, CellState<T>) {
    let cell = CellState::new(given, ring, points);
    let push = cell.push(given.law);
    let face = points.face();
    let mut out = CellBalance {
        speed: [push.force, -push.force],
        pulley: PulleyLoad {
            axial: T::zero(),
            tilting: [T::zero(); 2],
            torque: T::zero(),
            resultant: [T::zero(); 2],
        },
        transport: Transport {
            flow: stack_at_face(given, face).flow,
            density: cell.density,
        },
    };
    for (i, station) in points.stations.iter().enumerate() {
        let Some(station) = station else { continue };
        let forces = StationForces::new(given, &cell, i, station, ring, push.force);
        apply(given, cell.inverse_length, i, station, &forces, ring, &mut out);
        observe(&AtStation {
            given,
            cell: &cell,
            push: &push,
            face,
            index: i,
            station,
            forces: &forces,
            ring: ring.density(&station.ring),
        });
    }
    (out, cell)
}

/// Adds the contributions of station `i` to the forces on ring, elements and pulley.
#[inline(always)]
fn apply<T: Real, const D: usize, R: CellRing<T, D>>(
    given: &CellInput<'_, T>,
    inverse_length: T,
    i: usize,
    station: &StationState<T, D>,
    forces: &StationForces<T, D>,
    ring: &mut R,
    out: &mut CellBalance<T>,
) {
    let StationState {
        ring: point,
        stack,
        weight,
    } = station;
    let (weight, right) = (*weight, given.geometry.stations[i].right);
    let mut load = forces.own_load;
    let ring_along = load.position.dot(&point.t);
    for (normal, inward) in point.normals.iter().zip(forces.inward).take(D - 1) {
        load.position += normal * inward;
    }
    let across = load.position.dot(&point.normals[0]);
    let along_ring = forces.ring_friction + forces.layer_drag;
    let dragged = along_ring * point.stretch;
    load.drift += dragged;
    load.position += point.t * along_ring;
    let mut ring_along = ring_along + dragged;
    // Conjugate of δV, per dξ.
    let along = forces.along(point, stack);
    if given.law.is_pull_chain() {
        load.position += point.t * along;
        load.drift += along * point.stretch;
        ring_along += along * point.stretch;
    } else {
        // The mean of the energy over the cell acts like a push force.
        let pressure = forces.flanks.energy * inverse_length;
        out.speed[0] += (along * (-right + 1.0) + pressure) * weight;
        out.speed[1] += (along * right - pressure) * weight;
    }
    let station_load = StationLoad {
        load,
        tension: forces.tension,
        across,
        along: ring_along,
        weight,
    };
    ring.apply(i + 1, point, &station_load);

    // Both sheaves have the same tilt, under the mean of their moments.
    let (flanks, kinematics) = (&forces.flanks.sum, &forces.kinematics);
    let moment = kinematics.e_r * (flanks.loads.axial * 0.5 * kinematics.rho);
    let force = kinematics.e_r * flanks.loads.radial + kinematics.e_t * flanks.loads.circumferential;
    out.pulley.add(&flanks.on_pulley(moment, force), weight);
}
