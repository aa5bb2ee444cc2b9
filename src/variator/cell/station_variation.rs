//! Analytic derivatives at a station of a cell: variations of ring, stack and loads.

use crate::contact::{FlankForce, FlankMotion};
use crate::pulley::Wedge;
use crate::ring::kinematics::{LineLoad, RingPoint, WithRate, in_plane};
use crate::scalar::{Lanes, Real, Tangent, along};
use crate::solver::Factors;
use crate::stack::{Components, PointVariation, StackPoint};
use crate::variator::cell::laws::{Arguments, FORCES, Forces, Tangents, flank_arguments, padded};
use crate::variator::cell::state::{CellState, StationForces, StationState};
use crate::variator::law::arguments::{CellBalance, CellInput, CellLaw, PulleyMotion};
use crate::variator::law::element_rotation::rotation_drag;
use crate::variator::law::flanks::{BeltPoint, FlankKinematics, FlankLoads, FlankSum, LineForces};
use crate::variator::law::ring_friction::layer_drag;

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
    /// v_e·e_t, m/s.
    v_e_circumferential: Lanes,
    /// v_p·e_r, m/s.
    v_p_radial: Lanes,
    /// Tangents of the laws of flanks and ring.
    tangents: &'a [Tangents],
    /// Variations of the flanks with ż, ψ_x, ψ_y and ω.
    pub by_pulley: [FlankVariation; 4],
    /// Derivatives of the drag of the ring's layers with respect to T − m_r ṡ² and to the ring's
    /// speed along itself.
    drag_by_pressing: Lanes,
    drag_by_speed: Lanes,
    /// Derivatives of the drag of elements that start and stop turning with respect to the
    /// throughput and V.
    rotation_drag_by_throughput: Lanes,
    rotation_drag_by_speed: Lanes,
}

/// Variations at a station, for those of its loads on ring, elements and pulley.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StationVariation<'a, const D: usize> {
    pub by: &'a PointVariation<Lanes, D>,
    pub flank: &'a FlankVariation,
    /// T, N.
    pub tension: Lanes,
    /// Inertia and drag of the elements along the belt, inertia and push force along the normals,
    /// N/m.
    pub inertia: Components<Lanes>,
    /// Drag of the ring's layers, N/m.
    pub drag: Lanes,
    /// Forces of flanks and ring, N/m.
    pub forces: [Forces; 3],
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct CellVariation {
    /// Flow through the left face, m/s.
    pub flow_in: Lanes,
    /// ν and its material rate: the arguments of the push force.
    pub density: WithRate<Lanes>,
    /// Push force Q, N.
    pub push: Lanes,
    /// ∂V/∂ξ, 1/s.
    pub speed_gradient: Lanes,
    /// Throughput, m/s.
    pub throughput: Lanes,
}

impl<'a, const D: usize> LinearisedStation<'a, D> {
    /// Station `i` of a `cell`, with `forces` of these `tangents`.
    #[inline(always)]
    pub fn new(
        given: &CellInput<'_, Lanes>,
        cell: &CellState<Lanes>,
        i: usize,
        station: &'a StationState<Lanes, D>,
        forces: &'a StationForces<Lanes, D>,
        tangents: &'a [Tangents],
        factors: Factors,
    ) -> Self {
        let StationState { ring, stack, weight } = station;
        let StationForces { belt, kinematics, .. } = forces;
        let (seed, plain) = (Tangent::<2>::seed, Tangent::<2>::constant);
        let kappa = plain(ring.reference.kappa);
        let (pressing, ring_speed) = (seed(forces.pressing, 0, 1.0), seed(forces.ring_speed, 1, 1.0));
        let coefficient = plain(given.geometry.layer_drag);
        let [drag_by_pressing, drag_by_speed] = layer_drag(coefficient, pressing, kappa, ring_speed).eps;
        let (throughput, speed) = (seed(cell.throughput, 0, 1.0), seed(stack.speed, 1, 1.0));
        let coefficient = plain(given.geometry.rotation_drag);
        let [rotation_drag_by_throughput, rotation_drag_by_speed] =
            rotation_drag(coefficient, kappa, throughput, speed).eps;
        Self {
            drag_by_pressing,
            drag_by_speed,
            rotation_drag_by_throughput,
            rotation_drag_by_speed,
            weight: *weight,
            right: given.geometry.stations[i].right,
            v_e_circumferential: in_plane(&belt.v_e).dot(&kinematics.e_t),
            v_p_radial: in_plane(&belt.v_p).dot(&kinematics.e_r),
            by_pulley: FlankVariation::with_pulley(given, belt, factors),
            tangents,
            forces,
            ring,
            stack,
        }
    }

    /// Variation of [inertia](StationVariation::inertia) in a `cell` with the push force `push`, N.
    #[inline(always)]
    pub fn vary_inertia(
        &self,
        law: &CellLaw,
        alpha: f64,
        by: &PointVariation<Lanes, D>,
        cell: &CellState<Lanes>,
        push: Lanes,
        varied: &CellVariation,
    ) -> Components<Lanes> {
        let (stack, d_stack) = (self.stack, &by.stack);
        let d_mass = (varied.density.value * stack.lambda + cell.density * by.ring.stretch)
            * law.stack.mass_per_length;
        let (base, speed_dot) = (&self.forces.acceleration, d_stack.speed * alpha);
        let gradient = cell.speed_gradient();
        let mut inertia =
            stack.vary_acceleration(self.ring, base, by, speed_dot, gradient, varied.speed_gradient);
        for (k, across) in inertia.across.iter_mut().enumerate().take(D - 1) {
            *across = d_mass * base.across[k]
                + self.forces.mass * *across
                + varied.push * stack.curvature[k]
                + push * d_stack.curvature[k];
        }
        let rotation_drag = self.rotation_drag_by_throughput * varied.throughput
            + self.rotation_drag_by_speed * d_stack.speed;
        inertia.along = d_mass * base.along + self.forces.mass * inertia.along + rotation_drag;
        inertia
    }

    /// Variation of place and velocities where ring (`MOVES`) and stack vary.
    #[inline(always)]
    fn vary_point<const MOVES: bool>(&self, by: &PointVariation<Lanes, D>) -> BeltPoint<Lanes, D> {
        let (ring, base) = (self.ring, self.stack);
        let PointVariation { ring: by, stack } = by;
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
        BeltPoint { r: by.r, v_e, v_p }
    }

    /// Variation of the flanks' kinematics, where ring (`MOVES`) and stack vary.
    #[inline(always)]
    pub fn vary_kinematics<const MOVES: bool>(
        &self,
        given: &CellInput<'_, Lanes>,
        by: &PointVariation<Lanes, D>,
    ) -> FlankVariation {
        let Wedge { sin, cos, tan } = given.law.wedge;
        let (at, pulley) = (&self.forces.kinematics, &given.motion.pulley);
        let mut flank = FlankVariation {
            lambda: by.ring.stretch,
            ..FlankVariation::default()
        };
        let BeltPoint { r, v_e, v_p } = self.vary_point::<MOVES>(by);
        if MOVES {
            let r = in_plane(&r);
            flank.rho = at.e_r.dot(&r);
            flank.turn = at.e_t.dot(&r) * at.inverse_distance;
            flank.opening = at.opening_slope * flank.turn;
            flank.opening_slope = -(at.opening * flank.turn);
        }
        let v_r = at.e_r.dot(&in_plane(&v_e)) + flank.turn * self.v_e_circumferential;
        let v_circumferential = at.e_t.dot(&in_plane(&v_p)) - flank.turn * self.v_p_radial;
        let motion = &mut flank.motion;
        motion.penetration_rate = -((at.opening + tan) * v_r + at.opening_slope * v_circumferential);
        motion.tangential = v_circumferential;
        motion.along_flank = v_r * cos;
        if MOVES {
            let [rate_x, rate_y] = pulley.psi_dot;
            let rate = (rate_x * at.e_r.y + rate_y * at.e_r.x) * at.rho * flank.turn
                + (rate_x * at.e_r.x - rate_y * at.e_r.y) * flank.rho;
            let sliding = flank.rho * at.opening_slope + at.rho * flank.opening_slope;
            motion.penetration = -(flank.rho * tan + flank.opening * at.rho + at.opening * flank.rho);
            motion.penetration_rate -=
                rate + flank.opening * at.v_r + flank.opening_slope * at.v_circumferential;
            motion.tangential -= pulley.omega * flank.rho;
            motion.along_flank -= (rate + pulley.omega * sliding) * sin;
        }
        if D == 3 {
            let side = given.geometry.plane.side;
            flank.offset = r[D - 1] * side;
            flank.offset_rate = v_e[D - 1] * side;
        }
        flank
    }

    /// Writes the variations of the arguments of the laws of flanks and ring, zero for the ring's load,
    /// which follows from those of the flanks. Returns that of the layers' drag, N/m, where T varies
    /// by `tension`.
    #[inline(always)]
    pub fn vary_arguments<const MOVES: bool>(
        &self,
        given: &CellInput<'_, Lanes>,
        by: &PointVariation<Lanes, D>,
        flank: &FlankVariation,
        tension: Lanes,
        laws: &mut [Arguments<Lanes>],
    ) -> Lanes {
        let (stack, d_stack) = (self.stack, &by.stack);
        let mut speed = Lanes::from(0.0);
        let mut sliding = -(d_stack.speed * self.forces.saddle_lead);
        if MOVES {
            speed = d_stack.along + self.ring.w * by.ring.stretch;
            sliding += speed - stack.speed * self.vary_saddle_lead(given, by);
        }
        if D == 2 {
            laws[0] = flank_arguments(&flank.motion);
        } else {
            let (offset, rate, sin) = (flank.offset, flank.offset_rate, given.law.wedge.sin);
            let shifted = |sign: f64| flank_arguments(&flank.motion.shifted(offset * sign, rate * sign, sin));
            (laws[0], laws[1]) = (shifted(1.0), shifted(-1.0));
        }
        laws[D - 1] = padded([Lanes::from(0.0), sliding]);
        self.drag_by_pressing * tension + self.drag_by_speed * speed
    }

    /// Variations of the forces of flanks and ring with those of their arguments, N/m.
    #[inline(always)]
    pub fn vary_forces(&self, arguments: &[Arguments<Lanes>]) -> [Forces; 3] {
        let mut forces = [[Lanes::from(0.0); FORCES]; 3];
        for flank in 0..D - 1 {
            forces[flank] = self.tangents[flank]
                .each_ref()
                .map(|slopes| along(slopes, &arguments[flank]));
        }
        forces[D - 1][0] = along(&self.tangents[D - 1][0], &arguments[D - 1]);
        forces
    }

    /// Adds the variation of the flanks' forces to the load on the ring and to those on the pulley.
    /// Returns those of inertia less forces along the belt, without the energy of the flanks, of ring
    /// friction and of its load, N/m.
    #[inline(always)]
    pub fn add_flank_forces<const MOVES: bool>(
        &self,
        given: &CellInput<'_, Lanes>,
        change: &StationVariation<'_, D>,
        load: &mut LineLoad<Lanes, D>,
        out: &mut CellBalance<Lanes>,
    ) -> [Lanes; 3] {
        let (ring, stack, at) = (self.ring, self.stack, &self.forces.kinematics);
        let (law, flanks) = (given.law, &self.forces.flanks);
        let StationVariation { flank, inertia, .. } = change;
        let PointVariation {
            ring: by,
            stack: d_stack,
        } = change.by;
        let vary = |k: usize| {
            let force = &flanks.forces[k];
            vary_loads(law, at, stack.lambda, force, flank, change.forces[k])
        };
        let all = if D == 2 {
            FlankSum::symmetric(&vary(0))
        } else {
            FlankSum::new(&vary(0), &vary(1), given.geometry.plane.side)
        };
        let mut of_flanks = all.forces::<D>(at);
        let mut on_speed = of_flanks;
        if !law.is_pull_chain() {
            let cos = law.wedge.cos;
            let elastic = flanks.forces.map(|force| force.elastic() * cos);
            let by = |k: usize| change.forces[k][0] * cos * stack.lambda + elastic[k] * flank.lambda;
            let varied = at.normal_forces(law, [by(0), by(D - 2)], given.geometry.plane.side);
            let both = (elastic[0] + elastic[1]) * stack.lambda;
            let tilted = [flank.opening, flank.opening_slope, Lanes::from(0.0)].map(|by| both * by);
            on_speed = on_speed - varied - LineForces::new(at, tilted);
        }
        if MOVES {
            of_flanks = of_flanks + self.forces.of_flanks.turned(flank.turn);
            on_speed = on_speed + self.forces.on_speed.turned(flank.turn);
        }
        let mut moment = at.e_r * (all.loads.axial * 0.5 * at.rho);
        if MOVES {
            let axial = flanks.sum.loads.axial * 0.5;
            moment += at.e_r * (axial * flank.rho) + at.e_t * (axial * at.rho * flank.turn);
        }
        let resultant = -(of_flanks.pitch + in_plane(&of_flanks.ring));
        out.pulley.add(&all.on_pulley(moment, resultant), self.weight);

        let base = &self.forces.on_speed;
        let mut along = inertia.along + on_speed.pitch.dot(&in_plane(&ring.t));
        let mut tangential = on_speed.ring.dot(&ring.t);
        if MOVES {
            tangential += base.ring.dot(&by.t);
            along += base.ring.dot(&ring.t) * d_stack.lead + base.pitch.dot(&in_plane(&by.t))
                - self.forces.ring_friction * self.vary_saddle_lead(given, change.by);
        }
        let mut d_load = Lanes::from(0.0);
        for k in 0..D - 1 {
            let normal = &ring.normals[k];
            let mut inward = inertia.across[k] + of_flanks.along(normal);
            if MOVES {
                inward += self.forces.of_flanks.along(&by.normals[k]);
                load.position += by.normals[k] * self.forces.inward[k];
            }
            load.position += normal * inward;
            if k == 0 {
                d_load = inward;
            }
        }
        let d_friction = change.forces[D - 1][0] + self.tangents[D - 1][0][0] * d_load;
        along += tangential * stack.lead - d_friction * self.forces.saddle_lead;
        [along, d_friction, d_load]
    }

    /// Variation of the elastic energy of the flanks per pitch-line length, J/m.
    #[inline(always)]
    pub fn vary_energy(&self, given: &CellInput<'_, Lanes>, flank: &FlankVariation) -> Lanes {
        let one = |k: usize, penetration: Lanes| {
            let force = &self.forces.flanks.forces[k];
            force.elastic() * penetration * given.law.wedge.cos
        };
        let (middle, offset) = (flank.motion.penetration, flank.offset);
        one(0, middle + offset) + one(1, middle - offset)
    }

    /// δ(λ₁/λ), with λ₁ = λ + e₁ κ̂: λ varies as |r'| does.
    #[inline(always)]
    fn vary_saddle_lead(&self, given: &CellInput<'_, Lanes>, by: &PointVariation<Lanes, D>) -> Lanes {
        let turning = by.stack.curvature[0] * given.law.saddle_offset;
        (turning + by.ring.stretch * (-self.forces.saddle_lead + 1.0)) * self.stack.inverse_lambda
    }
}

/// Variation of the loads of a flank with this `force` where its place on the pulley and λ vary by
/// `by`, and its forces by `forces`.
#[inline(always)]
fn vary_loads(
    law: &CellLaw,
    at: &FlankKinematics<Lanes>,
    lambda: Lanes,
    force: &FlankForce<Lanes>,
    by: &FlankVariation,
    [elastic, viscous, tangential, along_flank]: Forces,
) -> FlankLoads<Lanes> {
    let Wedge { sin, cos, tan } = law.wedge;
    // Per ring length: forces times λ.
    let d_normal = (elastic + viscous) * lambda + force.normal * by.lambda;
    let d_tangential = tangential * lambda + force.tangential * by.lambda;
    let d_along = along_flank * lambda + force.along_flank * by.lambda;
    let (axial_normal, d_axial_normal) = (force.normal * lambda * cos, d_normal * cos);
    let axial_friction = force.along_flank * lambda * sin;
    let d_axial_friction = d_along * sin;
    let circumferential = force.tangential * lambda + axial_friction * at.opening_slope;
    let d_circumferential =
        d_tangential + d_axial_friction * at.opening_slope + axial_friction * by.opening_slope;
    FlankLoads {
        radial: d_axial_normal * (at.opening + tan) + axial_normal * by.opening + d_along * cos,
        circumferential: d_axial_normal * at.opening_slope + axial_normal * by.opening_slope + d_tangential,
        torque: -(d_circumferential * at.rho + circumferential * by.rho),
        axial: d_axial_normal - d_axial_friction,
        ..FlankLoads::default()
    }
}

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
    /// In space: offset from the middle, and its rate.
    pub offset: Lanes,
    pub offset_rate: Lanes,
}

impl FlankVariation {
    /// The variations with ż, ψ_x, ψ_y and ω at a point of the belt, by forward differentiation of
    /// its kinematics.
    #[inline(always)]
    pub fn with_pulley<const D: usize>(
        given: &CellInput<'_, Lanes>,
        point: &BeltPoint<Lanes, D>,
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
        let point = BeltPoint {
            r: point.r.map(Tangent::constant),
            v_e: point.v_e.map(Tangent::constant),
            v_p: point.v_p.map(Tangent::constant),
        };
        let kinematics = FlankKinematics::new(given.law, given.geometry.axis, &pulley, &point);
        std::array::from_fn(|k| Self {
            motion: kinematics.flank.map(|figure| figure.eps[k]),
            opening: kinematics.opening.eps[k],
            opening_slope: kinematics.opening_slope.eps[k],
            offset: pulley.z.eps[k] * 0.5,
            offset_rate: pulley.z_dot.eps[k] * 0.5,
            ..Self::default()
        })
    }
}
