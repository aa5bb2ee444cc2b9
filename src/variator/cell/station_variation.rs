//! Analytic derivatives at a station of a cell: variations of ring and chain, and of the resulting loads.

use crate::chain::{AccelerationTerms, ChainPoint, ChainVariation};
use crate::contact::FlankMotion;
use crate::ring::kinematics::{LineLoad, RingPoint, RingVariation, embed, in_plane};
use crate::scalar::{Lanes, Real, Tangent, along, zero_vector};
use crate::variator::cell::flank_variation::{FLANK_FORCES, FlankVariation, of_flank, vary_loads};
use crate::variator::cell::laws::{ARGUMENTS, OfStation, StationArguments, StationTangents};
use crate::variator::cell::state::{CellInput, StationForces, StationState};
use crate::variator::law::flanks::FlankSum;
use crate::variator::law::place::{CellBalance, CellLaw};
use crate::variator::law::ring_friction::layer_drag;
use crate::variator::law::spin::spin_drag;
use nalgebra::{SVector, Vector2};

/// A station and the coefficients of its variations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearisedStation<'a, const D: usize> {
    pub ring: &'a RingPoint<Lanes, D>,
    pub chain: &'a ChainPoint<Lanes, D>,
    terms: AccelerationTerms<Lanes>,
    /// Quadrature weight dξ, m.
    pub weight: Lanes,
    /// Weight of the right face in linear interpolation between the faces.
    pub right: Lanes,
    pub forces: &'a StationForces<Lanes, D>,
    /// v_e·e_t and v_p·e_r, m/s.
    crosswise: [Lanes; 2],
    tangents: &'a StationTangents,
    /// Variations of the flanks with ż, ψ_x, ψ_y and ω.
    pub by_pulley: [FlankVariation; 4],
    /// Derivatives of the drag of the ring's layers with respect to T − m_r ṡ² and to the ring's speed along itself.
    d_drag: [Lanes; 2],
    /// Derivatives of the drag of elements that start and stop turning with respect to the throughput and V.
    d_spin: [Lanes; 2],
}

/// Variations at a station from which those of its forces on ring, elements and pulley are computed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StationVariation<'a, const D: usize> {
    pub by: &'a RingVariation<Lanes, D>,
    pub chain: &'a ChainVariation<Lanes>,
    pub flank: &'a FlankVariation,
    /// Variation of inertia and drag of the elements along the belt, and of inertia and push force across it, N/m.
    pub along: Lanes,
    pub inward: [Lanes; 2],
    /// Variation of T, N.
    pub tension: Lanes,
}

/// Density, push force and gradient of V in a cell, with their variations, and that of the throughput.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StackVariation {
    /// Variation of the arguments of the push force.
    pub arguments: [Lanes; ARGUMENTS],
    /// Density ν and its variation.
    pub density: [Lanes; 2],
    /// Push force Q and its variation, N.
    pub push: [Lanes; 2],
    /// ∂V/∂ξ and its variation, 1/s.
    pub gradient: [Lanes; 2],
    /// Variation of the throughput, m/s.
    pub throughput: Lanes,
}

impl<'a, const D: usize> LinearisedStation<'a, D> {
    /// Station `i` of a cell with the `throughput` of elements, with `forces` of these
    /// `tangents`. `factors` are those of acceleration and position.
    #[inline(always)]
    pub fn new(
        given: &CellInput<'_, Lanes>,
        (i, station): (usize, &'a StationState<Lanes, D>),
        throughput: Lanes,
        (forces, tangents): (&'a StationForces<Lanes, D>, &'a StationTangents),
        factors: [f64; 2],
    ) -> Self {
        let StationState { ring, chain, weight } = station;
        let StationForces { v_e, v_p, approach, .. } = forces;
        let drag = layer_drag(
            Tangent::<2>::constant(given.place.layer_drag),
            Tangent::seed(forces.pressing, 0, 1.0),
            Tangent::constant(ring.reference.kappa),
            Tangent::seed(forces.ring_speed, 1, 1.0),
        );
        let spin = spin_drag(
            Tangent::<2>::constant(given.place.spin),
            Tangent::constant(ring.reference.kappa),
            [Tangent::seed(throughput, 0, 1.0), Tangent::seed(chain.speed, 1, 1.0)],
        );
        Self {
            d_spin: spin.eps,
            terms: chain.acceleration_terms(ring),
            weight: *weight,
            right: given.place.stations[i].right,
            crosswise: [in_plane(v_e).dot(&approach.e_t), in_plane(v_p).dot(&approach.e_r)],
            tangents,
            by_pulley: FlankVariation::of_pulley(given, [&ring.r, v_e, v_p].map(in_plane), factors),
            d_drag: drag.eps,
            forces,
            ring,
            chain,
        }
    }

    /// Variation of the inertia of the elements and of their [drag](spin_drag) along the belt, and of inertia and push force along the normals, N/m;
    /// `alpha` is the factor of ẏ.
    #[inline(always)]
    pub fn vary_inertia(
        &self,
        law: &CellLaw,
        alpha: f64,
        (by, d_chain): (&RingVariation<Lanes, D>, &ChainVariation<Lanes>),
        stack: &StackVariation,
    ) -> (Lanes, [Lanes; 2]) {
        let chain = self.chain;
        let [density, d_density] = stack.density;
        let [push, d_push] = stack.push;
        let mass = (d_density * chain.lambda + density * by.stretch) * law.chain.mass_per_length;
        let speed_dot = d_chain.speed * alpha;
        let (a_t, a_n) = chain.vary_acceleration(self.ring, &self.terms, (by, d_chain), speed_dot, stack.gradient);
        let (base_t, base_n) = self.forces.acceleration;
        let mut inward = [Lanes::from(0.0); 2];
        for k in 0..D - 1 {
            inward[k] = mass * base_n[k]
                + self.forces.mass * a_n[k]
                + d_push * chain.curvature[k]
                + push * d_chain.curvature[k];
        }
        let spin = along(&self.d_spin, &[stack.throughput, d_chain.speed]);
        (mass * base_t + self.forces.mass * a_t + spin, inward)
    }

    /// Variation of v_e and v_p where ring (`MOVES`) and chain vary.
    #[inline(always)]
    fn vary_velocities<const MOVES: bool>(
        &self,
        by: &RingVariation<Lanes, D>,
        chain: &ChainVariation<Lanes>,
    ) -> [SVector<Lanes, D>; 2] {
        let (ring, base) = (self.ring, self.chain);
        let mut v_e = ring.t * (chain.speed * base.lead);
        let mut v_p = ring.t * chain.speed;
        if MOVES {
            v_e += ring.t * (base.speed * chain.lead) + by.t * base.ring_line_speed();
            v_p += by.t * base.speed;
            for k in 0..D - 1 {
                let across = by.normals[k] * base.normal_speed[k] + base.normals[k] * chain.normal_speed[k];
                v_e += across;
                v_p += across;
            }
        }
        [v_e, v_p]
    }

    /// Variation of the place on the pulley and of the flanks' motion, where ring (`MOVES`) and chain vary.
    #[inline(always)]
    pub fn vary_approach<const MOVES: bool>(
        &self,
        given: &CellInput<'_, Lanes>,
        by: &RingVariation<Lanes, D>,
        chain: &ChainVariation<Lanes>,
    ) -> FlankVariation {
        let [sin_beta, cos_beta, tan_beta] = given.law.wedge;
        let (at, pulley) = (&self.forces.approach, &given.motion.pulley);
        let mut flank = FlankVariation::of_lambda(by.stretch);
        if MOVES {
            let r = in_plane(&by.r);
            flank.rho = at.e_r.dot(&r);
            flank.turn = at.e_t.dot(&r) * at.inverse_distance;
            flank.opening = at.opening_slope * flank.turn;
            flank.opening_slope = -(at.opening * flank.turn);
        }
        let [v_e, v_p] = self.vary_velocities::<MOVES>(by, chain);
        let v_r = at.e_r.dot(&in_plane(&v_e)) + flank.turn * self.crosswise[0];
        let v_around = at.e_t.dot(&in_plane(&v_p)) - flank.turn * self.crosswise[1];
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
            let [side, _] = given.place.plane;
            flank.offset = [by.r[D - 1] * side, v_e[D - 1] * side];
        }
        flank
    }

    /// Variation of the motion of the flank on the movable sheave; in space also of the flank on the fixed sheave.
    #[inline(always)]
    pub fn vary_motions(&self, given: &CellInput<'_, Lanes>, flank: &FlankVariation) -> [FlankMotion<Lanes>; 2] {
        if D == 2 {
            return [flank.motion; 2];
        }
        let [offset, speed] = flank.offset;
        [1.0, -1.0].map(|sign| flank.motion.shifted(offset * sign, speed * sign, given.law.wedge[0]))
    }

    /// Variation of the loads of both flanks where their place varies by `by` and the forces of each by `forces`.
    #[inline(always)]
    fn vary_flank_loads(
        &self,
        given: &CellInput<'_, Lanes>,
        by: &FlankVariation,
        forces: impl Fn(usize) -> [Lanes; FLANK_FORCES],
    ) -> FlankSum<Lanes> {
        let loads = |flank: usize| {
            let of = (
                &self.forces.approach,
                self.chain.lambda,
                &self.forces.flanks.forces[flank],
            );
            vary_loads(given.law, of, by, forces(flank))
        };
        if D == 2 {
            return FlankSum::alike(&loads(0));
        }
        FlankSum::of(&loads(0), &loads(1), given.place.plane[0])
    }

    /// Variation of the loads of both flanks with the variations `motions` of their motion.
    #[inline(always)]
    pub fn vary_flanks(
        &self,
        given: &CellInput<'_, Lanes>,
        by: &FlankVariation,
        motions: &[FlankMotion<Lanes>; 2],
    ) -> FlankSum<Lanes> {
        self.vary_flank_loads(given, by, |flank| {
            let arguments = of_flank(&motions[flank]);
            self.tangents.flanks[flank]
                .each_ref()
                .map(|tangents| along(tangents, &arguments))
        })
    }

    /// Loads of both flanks at a unit force of one of them; in the plane, of both.
    #[inline(always)]
    pub fn unit_flanks(&self, given: &CellInput<'_, Lanes>, flank: usize, force: usize) -> FlankSum<Lanes> {
        let still = FlankVariation::of_lambda(Lanes::from(0.0));
        let unit = |of: usize| std::array::from_fn(|k| Lanes::from(if (of, k) == (flank, force) { 1.0 } else { 0.0 }));
        self.vary_flank_loads(given, &still, unit)
    }

    /// Adds the variation of the flanks' forces to the load on the ring. Returns the variations, N/m, of the conjugate
    /// of V at the pitch line, with inertia, of that at the ring centre line, and of the force of both flanks in the
    /// plane.
    #[inline(always)]
    pub fn add_flank_forces<const MOVES: bool>(
        &self,
        change: &StationVariation<'_, D>,
        flanks: &FlankSum<Lanes>,
        load: &mut LineLoad<Lanes, D>,
    ) -> ([Lanes; 2], Vector2<Lanes>) {
        let (ring, chain, at) = (self.ring, self.chain, &self.forces.approach);
        let StationVariation { by, flank, .. } = *change;
        let (base, loads) = (&self.forces.flanks.sum.loads, &flanks.loads);
        let mut at_ring_line: SVector<Lanes, D> = zero_vector();
        if D == 3 {
            at_ring_line[D - 1] += flanks.lateral;
        }
        let mut push_out = at.e_r * loads.radial;
        let mut drag = at.e_t * loads.around;
        if MOVES {
            push_out += at.e_t * (flank.turn * base.radial);
            drag -= at.e_r * (flank.turn * base.around);
        }
        at_ring_line -= embed(push_out);
        let mut along = change.along - drag.dot(&in_plane(&ring.t));
        let mut tangential = at_ring_line.dot(&ring.t);
        let base_drag = at.e_t * base.around;
        if MOVES {
            tangential += self.forces.at_ring_line.dot(&by.t);
            along += self.forces.tangential * change.chain.lead - base_drag.dot(&in_plane(&by.t));
        }
        for k in 0..D - 1 {
            let normal = &chain.normals[k];
            let mut inward = change.inward[k] - drag.dot(&in_plane(normal)) + at_ring_line.dot(normal);
            if MOVES {
                inward += self.forces.at_ring_line.dot(&by.normals[k]) - base_drag.dot(&in_plane(&by.normals[k]));
                load.position += by.normals[k] * self.forces.inward[k];
            }
            load.position += normal * inward;
        }
        ([along, tangential], push_out + drag)
    }

    /// Adds the variation of the loads on the pulley; `force` is the variation of the force of both flanks in the
    /// plane, N/m.
    #[inline(always)]
    pub fn add_pulley_loads<const MOVES: bool>(
        &self,
        flank: &FlankVariation,
        flanks: &FlankSum<Lanes>,
        force: Vector2<Lanes>,
        out: &mut CellBalance<Lanes>,
    ) {
        let (at, weight) = (&self.forces.approach, self.weight);
        let [axial, base_axial] = [flanks.loads.axial * 0.5, self.forces.flanks.sum.loads.axial * 0.5];
        let mut moment = at.e_r * (axial * at.rho);
        if MOVES {
            moment += at.e_r * (base_axial * flank.rho) + at.e_t * (base_axial * at.rho * flank.turn);
        }
        out.pulley.add(&flanks.on_pulley(moment, force), weight);
    }

    /// Variations of the friction between ring and elements and of the drag of the ring's layers, N/m, and of the
    /// arguments of the laws; `motions` are the variations of the flanks' motion.
    #[inline(always)]
    pub fn vary_ring_friction<const MOVES: bool>(
        &self,
        change: &StationVariation<'_, D>,
        motions: &[FlankMotion<Lanes>; 2],
    ) -> ([Lanes; 2], StationArguments<Lanes>) {
        let (ring, chain, by) = (self.ring, self.chain, change.by);
        let mut speed = Lanes::from(0.0);
        let mut sliding = -(change.chain.speed * chain.lead);
        if MOVES {
            speed = change.chain.along + ring.w * by.stretch;
            sliding += speed - chain.speed * change.chain.lead;
        }
        let arguments: StationArguments<Lanes> = OfStation {
            flanks: motions.each_ref().map(of_flank),
            ring: [change.tension, sliding],
        };
        let friction = along(&self.tangents.ring, &arguments.ring);
        let drag = along(&self.d_drag, &[change.tension, speed]);
        ([friction, drag], arguments)
    }
}
