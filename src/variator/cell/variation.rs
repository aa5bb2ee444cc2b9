//! The derivatives of [`balance`](crate::variator::cell::balance::balance) by hand, in every direction that leaves the reference curve
//! where it is.
//!
//! Forward differentiation repeats the whole law for each direction, though a node moves only the ring, a sheave only
//! the flanks, and nearly everything is linear between them. Here each station keeps what its variation is linear in;
//! laws that are not linear (flanks, stack) are differentiated forward, in their few arguments. Less than half the
//! time, to the same digits (a test of [`super::system`] holds both against each other). Θ moves everything and stays
//! with forward differentiation.

use crate::chain::{ChainPoint, ChainVariation, Stack, Transport, Turn};
use crate::contact::{FlankForce, FlankMotion, Friction, flank_force};
use crate::reference_curve::ReferencePoint;
use crate::ring::kinematics::{Load, RingPoint, RingVariation, embed, in_plane};
use crate::scalar::{Lanes, Real, Tangent, zero_vector};
use crate::variator::cell::directions::Direction;
use crate::variator::cell::flanks::{Approach, FlankLoads};
use crate::variator::cell::place::{CellBalance, CellLaw, CellMotion, Place, between, share};
use crate::variator::cell::ring::{Action, RingForces, VaryingRing};
use crate::variator::cell::ring_friction::{pressing, ring_friction};
use crate::variator::mesh::belt_mesh::STATIONS;
use nalgebra::SVector;
use num_traits::Zero;

/// Forces of a flank with their derivatives with respect to its motion.
#[derive(Clone, Copy, Debug)]
struct Flank {
    force: FlankForce<Lanes>,
    /// Of normal force, friction around and along the flank: by penetration, closing, sliding around and along.
    slopes: [[Lanes; 4]; 3],
}

impl Flank {
    #[inline(always)]
    fn new(law: &CellLaw, friction: &Friction, motion: &FlankMotion<Lanes>) -> Self {
        let seeded = FlankMotion {
            penetration: Tangent::<4>::seed(motion.penetration, 0, 1.0),
            closing: Tangent::seed(motion.closing, 1, 1.0),
            tangential: Tangent::seed(motion.tangential, 2, 1.0),
            along_flank: Tangent::seed(motion.along_flank, 3, 1.0),
        };
        let force = flank_force(&law.contact, friction, law.wedge[1], &seeded);
        Self {
            force: FlankForce {
                normal: force.normal.re,
                viscous: force.viscous.re,
                tangential: force.tangential.re,
                along_flank: force.along_flank.re,
            },
            slopes: [force.normal.eps, force.tangential.eps, force.along_flank.eps],
        }
    }

    /// How its loads vary with its motion, with λ and with how it stands to the pulley.
    #[inline(always)]
    fn vary(
        &self,
        law: &CellLaw,
        at: &Approach<Lanes>,
        lambda: Lanes,
        by: &FlankVariation,
        motion: &FlankMotion<Lanes>,
    ) -> FlankLoads<Lanes> {
        let [sin_beta, cos_beta, tan_beta] = law.wedge;
        let of = |slopes: &[Lanes; 4]| {
            slopes[0] * motion.penetration
                + slopes[1] * motion.closing
                + slopes[2] * motion.tangential
                + slopes[3] * motion.along_flank
        };
        let [normal, tangential, along_flank] = [0, 1, 2].map(|k| of(&self.slopes[k]));
        let force = &self.force;
        // Per ring length: forces times λ.
        let normal_by = normal * lambda + force.normal * by.lambda;
        let tangential_by = tangential * lambda + force.tangential * by.lambda;
        let along_by = along_flank * lambda + force.along_flank * by.lambda;
        let (axial_normal, axial_normal_by) = (force.normal * lambda * cos_beta, normal_by * cos_beta);
        let axial_friction = force.along_flank * lambda * sin_beta;
        let axial_friction_by = along_by * sin_beta;
        let around = force.tangential * lambda + axial_friction * at.opening_slope;
        let around_by = tangential_by + axial_friction_by * at.opening_slope + axial_friction * by.opening_slope;
        let zero = Lanes::zero();
        FlankLoads {
            radial: axial_normal_by * (at.opening + tan_beta) + axial_normal * by.opening + along_by * cos_beta,
            around: axial_normal_by * at.opening_slope + axial_normal * by.opening_slope + tangential_by,
            torque: -(around_by * at.rho + around * by.rho),
            axial: axial_normal_by - axial_friction_by,
            normal: zero,
            loss: zero,
            viscous: zero,
        }
    }
}

/// How a point stands to its pulley, and how its flanks move, otherwise: the derivatives of an [`Approach`].
#[derive(Clone, Copy, Debug)]
struct FlankVariation {
    motion: FlankMotion<Lanes>,
    lambda: Lanes,
    rho: Lanes,
    opening: Lanes,
    opening_slope: Lanes,
    /// Angle by which e_r turns towards e_t.
    turn: Lanes,
    /// In space: offset from the middle, and its rate.
    offset: [Lanes; 2],
}

impl FlankVariation {
    /// None but that λ varies.
    #[inline(always)]
    fn of_lambda(lambda: Lanes) -> Self {
        let zero = Lanes::zero();
        Self {
            motion: FlankMotion {
                penetration: zero,
                closing: zero,
                tangential: zero,
                along_flank: zero,
            },
            lambda,
            rho: zero,
            opening: zero,
            opening_slope: zero,
            turn: zero,
            offset: [zero; 2],
        }
    }
}

/// A station, and what its loads are linear in.
#[derive(Clone, Copy, Debug)]
struct Point<const D: usize> {
    ring: RingPoint<Lanes, D>,
    chain: ChainPoint<Lanes, D>,
    turn: Turn<Lanes>,
    weight: Lanes,
    right: Lanes,
    own_load: Load<Lanes, D>,
    /// Mass of the elements per dξ, kg/m, their a·t̂ and a along the normals, m/s².
    mass: Lanes,
    acceleration: (Lanes, [Lanes; 2]),
    /// v_e·e_t and v_p·e_r, m/s.
    crosswise: [Lanes; 2],
    approach: Approach<Lanes>,
    /// On the movable sheave; in space also on the other.
    flanks: [Flank; 2],
    /// Of both.
    loads: FlankLoads<Lanes>,
    /// What they do at the ring centre line, N/m.
    at_ring_line: SVector<Lanes, D>,
    /// Forces along the normals, inwards.
    inward: [Lanes; 2],
    /// Ring friction, its derivatives by the load's argument T − m_r ṡ² and by the sliding speed.
    friction: [Lanes; 3],
    /// Conjugate of v_e·t̂: flanks and ring friction, N/m.
    tangential: Lanes,
}

/// A pack of cells, and what its balance is linear in.
#[derive(Debug)]
pub(crate) struct Linearised<'a, R, const D: usize> {
    law: &'a CellLaw,
    friction: &'a Friction,
    place: &'a Place<'a, Lanes>,
    motion: &'a CellMotion<Lanes>,
    ring: &'a R,
    points: [Option<Point<D>>; STATIONS],
    face: (RingPoint<Lanes, D>, ChainPoint<Lanes, D>),
    inverse_pitch_length: Lanes,
    inverse_length: Lanes,
    density: Lanes,
    lengthening: Lanes,
    push: Lanes,
    /// Push force, collision force and lag: by density, its rate, flow and difference of V.
    stack: [[Lanes; 4]; 3],
    slopes: [f64; 2],
}

impl<'a, R: VaryingRing<Lanes, D>, const D: usize> Linearised<'a, R, D> {
    /// Of cells whose `ring`, if it moves, has taken the loads of [`balance`](crate::variator::cell::balance) at the same motion;
    /// `slopes` are the factors of acceleration and position.
    #[inline(always)]
    pub fn new(
        law: &'a CellLaw,
        friction: &'a Friction,
        place: &'a Place<'a, Lanes>,
        motion: &'a CellMotion<Lanes>,
        ring: &'a R,
        reference: impl Fn(usize) -> ReferencePoint<Lanes>,
        slopes: [f64; 2],
    ) -> Self {
        let e = law.chain.pitch_offset;
        let theta_dot = motion.reference.theta.rate;
        let length = place.length.v;
        let chain_at = |slot: usize, speed: Lanes| {
            let ring = ring.point(slot, reference(slot));
            (ring, ChainPoint::new(e, &ring, theta_dot, speed))
        };
        let zero = Lanes::zero();
        let (mut pitch_length, mut carried, mut through, mut cell_length) = (zero, zero, zero, zero);
        let mut steepness = zero;
        let mut seen = [None; STATIONS];
        for (i, (seen, station)) in seen.iter_mut().zip(place.stations).enumerate() {
            let speed = between(&motion.speed, station.right);
            let (point, chain) = chain_at(i + 1, speed);
            let weight = length * station.weight;
            pitch_length += weight * chain.lambda;
            for k in 0..D - 1 {
                carried += weight * chain.curvature[k] * chain.normal_speed[k];
            }
            through += weight * chain.flow;
            cell_length += weight;
            steepness += weight * point.strain_gradient;
            *seen = Some((point, chain, weight));
        }
        let difference = motion.speed[1] - motion.speed[0];
        let density = motion.amount / pitch_length;
        let lengthening = difference - carried;
        let (inverse_pitch_length, inverse_length) = (pitch_length.recip(), cell_length.recip());
        let arguments = [
            density,
            -(density * lengthening * inverse_pitch_length),
            through * inverse_length,
            difference,
        ];
        let Stack { push, collision, lag } = Stack::new(
            &law.chain,
            std::array::from_fn(|k| Tangent::<4>::seed(arguments[k], k, 1.0)),
        );
        let mut this = Self {
            law,
            friction,
            place,
            motion,
            ring,
            points: [None; STATIONS],
            face: chain_at(0, motion.speed[0]),
            inverse_pitch_length,
            inverse_length,
            density,
            lengthening,
            push: push.force.re,
            stack: [
                push.force.eps,
                collision.eps,
                if law.has_lag { lag.eps } else { [zero; 4] },
            ],
            slopes,
        };
        for (i, mut seen) in seen.into_iter().enumerate() {
            if let Some((point, ..)) = &mut seen {
                point.strain_gradient = steepness * inverse_length;
            }
            this.points[i] = seen.map(|seen| this.point(i, seen));
        }
        this
    }

    #[inline(always)]
    fn point(&self, i: usize, (ring, chain, weight): (RingPoint<Lanes, D>, ChainPoint<Lanes, D>, Lanes)) -> Point<D> {
        let (law, pulley) = (self.law, &self.motion.pulley);
        let right = self.place.stations[i].right;
        let mut own_load = Load::zero();
        let tension = self.ring.own_load(i + 1, &ring, &mut own_load);
        let speed_dot = between(&self.motion.speed_dot, right);
        let difference = self.motion.speed[1] - self.motion.speed[0];
        let acceleration = chain.acceleration(&ring, speed_dot, difference * self.inverse_length);
        let mass = self.density * chain.lambda * law.chain.mass_per_length;
        let v_e = chain.ring_line_velocity(&ring);
        let v_p = chain.pitch_velocity(&ring);
        let approach = Approach::new(law, self.place.axis, pulley, &ring, [&v_e, &v_p]);
        let plane = self.place.plane;
        let (_, motions) = approach.flanks(law, plane, pulley, &ring, &v_e);
        let flanks = motions.map(|motion| Flank::new(law, self.friction, &motion));
        let each = [0, 1].map(|k| approach.loads(law, chain.lambda, &motions[k], &flanks[k].force));
        let loads = each[0].plus(&each[1]);
        let at_pitch_line = approach.e_t * -loads.around;
        let mut at_ring_line: SVector<Lanes, D> = embed(approach.e_r * -loads.radial);
        if D > 2 {
            at_ring_line[D - 1] += (each[0].axial - each[1].axial) * plane[0];
        }
        let mut inward = [Lanes::zero(); 2];
        for (k, inward) in inward.iter_mut().enumerate().take(D - 1) {
            let normal = &chain.normals[k];
            *inward = mass * acceleration.1[k]
                + self.push * chain.curvature[k]
                + at_pitch_line.dot(&in_plane(normal))
                + at_ring_line.dot(normal);
        }
        let friction = self.ring_friction(tension, &ring, &chain);
        Point {
            weight,
            right,
            own_load,
            mass,
            acceleration,
            crosswise: [in_plane(&v_e).dot(&approach.e_t), in_plane(&v_p).dot(&approach.e_r)],
            approach,
            flanks,
            loads,
            at_ring_line,
            inward,
            tangential: at_ring_line.dot(&ring.t) - friction[0],
            friction,
            turn: chain.turn(&ring),
            ring,
            chain,
        }
    }

    /// Ring friction and its derivatives by T − m_r ṡ² and by the sliding speed.
    #[inline(always)]
    fn ring_friction(&self, tension: Lanes, ring: &RingPoint<Lanes, D>, chain: &ChainPoint<Lanes, D>) -> [Lanes; 3] {
        let pressing = pressing(&self.law.ring, tension, self.motion.reference.s_dot);
        let pressing = Tangent::<2>::seed(pressing, 0, 1.0);
        let sliding = ring.t.dot(&ring.r_dot) + ring.w * ring.stretch - chain.ring_line_speed();
        let sliding = Tangent::seed(sliding, 1, 1.0);
        let kappa = Tangent::constant(ring.reference.kappa);
        let friction = ring_friction(self.friction, pressing, kappa, sliding);
        [friction.re, friction.eps[0], friction.eps[1]]
    }

    /// How balance and ring forces vary in a direction.
    #[inline(always)]
    pub fn vary(&self, direction: Direction) -> (CellBalance<Lanes>, RingForces<Lanes, D>) {
        let own = match direction {
            Direction::Ring(own) => Some(own),
            _ => None,
        };
        if matches!(direction, Direction::Sheave | Direction::Tilt(_) | Direction::Shaft) {
            self.pulley_column(direction)
        } else if direction == Direction::Drift || R::MOVES && own.is_some() {
            self.column::<true>(direction, own)
        } else {
            self.column::<false>(direction, own)
        }
    }

    /// In a direction that moves ring (`MOVES`) or chain.
    #[inline(always)]
    fn column<const MOVES: bool>(
        &self,
        direction: Direction,
        own: Option<usize>,
    ) -> (CellBalance<Lanes>, RingForces<Lanes, D>) {
        let zero = Lanes::zero();
        let [alpha, beta] = self.slopes;
        let mut speed = [zero; 2];
        if let Direction::Speed(face) = direction {
            speed[face] = Lanes::from(1.0);
        }
        let at = |slot: usize, ring: &RingPoint<Lanes, D>, chain: &ChainPoint<Lanes, D>, speed| {
            if !MOVES {
                return (RingVariation::none(), ChainVariation::of_speed(chain, speed));
            }
            let by = match own {
                Some(own) => self.ring.vary(slot, ring, own, self.slopes),
                None => RingVariation {
                    w: Lanes::from(1.0),
                    w_dot: Lanes::from(alpha),
                    ..RingVariation::none()
                },
            };
            (by, chain.vary(ring, &by, speed))
        };

        // Cell.
        let (mut pitch_length, mut carried, mut through, mut steepness) = (zero, zero, zero, zero);
        let mut varied = [None; STATIONS];
        for (i, (varied, point)) in varied.iter_mut().zip(&self.points).enumerate() {
            let Some(point) = point else { continue };
            let chain = &point.chain;
            let speed = between(&speed, point.right);
            let (by, chain_by) = at(i + 1, &point.ring, chain, speed);
            pitch_length += point.weight * by.stretch;
            if MOVES {
                for k in 0..D - 1 {
                    carried += point.weight
                        * (chain_by.curvature[k] * chain.normal_speed[k]
                            + chain.curvature[k] * chain_by.normal_speed[k]);
                }
            }
            through += point.weight * chain_by.flow;
            steepness += point.weight * by.strain_gradient;
            *varied = Some((by, chain_by));
        }
        if MOVES {
            for (by, _) in varied.iter_mut().flatten() {
                by.strain_gradient = steepness * self.inverse_length;
            }
        }
        let (ring, chain) = &self.face;
        let (_, face) = at(0, ring, chain, speed[0]);
        let amount = if direction == Direction::Amount {
            Lanes::from(1.0)
        } else {
            zero
        };
        let difference = speed[1] - speed[0];
        let lengthening = difference - carried;
        let inverse = self.inverse_pitch_length;
        let density = (amount - self.density * pitch_length) * inverse;
        let thinning = (self.density * self.lengthening * inverse * pitch_length
            - density * self.lengthening
            - self.density * lengthening)
            * inverse;
        let arguments = [density, thinning, through * self.inverse_length, difference];
        let [push, collision, lag] = [0, 1, 2].map(|k| {
            let slopes = &self.stack[k];
            slopes[0] * arguments[0] + slopes[1] * arguments[1] + slopes[2] * arguments[2] + slopes[3] * arguments[3]
        });
        let mut out = nothing();
        out.speed = [push - collision, collision - push];
        out.transport = Transport {
            flow: face.flow,
            density,
            lag,
        };

        // Stations.
        let gradient = (self.motion.speed[1] - self.motion.speed[0]) * self.inverse_length;
        let mut sum = self.ring.empty();
        for (i, (point, varied)) in self.points.iter().zip(&varied).enumerate() {
            let (Some(point), Some((by, chain_by))) = (point, varied) else {
                continue;
            };
            let (ring, chain) = (&point.ring, &point.chain);
            let mut load = Load::zero();
            let tension = self.ring.vary_own_load(i + 1, ring, by, own, &mut load);
            let mass = (density * chain.lambda + self.density * by.stretch) * self.law.chain.mass_per_length;
            let speed_dot = chain_by.speed * alpha;
            let gradients = [gradient, difference * self.inverse_length];
            let (a_t, a_n) = chain.vary_acceleration(ring, &point.turn, (by, chain_by), speed_dot, gradients);
            let (base_t, base_n) = point.acceleration;
            let mut inward = [zero; 2];
            for k in 0..D - 1 {
                inward[k] = mass * base_n[k]
                    + point.mass * a_n[k]
                    + push * chain.curvature[k]
                    + self.push * chain_by.curvature[k];
            }
            let change = Change {
                by,
                chain: chain_by,
                flank: &self.flank::<MOVES>(point, by, chain_by),
                along: mass * base_t + point.mass * a_t,
                inward,
                tension,
                pressing: if direction == Direction::Drift {
                    tension - self.motion.reference.s_dot * (2.0 * self.law.ring.mass_per_length)
                } else {
                    tension
                },
            };
            self.contact::<MOVES>(i, point, &change, load, &mut out, &mut sum);
        }
        (out, self.ring.varied_forces(&sum, own, beta))
    }

    /// In a direction that moves the pulley only.
    #[inline(always)]
    fn pulley_column(&self, direction: Direction) -> (CellBalance<Lanes>, RingForces<Lanes, D>) {
        let zero = Lanes::zero();
        let [alpha, beta] = self.slopes;
        let [sin_beta, ..] = self.law.wedge;
        let (mut out, mut sum) = (nothing(), self.ring.empty());
        let (by, chain) = (RingVariation::none(), ChainVariation::none());
        for (i, point) in self.points.iter().enumerate() {
            let Some(point) = point else { continue };
            let at = &point.approach;
            let mut flank = FlankVariation::of_lambda(zero);
            let motion = &mut flank.motion;
            match direction {
                Direction::Tilt(axis) => {
                    let [opening, slope] = if axis == 0 {
                        [at.e_r.x, at.e_r.y]
                    } else {
                        [-at.e_r.y, at.e_r.x]
                    };
                    let rate = opening * at.rho * alpha;
                    motion.penetration = -(opening * at.rho);
                    motion.closing = -(rate + opening * at.v_r + slope * at.v_around);
                    motion.along_flank = (rate + self.motion.pulley.omega * at.rho * slope) * -sin_beta;
                    (flank.opening, flank.opening_slope) = (opening, slope);
                }
                Direction::Shaft => {
                    motion.tangential = -at.rho;
                    motion.along_flank = at.rho * at.opening_slope * -sin_beta;
                }
                _ => {
                    motion.penetration = Lanes::from(0.5 * beta);
                    motion.closing = Lanes::from(0.5);
                    motion.along_flank = Lanes::from(0.5 * sin_beta);
                    flank.offset = [0.5 * beta, 0.5].map(Lanes::from);
                }
            }
            let change = Change {
                by: &by,
                chain: &chain,
                flank: &flank,
                along: zero,
                inward: [zero; 2],
                tension: zero,
                pressing: zero,
            };
            self.contact::<false>(i, point, &change, Load::zero(), &mut out, &mut sum);
        }
        (out, self.ring.varied_forces(&sum, None, beta))
    }

    /// How a station stands to its pulley where ring and chain vary.
    #[inline(always)]
    fn flank<const MOVES: bool>(
        &self,
        point: &Point<D>,
        by: &RingVariation<Lanes, D>,
        chain: &ChainVariation<Lanes>,
    ) -> FlankVariation {
        let [sin_beta, cos_beta, tan_beta] = self.law.wedge;
        let (at, pulley) = (&point.approach, &self.motion.pulley);
        let (ring, base) = (&point.ring, &point.chain);
        let mut flank = FlankVariation::of_lambda(by.stretch);
        let mut v_e = ring.t * (chain.speed * base.lead);
        let mut v_p = ring.t * chain.speed;
        if MOVES {
            let r = in_plane(&by.r);
            flank.rho = at.e_r.dot(&r);
            flank.turn = at.e_t.dot(&r) * at.inverse_distance;
            flank.opening = at.opening_slope * flank.turn;
            flank.opening_slope = -(at.opening * flank.turn);
            v_e += ring.t * (base.speed * chain.lead) + by.t * base.ring_line_speed();
            v_p += by.t * base.speed;
            for k in 0..D - 1 {
                let across = by.normals[k] * base.normal_speed[k] + base.normals[k] * chain.normal_speed[k];
                v_e += across;
                v_p += across;
            }
        }
        let v_r = at.e_r.dot(&in_plane(&v_e)) + flank.turn * point.crosswise[0];
        let v_around = at.e_t.dot(&in_plane(&v_p)) - flank.turn * point.crosswise[1];
        let motion = &mut flank.motion;
        motion.closing = -((at.opening + tan_beta) * v_r + at.opening_slope * v_around);
        motion.tangential = v_around;
        motion.along_flank = v_r * cos_beta;
        if MOVES {
            let [rate_x, rate_y] = pulley.psi_dot;
            let rate = (rate_x * at.e_r.y + rate_y * at.e_r.x) * at.rho * flank.turn
                + (rate_x * at.e_r.x - rate_y * at.e_r.y) * flank.rho;
            let sliding = flank.rho * at.opening_slope + at.rho * flank.opening_slope;
            motion.penetration = -(flank.rho * tan_beta + flank.opening * at.rho + at.opening * flank.rho);
            motion.closing -= rate + flank.opening * at.v_r + flank.opening_slope * at.v_around;
            motion.tangential -= pulley.omega * flank.rho;
            motion.along_flank -= (rate + pulley.omega * sliding) * sin_beta;
        }
        if D == 3 {
            let [side, _] = self.place.plane;
            flank.offset = [by.r[D - 1] * side, v_e[D - 1] * side];
        }
        flank
    }

    /// Adds what contact, ring friction and `load` do at a station that changes.
    #[inline(always)]
    fn contact<const MOVES: bool>(
        &self,
        i: usize,
        point: &Point<D>,
        change: &Change<'_, D>,
        mut load: Load<Lanes, D>,
        out: &mut CellBalance<Lanes>,
        sum: &mut R::Sum,
    ) {
        let (ring, chain, at) = (&point.ring, &point.chain, &point.approach);
        let Change { by, flank, .. } = *change;
        let ring_along = load.position.dot(&ring.t);
        let mut at_ring_line: SVector<Lanes, D> = zero_vector();
        let (loads, on_movable) = if D == 2 {
            let one = point.flanks[0].vary(self.law, at, chain.lambda, flank, &flank.motion);
            (one.plus(&one), one.axial)
        } else {
            let [side, _] = self.place.plane;
            let [offset, speed] = flank.offset;
            let [movable, fixed] =
                [1.0, -1.0].map(|sign| flank.motion.shifted(offset * sign, speed * sign, self.law.wedge[0]));
            let movable = point.flanks[0].vary(self.law, at, chain.lambda, flank, &movable);
            let fixed = point.flanks[1].vary(self.law, at, chain.lambda, flank, &fixed);
            at_ring_line[D - 1] += (movable.axial - fixed.axial) * side;
            (movable.plus(&fixed), movable.axial)
        };
        let mut push_out = at.e_r * loads.radial;
        let mut drag = at.e_t * loads.around;
        if MOVES {
            push_out += at.e_t * (flank.turn * point.loads.radial);
            drag -= at.e_r * (flank.turn * point.loads.around);
        }
        at_ring_line -= embed(push_out);
        let mut along = change.along - drag.dot(&in_plane(&ring.t));
        let mut tangential = at_ring_line.dot(&ring.t);
        let base_drag = at.e_t * point.loads.around;
        if MOVES {
            tangential += point.at_ring_line.dot(&by.t);
            along += point.tangential * change.chain.lead - base_drag.dot(&in_plane(&by.t));
        }
        for k in 0..D - 1 {
            let normal = &chain.normals[k];
            let mut inward = change.inward[k] - drag.dot(&in_plane(normal)) + at_ring_line.dot(normal);
            if MOVES {
                inward += point.at_ring_line.dot(&by.normals[k]) - base_drag.dot(&in_plane(&by.normals[k]));
                load.position += by.normals[k] * point.inward[k];
            }
            load.position += normal * inward;
        }
        let weight = point.weight;
        let [axial, base_axial] = [loads.axial * 0.5, point.loads.axial * 0.5];
        let mut moment = at.e_r * (axial * at.rho);
        if MOVES {
            moment += at.e_r * (base_axial * flank.rho) + at.e_t * (base_axial * at.rho * flank.turn);
        }
        out.axial += on_movable * weight;
        out.tilting[0] += moment.x * weight;
        out.tilting[1] -= moment.y * weight;
        out.torque += loads.torque * weight;

        let [friction, by_load, by_sliding] = point.friction;
        let mut sliding = by.w * ring.stretch - change.chain.speed * chain.lead;
        if MOVES {
            sliding += change.chain.along + ring.w * by.stretch - chain.speed * change.chain.lead;
        }
        let friction_by = by_load * change.pressing + by_sliding * sliding;
        let across = load.position.dot(&ring.n);
        load.position += ring.t * friction_by;
        let mut dragged = friction_by * ring.stretch;
        if MOVES {
            load.position += by.t * friction;
            dragged += friction * by.stretch;
        }
        load.drift += dragged;
        along += (tangential - friction_by) * chain.lead;
        let action = Action {
            load,
            tension: change.tension,
            across,
            along: ring_along + dragged,
            weight,
        };
        self.ring.apply_varied(sum, i + 1, (ring, by), &point.own_load, &action);
        for face in [0, 1] {
            out.speed[face] += along * weight * share::<Lanes>(face, point.right);
        }
    }
}

/// How the station varies before contact is looked at.
#[derive(Clone, Copy, Debug)]
struct Change<'a, const D: usize> {
    by: &'a RingVariation<Lanes, D>,
    chain: &'a ChainVariation<Lanes>,
    flank: &'a FlankVariation,
    /// Of inertia along the belt, and of inertia and push force across it, N/m.
    along: Lanes,
    inward: [Lanes; 2],
    /// Of T, and of T − m_r ṡ², N.
    tension: Lanes,
    pressing: Lanes,
}

/// No forces.
#[inline(always)]
fn nothing() -> CellBalance<Lanes> {
    let zero = Lanes::zero();
    CellBalance {
        speed: [zero; 2],
        axial: zero,
        tilting: [zero; 2],
        torque: zero,
        transport: Transport {
            flow: zero,
            density: zero,
            lag: zero,
        },
    }
}
