//! One cell of the belt: ring, chain and contact meet in one virtual-power statement.
//!
//! δP = ∫ [ring inertia·δv + δV_elastic] + ∫ m_e νλ a_e·δv_p − Q·δ(lengthening) − ∫ 2λ (contact force)·δ(its own point)
//!    − ∫ f_r δ(sliding of ring on elements) = 0.
//!
//! Each force enters with the velocity Jacobian of its own point: tangential flank forces at the pitch line (v_p),
//! radial ones at the ring centre line (v_e), ring friction on the difference of ring and element there, the push force
//! on the shortening of the stack. So no power is lost between ring, chain and pulleys, and no moment on the arcs.

use crate::chain::{ChainPoint, Stack, Transport};
use crate::contact::Friction;
use crate::reference_curve::ReferencePoint;
use crate::ring::kinematics::{Load, embed, in_plane};
use crate::scalar::Real;
use crate::variator::cell::flanks::{Approach, BothFlanks};
use crate::variator::cell::place::{CellBalance, CellLaw, CellMotion, Place, between};
use crate::variator::cell::ring::{Action, CellRing};
use crate::variator::cell::ring_friction::{pressing, ring_friction};
use crate::variator::cell::sample::{Probe, Sample};
use crate::variator::mesh::belt_mesh::STATIONS;
use nalgebra::{SVector, Vector2};

/// The balance of a cell, or of one in each lane of `T`, on whatever `ring` it has. `reference` gives the reference
/// curve at the face (0) and at the stations (1 and on); `probe` sees every station.
#[inline(always)]
pub(crate) fn balance<T: Real, const D: usize, R: CellRing<T, D>, S: Probe<T>>(
    law: &CellLaw,
    friction: &Friction,
    place: &Place<'_, T>,
    motion: &CellMotion<T>,
    ring: &mut R,
    reference: impl Fn(usize) -> ReferencePoint<T>,
    probe: &mut S,
) -> CellBalance<T> {
    let length = place.length;
    let e = law.chain.pitch_offset;
    let theta_dot = motion.reference.theta.rate;

    // Cell: length of the pitch line, density, shortening. All slots in one loop, so that what they need is compiled in
    // once.
    let mut face = None;
    let mut points = [None; STATIONS];
    let mut pitch_length = T::zero();
    let mut carried = T::zero();
    let mut through = T::zero();
    let mut steepness = T::zero();
    for slot in 0..=place.stations.len() {
        let point = ring.point(slot, reference(slot));
        let Some(i) = slot.checked_sub(1) else {
            face = Some(point);
            continue;
        };
        let station = &place.stations[i];
        let speed = between(&motion.speed, station.right);
        let chain = ChainPoint::new(e, &point, theta_dot, speed);
        let weight = length.v * station.weight;
        pitch_length += weight * chain.lambda;
        for k in 0..D - 1 {
            carried += weight * chain.curvature[k] * chain.normal_speed[k];
        }
        through += weight * chain.flow;
        steepness += weight * point.strain_gradient;
        points[i] = Some((point, chain, weight));
    }
    let face = face.expect("slot 0 is the face");
    let inverse_pitch_length = pitch_length.recip();
    let density = motion.amount * inverse_pitch_length;
    let difference = motion.speed[1] - motion.speed[0];
    let lengthening = difference - carried;
    let cell_length: T = place
        .stations
        .iter()
        .fold(T::zero(), |sum, s| sum + length.v * s.weight);
    let inverse_length = cell_length.recip();
    let strain_gradient = steepness * inverse_length;
    for (point, ..) in points.iter_mut().flatten() {
        point.strain_gradient = strain_gradient;
    }
    let thinning = -(density * lengthening * inverse_pitch_length);
    let Stack { push, collision, lag } =
        Stack::new(&law.chain, [density, thinning, through * inverse_length, difference]);

    let mut out = CellBalance {
        speed: [push.force - collision, collision - push.force],
        axial: T::zero(),
        tilting: [T::zero(); 2],
        torque: T::zero(),
        transport: Transport {
            flow: ChainPoint::new(e, &face, theta_dot, motion.speed[0]).flow,
            density,
            lag: if law.has_lag { lag } else { T::zero() },
        },
    };
    let speed_gradient = difference * inverse_length;
    let pulley = &motion.pulley;

    for (i, (found, station)) in points.iter().zip(place.stations).enumerate() {
        let Some((point, chain, weight)) = found else { continue };
        let slot = i + 1;
        let (weight, right) = (*weight, station.right);
        let mut point_load = Load::zero();
        // Conjugate of δV, per dξ.
        let mut along = T::zero();

        // Ring.
        let tension = ring.own_load(slot, point, &mut point_load);
        let ring_along = point_load.position.dot(&point.t);

        // Elements: inertia and push force.
        let speed_dot = between(&motion.speed_dot, right);
        let mass = density * chain.lambda * law.chain.mass_per_length;
        let (a_t, a_n) = chain.acceleration(point, speed_dot, speed_gradient);
        along += mass * a_t;

        // Contact.
        let v_p = chain.pitch_velocity(point);
        let v_e = chain.ring_line_velocity(point);
        let approach = Approach::new(law, place.axis, pulley, point, [&v_e, &v_p]);
        let Approach {
            e_r, e_t, rho, flank, ..
        } = approach;
        let lambda = chain.lambda;
        let BothFlanks {
            loads: flanks,
            on_movable,
            offset,
            lateral,
        } = approach.both_flanks(law, friction, place.plane, pulley, point, &v_e, lambda);
        let mut at_ring_line: SVector<T, D> = embed(e_r * -flanks.radial);
        if D > 2 {
            at_ring_line[D - 1] += lateral;
        }
        let at_pitch_line = e_t * -flanks.around;
        along += at_pitch_line.dot(&in_plane(&point.t));
        let normals = chain.normals.iter().zip(&chain.curvature).zip(&a_n);
        for ((normal, curvature), acceleration) in normals.take(D - 1) {
            let inward = mass * *acceleration
                + push.force * *curvature
                + at_pitch_line.dot(&in_plane(normal))
                + at_ring_line.dot(normal);
            point_load.position += normal * inward;
        }
        // Both sheaves tilt alike, under the mean of their moments.
        let axial = flanks.axial * 0.5;
        out.axial += on_movable * weight;
        out.tilting[0] += axial * rho * e_r.x * weight;
        out.tilting[1] -= axial * rho * e_r.y * weight;
        out.torque += flanks.torque * weight;

        // Ring on elements.
        let pressing = pressing(&law.ring, tension, motion.reference.s_dot);
        let sliding = point.t.dot(&point.r_dot) + point.w * point.stretch - chain.ring_line_speed();
        let ring_friction = ring_friction(friction, pressing, point.reference.kappa, sliding);
        let across = point_load.position.dot(&point.n);
        point_load.drift += ring_friction * point.stretch;
        point_load.position += point.t * ring_friction;
        along += (at_ring_line.dot(&point.t) - ring_friction) * chain.lead;
        ring.apply(
            slot,
            point,
            &Action {
                load: point_load,
                tension,
                across,
                along: ring_along + ring_friction * point.stretch,
                weight,
            },
        );
        out.speed[0] += along * weight * (-right + 1.0);
        out.speed[1] += along * weight * right;

        if S::ACTIVE {
            let of_ring = ring.density(point);
            let stack = (collision * difference - push.viscous * lengthening) * inverse_length;
            let from_axis = in_plane(&face.r) - Vector2::new(T::constant(place.axis), T::zero());
            probe.record(Sample {
                xi: point.reference.xi.v,
                curvature: [point.reference.kappa, face.reference.kappa],
                weight,
                r: [point.r[0], point.r[1]],
                pitch_radius: rho,
                face_radius: from_axis.dot(&from_axis).sqrt() - e,
                lambda,
                density,
                push: push.force,
                tension,
                normal: flanks.normal * 0.5,
                axial: on_movable,
                torque: flanks.torque,
                sliding: flank.tangential,
                flank_sliding: flank.along_flank,
                ring_sliding: sliding,
                penetration: flank.penetration,
                offset,
                lateral: if D == 2 {
                    [T::zero(); 2]
                } else {
                    [point.r[D - 1], point.slope[D - 1]]
                },
                flow: chain.flow,
                speed: chain.speed,
                sheave_loss: flanks.loss,
                ring_loss: ring_friction * sliding,
                damping_loss: of_ring.viscous + stack + flanks.viscous,
                kinetic: of_ring.kinetic + mass * v_p.dot(&v_p) * 0.5,
                ring_elastic: of_ring.elastic,
                outward: -((in_plane(&point.r) - point.reference.r).dot(&point.reference.n)),
            });
        }
    }
    out
}
