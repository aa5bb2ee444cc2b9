//! One cell of the belt: ring, chain and contact meet in one virtual-power statement.
//!
//! δP = ∫ [ring inertia·δv + δV_elastic] + ∫ m_e νλ a_e·δv_p − Q·δ(lengthening) − ∫ 2λ (contact force)·δ(its own point)
//!    − ∫ f_r δ(sliding of ring on elements) = 0.
//!
//! Each force enters with the velocity Jacobian of its own point: tangential flank forces at the pitch line (v_p),
//! radial ones at the ring centre line (v_e, with its flow c), ring friction on the difference of the two flows, the
//! push force on the shortening of the stack. So no power is lost between ring, chain and pulleys.

use super::mesh::Station;
use super::parameters::{Friction, Parameters};
use super::ring::{Action, CellRing};
use crate::chain::{ChainPoint, Stack, Transport};
use crate::contact::{FlankForce, FlankMotion, flank_force};
use crate::reference_curve::{Jet, ReferencePoint};
use crate::ring::Ring;
use crate::ring::kinematics::{Load, Motion, ReferenceMotion, RingPoint, embed, in_plane};
use crate::scalar::{Lanes, Real, smooth_plus};
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

/// What a station tells: values for outputs, losses and energies; of one cell, or of one in each lane of `L`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample<L = f64> {
    /// ξ, m.
    pub xi: L,
    /// Reference curvature κ there and at the left face of the cell, 1/m: 0 on a strand.
    pub curvature: [L; 2],
    /// Ring length dξ that the station stands for, m.
    pub weight: L,
    /// Position of the ring centre line, m.
    pub r: [L; 2],
    /// Pitch radius ϱ about the pulley axis, m.
    pub pitch_radius: L,
    /// Pitch radius at the left face of the cell, m.
    pub face_radius: L,
    /// λ.
    pub lambda: L,
    /// ν of the cell.
    pub density: L,
    /// Push force Q, N.
    pub push: L,
    /// Ring tension T, N.
    pub tension: L,
    /// Normal force per flank and ring length, N/m.
    pub normal: L,
    /// Axial force on one sheave per ring length, N/m.
    pub axial: L,
    /// Torque of the belt on the pulley per ring length, N.
    pub torque: L,
    /// Tangential sliding speed, m/s.
    pub sliding: L,
    /// Sliding speed along the flank, m/s.
    pub flank_sliding: L,
    /// Sliding speed of the ring on the elements, m/s.
    pub ring_sliding: L,
    /// Penetration, m.
    pub penetration: L,
    /// Distance of the ring from the middle of the pulley, towards its movable sheave, m; 0 in the plane.
    pub offset: L,
    /// Deflection w along z, m, and its slope w'.
    pub lateral: [L; 2],
    /// J, m/s.
    pub flow: L,
    /// V, m/s.
    pub speed: L,
    /// Loss to sheave friction, W/m.
    pub sheave_loss: L,
    /// Loss to ring friction, W/m.
    pub ring_loss: L,
    /// Loss to structural, chain and contact damping, W/m.
    pub damping_loss: L,
    /// Kinetic energy, J/m.
    pub kinetic: L,
    /// Elastic energy of the ring, J/m.
    pub ring_elastic: L,
    /// Outward deflection from the reference curve, m.
    pub outward: L,
}

/// Calls a macro with all figures of a [`Sample`].
macro_rules! for_each_figure {
    ($with:ident) => {
        $with! {
            xi, curvature[0], curvature[1], weight, r[0], r[1], pitch_radius, face_radius, lambda, density, push, tension, normal, axial, torque,
            sliding, flank_sliding, ring_sliding, penetration, offset, lateral[0], lateral[1], flow, speed, sheave_loss, ring_loss, damping_loss,
            kinetic, ring_elastic, outward
        }
    };
}

impl Sample<Lanes> {
    /// The sample of the cell in a lane. Inlined, it reads only what is asked of it.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, lane: usize) -> Sample {
        let mut cell = Sample::default();
        macro_rules! get {
            ($($field:ident $([$k:literal])?),*) => {$( cell.$field $([$k])? = self.$field $([$k])?.lane(lane); )*};
        }
        for_each_figure!(get);
        cell
    }

    /// Writes the sample of the cell in a lane.
    pub fn set(&mut self, lane: usize, cell: &Sample) {
        macro_rules! set {
            ($($field:ident $([$k:literal])?),*) => {$( self.$field $([$k])?.set(lane, cell.$field $([$k])?); )*};
        }
        for_each_figure!(set);
    }
}

impl Sample {
    /// Whether the station lies on an arc.
    #[must_use]
    pub fn on_arc(&self) -> bool {
        self.curvature[0] > 0.0
    }
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

/// Sees every station of a cell as it is evaluated.
pub trait Probe<T> {
    /// Whether samples are wanted.
    const ACTIVE: bool;
    /// Takes a sample.
    fn take(&mut self, sample: Sample<T>);
}

/// Wants no samples.
#[derive(Debug)]
pub struct NoProbe;

impl<T> Probe<T> for NoProbe {
    const ACTIVE: bool = false;
    fn take(&mut self, _sample: Sample<T>) {}
}

/// Hands samples to a closure.
pub struct Sampler<'a, T>(pub &'a mut dyn FnMut(Sample<T>));

impl<T> Probe<T> for Sampler<'_, T> {
    const ACTIVE: bool = true;
    fn take(&mut self, sample: Sample<T>) {
        (self.0)(sample);
    }
}

/// What flanks do to an element, per ring length.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlankLoads<T> {
    /// Outward, at the ring centre line, N/m.
    pub radial: T,
    /// Along e_t, at the pitch line, N/m.
    pub around: T,
    /// On the pulley, N.
    pub torque: T,
    /// Axial force on the sheave, N/m.
    pub axial: T,
    /// Normal force, N/m.
    pub normal: T,
    /// Power of friction, W/m.
    pub loss: T,
    /// Power of damping, W/m.
    pub viscous: T,
}

impl<T: Real> FlankLoads<T> {
    #[inline(always)]
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            radial: self.radial + other.radial,
            around: self.around + other.around,
            torque: self.torque + other.torque,
            axial: self.axial + other.axial,
            normal: self.normal + other.normal,
            loss: self.loss + other.loss,
            viscous: self.viscous + other.viscous,
        }
    }
}

/// Loads of both flanks of an element, per dξ.
struct BothFlanks<T> {
    /// Their sum.
    loads: FlankLoads<T>,
    /// Axial load on the movable sheave, N/m.
    on_movable: T,
    /// How far the element is off the middle, towards the movable sheave, m.
    offset: T,
    /// Lateral load on the ring along z, N/m.
    lateral: T,
}

/// How a point of the belt stands to its pulley, and how its flanks move on the sheaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach<T: Real> {
    /// Unit vector from the axis.
    pub e_r: Vector2<T>,
    /// Unit vector around it, clockwise.
    pub e_t: Vector2<T>,
    /// One by the distance of the ring from the axis, 1/m.
    pub inverse_distance: T,
    /// ϱ, m.
    pub rho: T,
    /// ∂w/∂ϱ, elastic opening of the sheave per radius.
    pub opening: T,
    /// (∂w/∂θ)/ϱ.
    pub opening_slope: T,
    /// v_e·e_r, m/s.
    pub v_r: T,
    /// v_p·e_t, m/s.
    pub v_around: T,
    /// Motion of a flank in the middle of the pulley.
    pub flank: FlankMotion<T>,
}

impl<T: Real> Approach<T> {
    /// At a point of the ring, whose elements move with v_e at the ring centre line and with v_p at the pitch line.
    #[inline(always)]
    pub fn new<const D: usize>(
        law: &CellLaw,
        axis: T::Constant,
        pulley: &PulleyMotion<T>,
        point: &RingPoint<T, D>,
        [v_e, v_p]: [&SVector<T, D>; 2],
    ) -> Self {
        let [sin_beta, cos_beta, tan_beta] = law.wedge;
        let arm = in_plane(&point.r) - Vector2::new(T::constant(axis), T::zero());
        let (distance, inverse_distance) = arm.dot(&arm).root_and_inverse();
        let e_r = arm * inverse_distance;
        let e_t = Vector2::new(e_r.y, -e_r.x);
        let rho = distance - law.parameters.belt.pitch_offset;
        let opening = pulley.psi[0] * e_r.x - pulley.psi[1] * e_r.y;
        let opening_rate = (pulley.psi_dot[0] * e_r.x - pulley.psi_dot[1] * e_r.y) * rho;
        let opening_slope = pulley.psi[0] * e_r.y + pulley.psi[1] * e_r.x;
        let (v_r, v_around) = (in_plane(v_e).dot(&e_r), in_plane(v_p).dot(&e_t));
        let surface = pulley.z_dot * 0.5 - opening_rate;
        let closing_surface = surface - pulley.omega * rho * opening_slope;
        Self {
            e_r,
            e_t,
            inverse_distance,
            rho,
            opening,
            opening_slope,
            v_r,
            v_around,
            flank: FlankMotion {
                penetration: pulley.z * 0.5 - (rho - law.r0) * tan_beta - opening * rho,
                closing: surface - (opening + tan_beta) * v_r - opening_slope * v_around,
                tangential: v_around - pulley.omega * rho,
                along_flank: v_r * cos_beta + closing_surface * sin_beta,
            },
        }
    }

    /// Loads of the two flanks of an element whose ring moves with v_e. In the plane they are alike; in space the
    /// element may be off the middle. `plane` is that of [`Place::plane`].
    #[inline(always)]
    fn both_flanks<const D: usize>(
        &self,
        law: &CellLaw,
        [side, middle]: [T::Constant; 2],
        pulley: &PulleyMotion<T>,
        point: &RingPoint<T, D>,
        v_e: &SVector<T, D>,
        lambda: T,
    ) -> BothFlanks<T> {
        let p = &law.parameters;
        let one = |flank: &FlankMotion<T>| {
            let force = flank_force(&p.contact, &p.friction, law.wedge[1], flank);
            self.loads(law, lambda, flank, &force)
        };
        if D == 2 {
            let flank = one(&self.flank);
            return BothFlanks {
                loads: flank.plus(&flank),
                on_movable: flank.axial,
                offset: T::zero(),
                lateral: T::zero(),
            };
        }
        let offset = (point.r[D - 1] - T::constant(middle)) * side + pulley.z * 0.5;
        let speed = v_e[D - 1] * side + pulley.z_dot * 0.5;
        let movable = one(&self.flank.shifted(offset, speed, law.wedge[0]));
        let fixed = one(&self.flank.shifted(-offset, -speed, law.wedge[0]));
        BothFlanks {
            loads: movable.plus(&fixed),
            on_movable: movable.axial,
            offset,
            lateral: (movable.axial - fixed.axial) * side,
        }
    }

    /// Loads of a flank that moves like this under `force`.
    #[inline(always)]
    pub fn loads(&self, law: &CellLaw, lambda: T, flank: &FlankMotion<T>, force: &FlankForce<T>) -> FlankLoads<T> {
        let [sin_beta, cos_beta, tan_beta] = law.wedge;
        let axial_normal = force.normal * cos_beta * lambda;
        let axial_friction = force.along_flank * lambda * sin_beta;
        FlankLoads {
            radial: axial_normal * (self.opening + tan_beta) + force.along_flank * lambda * cos_beta,
            around: axial_normal * self.opening_slope + force.tangential * lambda,
            torque: -(force.tangential * lambda + axial_friction * self.opening_slope) * self.rho,
            axial: axial_normal - axial_friction,
            normal: force.normal * lambda,
            loss: lambda * (force.tangential * flank.tangential + force.along_flank * flank.along_flank) * -1.0,
            viscous: force.viscous * cos_beta * lambda * flank.closing,
        }
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
