//! The state of a cell and of its stations, for its balance and the derivatives of the balance.

use crate::ring::kinematics::{LineLoad, RingPoint, WithRate, in_plane};
use crate::scalar::Real;
use crate::stack::{Acceleration, Push, StackPoint, push_force};
use crate::variator::law::arguments::{CellInput, CellLaw, between};
use crate::variator::law::element_rotation::{rotation_drag, throughput};
use crate::variator::law::flanks::{BeltPoint, BothFlanks, FlankKinematics, LineForces};
use crate::variator::law::ring_friction::{layer_drag, pressing, ring_friction};
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::CellRing;

/// Ring and stack at a station, and its quadrature weight.
#[derive(Clone, Copy, Debug)]
pub struct StationState<T: Real, const D: usize> {
    pub ring: RingPoint<T, D>,
    pub stack: StackPoint<T>,
    /// dξ, m.
    pub weight: T,
}

/// The ring at the left face of a cell, ring and stack at its stations, written in place.
#[derive(Clone, Copy, Debug)]
pub struct CellPoints<T: Real, const D: usize> {
    pub face: Option<RingPoint<T, D>>,
    pub stations: [Option<StationState<T, D>>; STATIONS],
}

impl<T: Real, const D: usize> CellPoints<T, D> {
    #[inline(always)]
    #[must_use]
    pub fn empty() -> Self {
        Self {
            face: None,
            stations: [None; STATIONS],
        }
    }

    /// The ring at the left face.
    #[inline(always)]
    pub fn face(&self) -> &RingPoint<T, D> {
        self.face.as_ref().expect("the first point is the face")
    }
}

/// Speed V of the elements where the right face of a cell has the weight `right`. The pins of a
/// chain have that of the ring.
#[inline(always)]
fn element_speed<T: Real, const D: usize>(
    given: &CellInput<'_, T>,
    ring: &RingPoint<T, D>,
    right: T::Constant,
) -> T {
    if given.law.is_pull_chain() {
        ring.t.dot(&ring.r_dot) + ring.w * ring.stretch
    } else {
        between(&given.motion.speed, right)
    }
}

/// The stack at the left face of a cell.
#[inline(always)]
pub fn stack_at_face<T: Real, const D: usize>(
    given: &CellInput<'_, T>,
    face: &RingPoint<T, D>,
) -> StackPoint<T> {
    let theta_dot = given.motion.reference.theta.rate;
    let speed = element_speed(given, face, given.geometry.face.right);
    StackPoint::new(given.law.stack.pitch_offset, face, theta_dot, speed)
}

/// Arguments of the laws of a cell's stack.
#[derive(Clone, Copy, Debug)]
pub struct CellState<T: Real> {
    /// Reciprocals of the lengths of pitch line and cell, 1/m.
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
    /// Throughput of elements, m/s.
    pub throughput: T,
}

impl<T: Real> CellState<T> {
    /// The state of a cell with this `ring`; fills `points`. One loop evaluates all points, so its
    /// code is inlined once.
    #[inline(always)]
    pub fn new<R: CellRing<T, D>, const D: usize>(
        given: &CellInput<'_, T>,
        ring: &R,
        points: &mut CellPoints<T, D>,
    ) -> Self {
        let CellInput {
            law, geometry, motion, ..
        } = *given;
        let e = law.stack.pitch_offset;
        let theta_dot = motion.reference.theta.rate;
        let length = geometry.length.v;
        let (mut pitch_length, mut by_normal_motion, mut through, mut steepness) =
            (T::zero(), T::zero(), T::zero(), T::zero());
        for at in 0..=geometry.stations.len() {
            let point = ring.point(at);
            let Some(i) = at.checked_sub(1) else {
                points.face = Some(point);
                continue;
            };
            let station = &geometry.stations[i];
            let speed = element_speed(given, &point, station.right);
            let stack = StackPoint::new(e, &point, theta_dot, speed);
            let weight = length * station.weight;
            pitch_length += weight * stack.lambda;
            for k in 0..D - 1 {
                by_normal_motion += weight * stack.curvature[k] * stack.normal_speed[k];
            }
            through += weight * stack.flow;
            steepness += weight * point.strain_gradient;
            points.stations[i] = Some(StationState {
                ring: point,
                stack,
                weight,
            });
        }
        let inverse_pitch_length = pitch_length.recip();
        let difference = motion.speed[1] - motion.speed[0];
        let cell_length: T = geometry
            .stations
            .iter()
            .fold(T::zero(), |sum, s| sum + length * s.weight);
        let inverse_length = cell_length.recip();
        // The gradient of the strain is its mean over the cell (see `ring/ale.rs`).
        let strain_gradient = steepness * inverse_length;
        for station in points.stations.iter_mut().flatten() {
            station.ring.strain_gradient = strain_gradient;
        }
        // The pins of a chain are on it as they were mounted: one per dξ.
        let content = if law.is_pull_chain() {
            cell_length
        } else {
            motion.content
        };
        let density = content * inverse_pitch_length;
        let flow = through * inverse_length;
        Self {
            inverse_pitch_length,
            inverse_length,
            density,
            difference,
            lengthening: difference - by_normal_motion,
            flow,
            throughput: throughput(density, flow),
        }
    }

    /// ν and its material rate.
    #[inline(always)]
    pub fn density_with_rate(&self) -> WithRate<T> {
        WithRate {
            value: self.density,
            rate: -(self.density * self.lengthening * self.inverse_pitch_length),
        }
    }

    /// Push force in the cell.
    #[inline(always)]
    pub fn push(&self, law: &CellLaw) -> Push<T> {
        if law.is_pull_chain() {
            return Push::none();
        }
        push_force(&law.stack, self.density_with_rate())
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
    /// Own load and tension, N, of the ring.
    pub own_load: LineLoad<T, D>,
    pub tension: T,
    /// Mass of the elements per dξ, kg/m, and their acceleration.
    pub mass: T,
    pub acceleration: Acceleration<T>,
    pub belt: BeltPoint<T, D>,
    pub kinematics: FlankKinematics<T>,
    pub flanks: BothFlanks<T>,
    /// Forces of the flanks, and those which act on V: of a pushbelt without the elastic normal
    /// forces, which act on it by way of their energy.
    pub of_flanks: LineForces<T, D>,
    pub on_speed: LineForces<T, D>,
    /// Forces along the normals, inwards, N/m: the contact force of the ring on the elements.
    pub inward: [T; 2],
    /// T − m_r ṡ², N, sliding speed of the ring on the elements, m/s, and its friction, N/m.
    pub pressing: T,
    pub sliding: T,
    pub ring_friction: T,
    /// λ₁/λ: length along the innermost layer per length along the pitch line.
    pub saddle_lead: T,
    /// Speed of the ring along itself, m/s, and drag of its layers, N/m.
    pub ring_speed: T,
    pub layer_drag: T,
    /// Drag of elements that start and stop turning, N/m.
    pub rotation_drag: T,
}

impl<T: Real, const D: usize> StationForces<T, D> {
    /// Forces at station `i` of a cell under the push force `push`, N.
    #[inline(always)]
    pub fn new<R: CellRing<T, D>>(
        given: &CellInput<'_, T>,
        cell: &CellState<T>,
        i: usize,
        station: &StationState<T, D>,
        ring: &R,
        push: T,
    ) -> Self {
        let CellInput {
            law,
            friction,
            geometry,
            motion,
        } = *given;
        let StationState {
            ring: point, stack, ..
        } = station;
        let mut own_load = LineLoad::zero();
        let tension = ring.own_load(i + 1, point, &mut own_load);
        let speed_dot = between(&motion.speed_dot, geometry.stations[i].right);
        let mass = cell.density * stack.lambda * law.stack.mass_per_length;
        let acceleration = stack.acceleration(point, speed_dot, cell.speed_gradient());

        let belt = BeltPoint {
            r: point.r,
            v_e: stack.velocity(point, stack.ring_line_speed()),
            v_p: stack.velocity(point, stack.speed),
        };
        let kinematics = FlankKinematics::new(law, geometry.axis, &motion.pulley, &belt);
        let flanks = kinematics.both_flanks(given, &belt, stack.lambda);
        let of_flanks = flanks.sum.forces(&kinematics);
        let on_speed = if law.is_pull_chain() {
            of_flanks
        } else {
            let elastic = flanks
                .forces
                .map(|force| force.elastic() * stack.lambda * law.wedge.cos);
            of_flanks - kinematics.normal_forces(law, elastic, geometry.plane.side)
        };
        let mut inward = [T::zero(); 2];
        for (k, inward) in inward.iter_mut().enumerate().take(D - 1) {
            let normal = &point.normals[k];
            *inward = mass * acceleration.across[k] + push * stack.curvature[k] + of_flanks.along(normal);
        }

        let pressing = pressing(law.saddle_mass, tension, motion.reference.s_dot);
        let ring_speed = point.t.dot(&point.r_dot) + point.w * point.stretch;
        let kappa = point.reference.kappa;
        let saddle_lead = stack.curvature[0] * stack.inverse_lambda * law.saddle_offset + 1.0;
        let sliding = ring_speed - stack.speed * saddle_lead;
        let ring_friction = ring_friction(friction, inward[0], sliding);
        Self {
            own_load,
            tension,
            mass,
            acceleration,
            belt,
            kinematics,
            flanks,
            of_flanks,
            on_speed,
            inward,
            pressing,
            sliding,
            ring_friction,
            saddle_lead,
            ring_speed,
            layer_drag: layer_drag(geometry.layer_drag, pressing, kappa, ring_speed),
            rotation_drag: rotation_drag(geometry.rotation_drag, kappa, cell.throughput, stack.speed),
        }
    }

    /// Inertia less forces along the belt, conjugate to V, N/m.
    #[inline(always)]
    pub fn along(&self, point: &RingPoint<T, D>, stack: &StackPoint<T>) -> T {
        self.mass * self.acceleration.along
            + self.on_speed.pitch.dot(&in_plane(&point.t))
            + self.on_speed.ring.dot(&point.t) * stack.lead
            - self.ring_friction * self.saddle_lead
            + self.rotation_drag
    }
}
