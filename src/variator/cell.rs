//! One cell of the belt: ring, chain and contact meet in one virtual-power statement.
//!
//! δP = ∫ [ring inertia·δv + δV_elastic] + ∫ m_e νλ a_e·δv_p − Q·δ(lengthening) − ∫ 2λ (contact force)·δ(its own point)
//!    − ∫ f_r δ(sliding of ring on elements) = 0.
//!
//! Each force enters with the velocity Jacobian of its own point: tangential flank forces at the pitch line (v_p),
//! radial ones at the ring centre line (v_e), ring friction on the difference of ring and element there, the push force
//! on the shortening of the stack. So no power is lost between ring, chain and pulleys, and no moment on the arcs.

use super::flanks::{Approach, BothFlanks};
use super::mesh::Station;
use super::parameters::{Friction, Parameters};
use super::ring::{Action, CellRing};
use super::sample::{Probe, Sample};
use crate::chain::{ChainPoint, Stack, Transport};
use crate::reference_curve::{Jet, ReferencePoint};
use crate::ring::Ring;
use crate::ring::kinematics::{Load, Motion, ReferenceMotion, embed, in_plane};
use crate::scalar::{Real, smooth_plus};
use nalgebra::{SVector, Vector2};

/// Most stations of a cell.
pub(super) const STATIONS: usize = 3;
/// Its stations, and its left face before them.
pub(super) const SLOTS: usize = STATIONS + 1;

/// Smoothing width of the ring's normal load ⟨T − m_r ṡ²⟩₊, N.
const RING_LOAD_SMOOTHING: f64 = 1.0;

/// Constants of the cell law.
#[derive(Clone, Debug)]
pub struct CellLaw {
    /// Parameters.
    pub parameters: Parameters,
    /// sin β, cos β, tan β.
    pub wedge: [f64; 3],
    /// Pitch radius of unloaded contact at ratio 1, m.
    pub r0: f64,
    /// Pulley axes, x coordinate, [`S`](super::mesh::S) and [`P`](super::mesh::P), m.
    pub axes: [f64; 2],
    /// Where the sheaves stand along z.
    pub planes: [SheavePlane; 2],
    /// Whether amounts leave with a lag. Not with one cell an element: what it depends on would leave the band of the
    /// matrix.
    pub has_lag: bool,
}

/// The middle of a pulley along z: it moves away from the movable sheave by half of what that closes.
///
/// The movable sheaves stand on opposite sides of the belt, so both middles go the same way when the ratio changes.
/// They part by z_P/2 + z_S/2 = (r_P + r_S − 2r₀) tan β, because the radii don't change equally.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheavePlane {
    /// Where the movable sheave stands: +1 or −1 along z.
    pub side: f64,
    /// Middle of the pulley at z_j = 0, m.
    pub middle: f64,
}

impl SheavePlane {
    /// Planes of [`S`](super::mesh::S) and [`P`](super::mesh::P) that are `offset` apart at ratio 1.
    #[must_use]
    pub fn pair(offset: f64) -> [Self; 2] {
        [-1.0, 1.0].map(|side| Self {
            side,
            middle: 0.5 * side * offset,
        })
    }

    /// Side and middle.
    #[must_use]
    pub fn constants(&self) -> [f64; 2] {
        [self.side, self.middle]
    }

    /// Middle of the pulley whose sheave has closed by `z`, m.
    #[must_use]
    pub fn middle(&self, z: f64) -> f64 {
        self.middle - 0.5 * self.side * z
    }
}

/// Motion of a pulley.
#[derive(Clone, Copy, Debug)]
pub struct PulleyMotion<T> {
    /// z, m.
    pub z: T,
    /// ż, m/s.
    pub z_dot: T,
    /// ψ_x, ψ_y, rad.
    pub psi: [T; 2],
    /// Their rates, rad/s.
    pub psi_dot: [T; 2],
    /// ω, rad/s.
    pub omega: T,
}

/// State of a cell, the ring aside.
#[derive(Clone, Copy, Debug)]
pub struct CellMotion<T: Real> {
    /// V at the faces, m/s.
    pub speed: [T; 2],
    /// V̇ at the faces, m/s².
    pub speed_dot: [T; 2],
    /// N, m.
    pub amount: T,
    /// Reference motion.
    pub reference: ReferenceMotion<T>,
    /// The pulley this cell can touch.
    pub pulley: PulleyMotion<T>,
}

impl<T: Real> CellMotion<T> {
    /// From what tells the unknowns of a direction: V, V, N are those from `own` on, s, Θ, z, ψ_x, ψ_y, ω those from
    /// `globals` on.
    #[inline(always)]
    pub(super) fn of_directions(
        [own, globals]: [usize; 2],
        position: impl Fn(usize) -> T,
        value: impl Fn(usize) -> T,
        rate: impl Fn(usize) -> T,
    ) -> Self {
        let [drift, theta, sheave, tilt_x, tilt_y, shaft] = std::array::from_fn(|k| globals + k);
        Self {
            speed: [value(own), value(own + 1)],
            speed_dot: [rate(own), rate(own + 1)],
            amount: value(own + 2),
            reference: ReferenceMotion {
                theta: Motion {
                    value: position(theta),
                    rate: value(theta),
                    acceleration: rate(theta),
                },
                s_dot: value(drift),
                s_ddot: rate(drift),
            },
            pulley: PulleyMotion {
                z: position(sheave),
                z_dot: value(sheave),
                psi: [value(tilt_x), value(tilt_y)],
                psi_dot: [rate(tilt_x), rate(tilt_y)],
                omega: value(shaft),
            },
        }
    }
}

/// Generalised residual forces of a cell (inertia − forces), those on the ring aside, and its flow.
#[derive(Clone, Copy, Debug)]
pub struct CellBalance<T: Real> {
    /// Conjugates of V at the faces, N.
    pub speed: [T; 2],
    /// Axial belt force on one sheave, N.
    pub axial: T,
    /// Moment of the axial force on one sheave, N·m.
    pub tilting: [T; 2],
    /// Torque of the belt on the pulley, N·m.
    pub torque: T,
    /// For the balance of the amounts.
    pub transport: Transport<T>,
}

/// Where cells lie: constants of the mesh, and the element at the present Θ.
#[derive(Debug)]
pub struct Place<'a, T: Real> {
    /// Start and length of the element as fractions of the segment.
    pub of_segment: [T::Constant; 2],
    /// Left face; its fraction and those of the stations are of the element.
    pub face: &'a Station<T::Constant>,
    /// Quadrature points.
    pub stations: &'a [Station<T::Constant>],
    /// Pulley axis, x coordinate, m.
    pub axis: T::Constant,
    /// Side of the pulley's movable sheave and its middle at z_j = 0, as in [`SheavePlane`].
    pub plane: [T::Constant; 2],
    /// Length of the element.
    pub length: Jet<T>,
}

impl<T: Real> Place<'_, T> {
    /// The face (0), or a station (1 and on).
    #[inline(always)]
    #[must_use]
    pub fn slot(&self, slot: usize) -> &Station<T::Constant> {
        if slot == 0 { self.face } else { &self.stations[slot - 1] }
    }

    /// Fraction of the segment there.
    #[inline(always)]
    #[must_use]
    pub fn fraction(&self, slot: usize) -> T::Constant {
        let [start, share] = self.of_segment;
        start + share * self.slot(slot).fraction
    }
}

/// Linear between the two faces of a cell.
#[inline(always)]
pub(super) fn between<T: Real>(faces: &[T; 2], right: T::Constant) -> T {
    faces[0] * (-right + 1.0) + faces[1] * right
}

/// Part of the ring's tension that presses it on the elements, N: less what keeps its own mass on the curve at ṡ, m/s.
#[inline(always)]
pub(super) fn pressing<T: Real>(ring: &Ring, tension: T, s_dot: T) -> T {
    tension - s_dot * s_dot * ring.mass_per_length
}

/// The same where it is no pull, N.
#[inline(always)]
pub(super) fn ring_load<T: Real>(pressing: T) -> T {
    smooth_plus(pressing, RING_LOAD_SMOOTHING).0
}

/// Friction of the ring on elements per dξ, N/m, under the tension `pressing`, N, where it slides at `sliding`, m/s.
#[inline(always)]
pub(super) fn ring_friction<T: Real>(friction: &Friction, pressing: T, kappa: T, sliding: T) -> T {
    let load = ring_load(pressing);
    let v0 = friction.velocity;
    let (_, inverse_speed) = (sliding * sliding + v0 * v0).root_and_inverse();
    load * kappa * friction.ring * sliding * inverse_speed
}

/// Share of a face in [`between`]: 0 the left one, 1 the right one.
#[inline(always)]
pub(super) fn share<T: Real>(face: usize, right: T::Constant) -> T {
    T::constant(if face == 0 { -right + 1.0 } else { right })
}

/// The balance of a cell, or of one in each lane of `T`, on whatever `ring` it has. `reference` gives the reference
/// curve at the face (0) and at the stations (1 and on); `probe` sees every station.
#[inline(always)]
pub fn balance<T: Real, const D: usize, R: CellRing<T, D>, S: Probe<T>>(
    law: &CellLaw,
    place: &Place<'_, T>,
    motion: &CellMotion<T>,
    ring: &mut R,
    reference: impl Fn(usize) -> ReferencePoint<T>,
    probe: &mut S,
) -> CellBalance<T> {
    let length = place.length;
    let p = &law.parameters;
    let e = p.belt.pitch_offset;
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
    let Stack { push, collision, lag } = Stack::new(&p.belt, [density, thinning, through * inverse_length, difference]);

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
        let mass = density * chain.lambda * p.belt.mass_per_length;
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
        } = approach.both_flanks(law, place.plane, pulley, point, &v_e, lambda);
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
        let pressing = pressing(&p.ring, tension, motion.reference.s_dot);
        let sliding = point.t.dot(&point.r_dot) + point.w * point.stretch - chain.ring_line_speed();
        let ring_friction = ring_friction(&p.friction, pressing, point.reference.kappa, sliding);
        let across = point_load.position.dot(&point.n);
        point_load.drift += ring_friction * point.stretch;
        point_load.position += point.t * ring_friction;
        along += (at_ring_line.dot(&point.t) - ring_friction) * chain.lead;
        ring.take(
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
            probe.take(Sample {
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
