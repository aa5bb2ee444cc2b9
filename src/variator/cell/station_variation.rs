//! Analytic derivatives at a station of a cell: variations of ring and stack, and of the resulting
//! loads.

use crate::contact::{FlankForce, FlankMotion};
use crate::ring::kinematics::{LineLoad, RingPoint, RingVariation, embed, in_plane};
use crate::scalar::{Lanes, Real, Tangent, along, zero_vector};
use crate::solver::Factors;
use crate::stack::{StackPoint, StackVariation};
use crate::variator::cell::laws::{Arguments, FORCES, Forces, Tangents, of_flank, of_two};
use crate::variator::cell::state::{CellInput, CellState, StationForces, StationState};
use crate::variator::law::arguments::{CellBalance, CellLaw, PulleyMotion};
use crate::variator::law::element_rotation::rotation_drag;
use crate::variator::law::flanks::{FlankKinematics, FlankLoads, FlankSum};
use crate::variator::law::ring_friction::layer_drag;
use nalgebra::{SVector, Vector2};

/// A station and the coefficients of its variations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearisedStation<'a, const D: usize> {
    pub ring: &'a RingPoint<Lanes, D>,
    pub stack: &'a StackPoint<Lanes>,
    /// Quadrature weight dξ, m.
    pub weight: Lanes,
    /// Weight of the right face in linear interpolation between the faces.
    pub right: Lanes,
    pub forces: &'a StationForces<Lanes, D>,
    /// v_e·e_t and v_p·e_r, m/s.
    crosswise: [Lanes; 2],
    /// Tangents of the laws of flanks and ring.
    tangents: &'a [Tangents],
    /// Variations of the flanks with ż, ψ_x, ψ_y and ω.
    pub by_pulley: [FlankVariation; 4],
    /// Derivatives of the drag of the ring's layers with respect to T − m_r ṡ² and to the ring's
    /// speed along itself.
    d_drag: [Lanes; 2],
    /// Derivatives of the drag of elements that start and stop turning with respect to the
    /// throughput and V.
    d_rotation_drag: [Lanes; 2],
}

/// Variations at a station from which those of its loads on ring, elements and pulley are computed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StationVariation<'a, const D: usize> {
    pub by: &'a RingVariation<Lanes, D>,
    pub stack: &'a StackVariation<Lanes>,
    pub flank: &'a FlankVariation,
    /// Variation of T, N.
    pub tension: Lanes,
    /// Variation of inertia and drag of the elements along the belt, and of inertia and push force
    /// across it, N/m.
    pub along: Lanes,
    pub inward: [Lanes; 2],
    /// Variation of the drag of the ring's layers, N/m.
    pub drag: Lanes,
}

/// Variation of a cell's stack; density ν, push force Q and gradient of V with their variations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellVariation {
    /// Variation of the flow through the left face, m/s.
    pub flow_in: Lanes,
    /// Variation of the arguments of the push force.
    pub arguments: Arguments<Lanes>,
    pub density: [Lanes; 2],
    /// N.
    pub push: [Lanes; 2],
    /// 1/s.
    pub gradient: [Lanes; 2],
    /// Variation of the throughput, m/s.
    pub throughput: Lanes,
}

impl<'a, const D: usize> LinearisedStation<'a, D> {
    /// Station `i` of a `cell`, with `forces` of these `tangents`. `factors` are those of
    /// acceleration and position.
    #[inline(always)]
    pub fn new(
        given: &CellInput<'_, Lanes>,
        cell: &CellState<Lanes>,
        (i, station): (usize, &'a StationState<Lanes, D>),
        (forces, tangents): (&'a StationForces<Lanes, D>, &'a [Tangents]),
        factors: Factors,
    ) -> Self {
        let StationState { ring, stack, weight } = station;
        let StationForces {
            v_e, v_p, kinematics, ..
        } = forces;
        let (seed, plain) = (Tangent::<2>::seed, Tangent::<2>::constant);
        let kappa = plain(ring.reference.kappa);
        let [pressing, ring_speed] = [seed(forces.pressing, 0, 1.0), seed(forces.ring_speed, 1, 1.0)];
        let throughput = [seed(cell.throughput, 0, 1.0), seed(stack.speed, 1, 1.0)];
        Self {
            d_drag: layer_drag(plain(given.geometry.layer_drag), pressing, kappa, ring_speed).eps,
            d_rotation_drag: rotation_drag(plain(given.geometry.rotation_drag), kappa, throughput).eps,
            weight: *weight,
            right: given.geometry.stations[i].right,
            crosswise: [in_plane(v_e).dot(&kinematics.e_t), in_plane(v_p).dot(&kinematics.e_r)],
            by_pulley: FlankVariation::of_pulley(given, [&ring.r, v_e, v_p].map(in_plane), factors),
            tangents,
            forces,
            ring,
            stack,
        }
    }

    /// Variation of inertia and [drag](rotation_drag) of the elements along the belt, and of
    /// inertia and push force along the normals, N/m; `alpha` is the factor of ẏ.
    #[inline(always)]
    pub fn vary_inertia(
        &self,
        law: &CellLaw,
        alpha: f64,
        (by, d_stack): (&RingVariation<Lanes, D>, &StackVariation<Lanes>),
        cell: &CellVariation,
    ) -> (Lanes, [Lanes; 2]) {
        let stack = self.stack;
        let [density, d_density] = cell.density;
        let [push, d_push] = cell.push;
        let mass = (d_density * stack.lambda + density * by.stretch) * law.stack.mass_per_length;
        let (base, speed_dot) = (&self.forces.acceleration, d_stack.speed * alpha);
        let (a_t, a_n) = stack.vary_acceleration(self.ring, base, (by, d_stack), speed_dot, cell.gradient);
        let mut inward = [Lanes::from(0.0); 2];
        for k in 0..D - 1 {
            inward[k] = mass * base.across[k]
                + self.forces.mass * a_n[k]
                + d_push * stack.curvature[k]
                + push * d_stack.curvature[k];
        }
        let rotation_drag = along(&self.d_rotation_drag, &[cell.throughput, d_stack.speed]);
        (mass * base.along + self.forces.mass * a_t + rotation_drag, inward)
    }

    /// Variation of v_e and v_p where ring (`MOVES`) and stack vary.
    #[inline(always)]
    fn vary_velocities<const MOVES: bool>(
        &self,
        by: &RingVariation<Lanes, D>,
        stack: &StackVariation<Lanes>,
    ) -> [SVector<Lanes, D>; 2] {
        let (ring, base) = (self.ring, self.stack);
        let mut v_e = ring.t * (stack.speed * base.lead);
        let mut v_p = ring.t * stack.speed;
        if MOVES {
            v_e += ring.t * (base.speed * stack.lead) + by.t * base.ring_line_speed();
            v_p += by.t * base.speed;
            for k in 0..D - 1 {
                let across = by.normals[k] * base.normal_speed[k] + ring.normals[k] * stack.normal_speed[k];
                v_e += across;
                v_p += across;
            }
        }
        [v_e, v_p]
    }

    /// Variation of the place on the pulley and of the flanks' motion, where ring (`MOVES`) and
    /// stack vary.
    #[inline(always)]
    pub fn vary_kinematics<const MOVES: bool>(
        &self,
        given: &CellInput<'_, Lanes>,
        by: &RingVariation<Lanes, D>,
        stack: &StackVariation<Lanes>,
    ) -> FlankVariation {
        let [sin_beta, cos_beta, tan_beta] = given.law.wedge;
        let (at, pulley) = (&self.forces.kinematics, &given.motion.pulley);
        let mut flank = FlankVariation {
            lambda: by.stretch,
            ..FlankVariation::default()
        };
        if MOVES {
            let r = in_plane(&by.r);
            flank.rho = at.e_r.dot(&r);
            flank.turn = at.e_t.dot(&r) * at.inverse_distance;
            flank.opening = at.opening_slope * flank.turn;
            flank.opening_slope = -(at.opening * flank.turn);
        }
        let [v_e, v_p] = self.vary_velocities::<MOVES>(by, stack);
        let v_r = at.e_r.dot(&in_plane(&v_e)) + flank.turn * self.crosswise[0];
        let v_circumferential = at.e_t.dot(&in_plane(&v_p)) - flank.turn * self.crosswise[1];
        let motion = &mut flank.motion;
        motion.penetration_rate = -((at.opening + tan_beta) * v_r + at.opening_slope * v_circumferential);
        motion.tangential = v_circumferential;
        motion.along_flank = v_r * cos_beta;
        if MOVES {
            let [rate_x, rate_y] = pulley.psi_dot;
            let rate = (rate_x * at.e_r.y + rate_y * at.e_r.x) * at.rho * flank.turn
                + (rate_x * at.e_r.x - rate_y * at.e_r.y) * flank.rho;
            let sliding = flank.rho * at.opening_slope + at.rho * flank.opening_slope;
            motion.penetration = -(flank.rho * tan_beta + flank.opening * at.rho + at.opening * flank.rho);
            motion.penetration_rate -=
                rate + flank.opening * at.v_r + flank.opening_slope * at.v_circumferential;
            motion.tangential -= pulley.omega * flank.rho;
            motion.along_flank -= (rate + pulley.omega * sliding) * sin_beta;
        }
        if D == 3 {
            let [side, _] = given.geometry.plane;
            flank.offset = [by.r[D - 1] * side, v_e[D - 1] * side];
        }
        flank
    }

    /// Writes the variations of the arguments of the `laws` of flanks and ring where T varies by
    /// `tension`. Returns that of the drag of the ring's layers, N/m.
    #[inline(always)]
    pub fn vary_arguments<const MOVES: bool>(
        &self,
        given: &CellInput<'_, Lanes>,
        (by, d_stack): (&RingVariation<Lanes, D>, &StackVariation<Lanes>),
        flank: &FlankVariation,
        tension: Lanes,
        laws: &mut [Arguments<Lanes>],
    ) -> Lanes {
        let stack = self.stack;
        let mut speed = Lanes::from(0.0);
        let mut sliding = -(d_stack.speed * stack.lead);
        if MOVES {
            speed = d_stack.along + self.ring.w * by.stretch;
            sliding += speed - stack.speed * d_stack.lead;
        }
        if D == 2 {
            laws[0] = of_flank(&flank.motion);
        } else {
            let [offset, rate] = flank.offset;
            let shifted =
                |sign: f64| of_flank(&flank.motion.shifted(offset * sign, rate * sign, given.law.wedge[0]));
            (laws[0], laws[1]) = (shifted(1.0), shifted(-1.0));
        }
        laws[D - 1] = of_two([tension, sliding]);
        along(&self.d_drag, &[tension, speed])
    }

    /// Variations of the forces of flanks and ring with those of their arguments, N/m.
    #[inline(always)]
    pub fn vary_forces(&self, arguments: &[Arguments<Lanes>]) -> [Forces; 3] {
        let mut forces = [[Lanes::from(0.0); FORCES]; 3];
        for flank in 0..D - 1 {
            forces[flank] = self.tangents[flank].each_ref().map(|of| along(of, &arguments[flank]));
        }
        forces[D - 1][0] = along(&self.tangents[D - 1][0], &arguments[D - 1]);
        forces
    }

    /// Adds the variation of the flanks' forces to the load on the ring and to those on the pulley.
    /// Returns the variations, N/m, of the conjugate of V at the pitch line, with inertia, and of
    /// that at the ring centre line.
    #[inline(always)]
    pub fn add_flank_forces<const MOVES: bool>(
        &self,
        given: &CellInput<'_, Lanes>,
        change: &StationVariation<'_, D>,
        forces: &[Forces; 3],
        load: &mut LineLoad<Lanes, D>,
        out: &mut CellBalance<Lanes>,
    ) -> [Lanes; 2] {
        let (ring, stack, at) = (self.ring, self.stack, &self.forces.kinematics);
        let StationVariation { by, flank, .. } = *change;
        let vary = |k: usize| {
            let force = &self.forces.flanks.forces[k];
            vary_loads(given.law, (at, stack.lambda, force), flank, forces[k])
        };
        let flanks = if D == 2 {
            FlankSum::symmetric(&vary(0))
        } else {
            FlankSum::new(&vary(0), &vary(1), given.geometry.plane[0])
        };
        let (base, loads) = (&self.forces.flanks.sum.loads, &flanks.loads);
        let mut at_ring_line: SVector<Lanes, D> = zero_vector();
        if D == 3 {
            at_ring_line[D - 1] += flanks.lateral;
        }
        let mut push_out = at.e_r * loads.radial;
        let mut drag = at.e_t * loads.circumferential;
        let mut moment = at.e_r * (loads.axial * 0.5 * at.rho);
        if MOVES {
            push_out += at.e_t * (flank.turn * base.radial);
            drag -= at.e_r * (flank.turn * base.circumferential);
            let axial = base.axial * 0.5;
            moment += at.e_r * (axial * flank.rho) + at.e_t * (axial * at.rho * flank.turn);
        }
        out.pulley.add(&flanks.on_pulley(moment, push_out + drag), self.weight);

        at_ring_line -= embed(push_out);
        let mut along = change.along - drag.dot(&in_plane(&ring.t));
        let mut tangential = at_ring_line.dot(&ring.t);
        let base_drag = at.e_t * base.circumferential;
        if MOVES {
            tangential += self.forces.at_ring_line.dot(&by.t);
            along += self.forces.tangential * change.stack.lead - base_drag.dot(&in_plane(&by.t));
        }
        for k in 0..D - 1 {
            let normal = &ring.normals[k];
            let mut inward = change.inward[k] - drag.dot(&in_plane(normal)) + at_ring_line.dot(normal);
            if MOVES {
                inward +=
                    self.forces.at_ring_line.dot(&by.normals[k]) - base_drag.dot(&in_plane(&by.normals[k]));
                load.position += by.normals[k] * self.forces.inward[k];
            }
            load.position += normal * inward;
        }
        [along, tangential]
    }
}

/// Variation of the loads of a flank with this `force` where its place on the pulley and λ vary by
/// `by`, and its forces by `forces`.
#[inline(always)]
fn vary_loads(
    law: &CellLaw,
    (at, lambda, force): (&FlankKinematics<Lanes>, Lanes, &FlankForce<Lanes>),
    by: &FlankVariation,
    [normal, tangential, along_flank]: Forces,
) -> FlankLoads<Lanes> {
    let [sin_beta, cos_beta, tan_beta] = law.wedge;
    // Per ring length: forces times λ.
    let d_normal = normal * lambda + force.normal * by.lambda;
    let d_tangential = tangential * lambda + force.tangential * by.lambda;
    let d_along = along_flank * lambda + force.along_flank * by.lambda;
    let (axial_normal, d_axial_normal) = (force.normal * lambda * cos_beta, d_normal * cos_beta);
    let axial_friction = force.along_flank * lambda * sin_beta;
    let d_axial_friction = d_along * sin_beta;
    let circumferential = force.tangential * lambda + axial_friction * at.opening_slope;
    let d_circumferential =
        d_tangential + d_axial_friction * at.opening_slope + axial_friction * by.opening_slope;
    FlankLoads {
        radial: d_axial_normal * (at.opening + tan_beta) + axial_normal * by.opening + d_along * cos_beta,
        circumferential: d_axial_normal * at.opening_slope + axial_normal * by.opening_slope + d_tangential,
        torque: -(d_circumferential * at.rho + circumferential * by.rho),
        axial: d_axial_normal - d_axial_friction,
        ..FlankLoads::default()
    }
}

/// Variation of an [`FlankKinematics`] and of λ: the place of a point of the belt on its pulley and
/// the motion of its flanks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FlankVariation {
    /// Motion of a flank in the middle of the pulley.
    pub motion: FlankMotion<Lanes>,
    pub lambda: Lanes,
    pub rho: Lanes,
    pub opening: Lanes,
    pub opening_slope: Lanes,
    /// Angle by which e_r turns towards e_t.
    pub turn: Lanes,
    /// In space: offset from the middle and its rate.
    pub offset: [Lanes; 2],
}

impl FlankVariation {
    /// The variations with ż, ψ_x, ψ_y and ω at a point of the belt, whose place and velocities are
    /// `at`: forward differentiation of its approach. `alpha` and `beta` are the factors of
    /// acceleration and position.
    #[inline(always)]
    pub fn of_pulley(
        given: &CellInput<'_, Lanes>,
        at: [Vector2<Lanes>; 3],
        Factors { alpha, beta }: Factors,
    ) -> [Self; 4] {
        let PulleyMotion {
            z,
            z_dot,
            psi: [x, y],
            psi_dot: [x_dot, y_dot],
            omega,
        } = given.motion.pulley;
        let seed = Tangent::<4>::seed;
        let pulley = PulleyMotion {
            z: seed(z, 0, beta),
            z_dot: seed(z_dot, 0, 1.0),
            psi: [seed(x, 1, 1.0), seed(y, 2, 1.0)],
            psi_dot: [seed(x_dot, 1, alpha), seed(y_dot, 2, alpha)],
            omega: seed(omega, 3, 1.0),
        };
        let at = at.map(|vector| vector.map(Tangent::constant));
        let kinematics = FlankKinematics::new(given.law, given.geometry.axis, &pulley, at);
        std::array::from_fn(|k| Self {
            motion: kinematics.flank.map(|of| of.eps[k]),
            opening: kinematics.opening.eps[k],
            opening_slope: kinematics.opening_slope.eps[k],
            offset: [pulley.z, pulley.z_dot].map(|of| of.eps[k] * 0.5),
            ..Self::default()
        })
    }
}
