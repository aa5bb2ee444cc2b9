//! One cell of the belt: ring, chain and contact meet in one virtual-power statement.
//!
//! δP = ∫ [ring inertia·δv + δV_elastic] + ∫ m_e νλ a_e·δv_p − Q·δ(lengthening) − ∫ 2λ (contact force)·δ(its own point)
//!    − ∫ f_r δ(sliding of ring on elements) = 0.
//!
//! Each force enters with the velocity Jacobian of its own point: tangential flank forces at the pitch line (v_p),
//! radial ones at the ring centre line (v_e, with its flow c), ring friction on the difference of the two flows, the
//! push force on the shortening of the stack. So no power is lost between ring, chain and pulleys.

use super::mesh::Station;
use super::parameters::Parameters;
use super::ring::{Action, CellRing};
use crate::chain::{self, ChainPoint, collision_force, push_force};
use crate::contact::{self, FlankMotion, flank_force};
use crate::reference_curve::{Jet, ReferencePoint};
use crate::ring::kinematics::{Load, ReferenceMotion};
use crate::scalar::{Lanes, Real, smooth_plus};
use nalgebra::Vector2;

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
    /// J at the left face, m/s.
    pub flow: T,
    /// ν.
    pub density: T,
}

/// What a station tells: values for outputs, losses and energies; of one cell, or of one in each lane of `L`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample<L = f64> {
    /// ξ, m.
    pub xi: L,
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
    /// Penetration, m.
    pub penetration: L,
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

impl Sample<Lanes> {
    /// The sample of the cell in a lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, lane: usize) -> Sample {
        let of = |x: Lanes| x.to_array()[lane];
        Sample {
            r: self.r.map(of),
            xi: of(self.xi),
            weight: of(self.weight),
            pitch_radius: of(self.pitch_radius),
            face_radius: of(self.face_radius),
            lambda: of(self.lambda),
            density: of(self.density),
            push: of(self.push),
            tension: of(self.tension),
            normal: of(self.normal),
            axial: of(self.axial),
            torque: of(self.torque),
            sliding: of(self.sliding),
            penetration: of(self.penetration),
            flow: of(self.flow),
            speed: of(self.speed),
            sheave_loss: of(self.sheave_loss),
            ring_loss: of(self.ring_loss),
            damping_loss: of(self.damping_loss),
            kinetic: of(self.kinetic),
            ring_elastic: of(self.ring_elastic),
            outward: of(self.outward),
        }
    }
}

impl Sample {
    /// Elastic energy of ring, stack and flanks, J/m.
    #[must_use]
    pub fn elastic(&self, law: &CellLaw) -> f64 {
        let p = &law.parameters;
        let stack = chain::energy_density(&p.belt, self.density);
        let flanks = contact::energy_density(&p.contact, law.wedge[1], self.penetration);
        self.ring_elastic + self.lambda * (stack + flanks)
    }
}

/// Where cells lie: constants of the mesh, and the element at the present Θ.
#[derive(Debug)]
pub struct Place<'a, T: Real> {
    /// Left face.
    pub face: &'a Station<T::Constant>,
    /// Quadrature points.
    pub stations: &'a [Station<T::Constant>],
    /// Pulley axis, x coordinate, m.
    pub axis: T::Constant,
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
#[derive(Debug)]
pub struct Sampler<F>(pub F);

impl<T, F: FnMut(Sample<T>)> Probe<T> for Sampler<F> {
    const ACTIVE: bool = true;
    fn take(&mut self, sample: Sample<T>) {
        (self.0)(sample);
    }
}

/// Linear between the two faces of a cell.
#[inline(always)]
pub(super) fn between<T: Real>(faces: &[T; 2], right: T::Constant) -> T {
    faces[0] * (-right + 1.0) + faces[1] * right
}

/// The balance of a cell, or of one in each lane of `T`, on whatever `ring` it has. `reference` gives the reference curve
/// at the face (0) and at the stations (1 and on); `probe` sees every station.
#[inline(always)]
pub fn balance<T: Real, R: CellRing<T>, S: Probe<T>>(
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
    let [sin_beta, cos_beta, tan_beta] = law.wedge;
    let theta_dot = motion.reference.theta.rate;

    // Cell: length of the pitch line, density, shortening.
    let mut points = [None; 3];
    let mut pitch_length = T::zero();
    let mut carried = T::zero();
    let mut through = T::zero();
    for (i, (slot, station)) in points.iter_mut().zip(place.stations).enumerate() {
        let point = ring.point(i + 1, reference(i + 1));
        let speed = between(&motion.speed, station.right);
        let chain = ChainPoint::new(e, &point, theta_dot, speed);
        let weight = length.v * station.weight;
        pitch_length += weight * chain.lambda;
        carried += weight * chain.curvature * chain.normal_speed;
        through += weight * chain.flow;
        *slot = Some((point, chain, weight));
    }
    let density = motion.amount / pitch_length;
    let lengthening = motion.speed[1] - motion.speed[0] - carried;
    let push = push_force(&p.belt, density, -(density * lengthening) / pitch_length);
    let cell_length: T = place
        .stations
        .iter()
        .fold(T::zero(), |sum, s| sum + length.v * s.weight);
    let difference = motion.speed[1] - motion.speed[0];
    let collision = collision_force(&p.belt, density, through / cell_length, difference);

    let face = ring.point(0, reference(0));
    let mut out = CellBalance {
        speed: [push.force - collision, collision - push.force],
        axial: T::zero(),
        tilting: [T::zero(); 2],
        torque: T::zero(),
        flow: ChainPoint::new(e, &face, theta_dot, motion.speed[0]).flow,
        density,
    };
    let speed_gradient = difference / cell_length;
    let pulley = &motion.pulley;

    for (i, (found, station)) in points.iter().zip(place.stations).enumerate() {
        let Some((point, chain, weight)) = found else { continue };
        let slot = i + 1;
        let (weight, right) = (*weight, station.right);
        let mut point_load = Load::zero();
        // Conjugates of δV at the pitch line and of δc, per dξ.
        let mut along = T::zero();
        let mut flow = T::zero();

        // Ring.
        let tension = ring.own_load(slot, point, &mut point_load);
        let ring_along = point_load.position.dot(&point.t);

        // Elements: inertia and push force.
        let speed_dot = between(&motion.speed_dot, right);
        let mass = density * chain.lambda * p.belt.mass_per_length;
        let (a_t, a_n) = chain.acceleration(point, speed_dot, speed_gradient);
        along += mass * a_t;
        let inward = mass * a_n + push.force * chain.curvature;

        // Contact.
        let arm = point.r - Vector2::new(T::constant(place.axis), T::zero());
        let distance = arm.dot(&arm).sqrt();
        let e_r = arm * distance.recip();
        let e_t = Vector2::new(e_r.y, -e_r.x);
        let rho = distance - e;
        let opening = pulley.psi[0] * e_r.x - pulley.psi[1] * e_r.y;
        let opening_rate = (pulley.psi_dot[0] * e_r.x - pulley.psi_dot[1] * e_r.y) * rho;
        let opening_slope = pulley.psi[0] * e_r.y + pulley.psi[1] * e_r.x;
        let v_e = chain.ring_line_velocity(point);
        let v_p = chain.pitch_velocity(point);
        let (v_r, v_around) = (v_e.dot(&e_r), v_p.dot(&e_t));
        let surface = pulley.z_dot * 0.5 - opening_rate;
        let closing_surface = surface - pulley.omega * rho * opening_slope;
        let flank = FlankMotion {
            penetration: pulley.z * 0.5 - (rho - law.r0) * tan_beta - opening * rho,
            closing: surface - (opening + tan_beta) * v_r - opening_slope * v_around,
            tangential: v_around - pulley.omega * rho,
            along_flank: v_r * cos_beta + closing_surface * sin_beta,
        };
        let force = flank_force(&p.contact, &p.friction, cos_beta, &flank);
        let lambda = chain.lambda;
        let axial_normal = force.normal * cos_beta * lambda;
        let radial = (axial_normal * (opening + tan_beta) + force.along_flank * lambda * cos_beta) * 2.0;
        let around = (axial_normal * opening_slope + force.tangential * lambda) * 2.0;
        let axial_friction = force.along_flank * lambda * sin_beta;
        let axial = axial_normal - axial_friction;
        let push_out = e_r * radial;
        let drag = e_t * around;
        point_load.position -= push_out;
        flow -= push_out.dot(&point.slope);
        along -= drag.dot(&point.t);
        let inward = inward - drag.dot(&point.n);
        point_load.position += point.n * inward;
        out.axial += axial * weight;
        out.tilting[0] += axial * rho * e_r.x * weight;
        out.tilting[1] -= axial * rho * e_r.y * weight;
        let torque = -(force.tangential * lambda + axial_friction * opening_slope) * rho * 2.0;
        out.torque += torque * weight;

        // Ring on elements.
        let (ring_load, _) = smooth_plus(
            tension - motion.reference.s_dot * motion.reference.s_dot * p.ring.mass_per_length,
            RING_LOAD_SMOOTHING,
        );
        let sliding = (point.w - chain.c) * point.stretch;
        let v0 = p.friction.velocity;
        let ring_friction =
            ring_load * point.reference.kappa * p.friction.ring * sliding / (sliding * sliding + v0 * v0).sqrt();
        point_load.drift += ring_friction * point.stretch;
        flow -= ring_friction * point.stretch;

        // δc = (δV − t̂·δr + e χ_Θ δΘ)/λ.
        let carried = flow / lambda;
        along += carried;
        let across = point_load.position.dot(&point.n);
        point_load.position -= point.t * carried;
        point_load.theta += carried * point.reference.chi_theta * e;
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
            let stack = (collision * difference - push.viscous * lengthening) / cell_length;
            let flanks = force.viscous * cos_beta * lambda * flank.closing * 2.0;
            let from_axis = face.r - Vector2::new(T::constant(place.axis), T::zero());
            probe.take(Sample {
                xi: point.reference.xi.v,
                weight,
                r: [point.r.x, point.r.y],
                pitch_radius: rho,
                face_radius: from_axis.dot(&from_axis).sqrt() - e,
                lambda,
                density,
                push: push.force,
                tension,
                normal: force.normal * lambda,
                axial,
                torque,
                sliding: flank.tangential,
                penetration: flank.penetration,
                flow: chain.flow,
                speed: chain.speed,
                sheave_loss: lambda
                    * (force.tangential * flank.tangential + force.along_flank * flank.along_flank)
                    * -2.0,
                ring_loss: ring_friction * sliding,
                damping_loss: of_ring.viscous + stack + flanks,
                kinetic: of_ring.kinetic + mass * v_p.dot(&v_p) * 0.5,
                ring_elastic: of_ring.elastic,
                outward: -((point.r - point.reference.r).dot(&point.reference.n)),
            });
        }
    }
    out
}
