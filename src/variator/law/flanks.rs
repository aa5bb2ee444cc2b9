//! Motion of a point of the belt relative to its pulley, and the loads of its two flanks.

use crate::contact::{FlankForce, FlankMotion, energy_density, flank_force};
use crate::pulley::Wedge;
use crate::ring::kinematics::{embed, in_plane};
use crate::scalar::Real;
use crate::variator::law::arguments::{CellInput, CellLaw, PulleyLoad, PulleyMotion, SheavePlane};
use nalgebra::{SVector, Vector2};
use std::ops::{Add, Sub};

/// Loads of flanks on an element, per ring length.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlankLoads<T> {
    /// Outward force at the ring centre line, N/m.
    pub radial: T,
    /// Force along e_t at the pitch line, N/m.
    pub circumferential: T,
    /// Torque on the pulley, N.
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
    fn plus(&self, other: &Self) -> Self {
        Self {
            radial: self.radial + other.radial,
            circumferential: self.circumferential + other.circumferential,
            torque: self.torque + other.torque,
            axial: self.axial + other.axial,
            normal: self.normal + other.normal,
            loss: self.loss + other.loss,
            viscous: self.viscous + other.viscous,
        }
    }
}

/// Loads of both flanks of an element, per dξ.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlankSum<T> {
    /// The sum.
    pub loads: FlankLoads<T>,
    /// Axial load on the movable sheave, N/m.
    pub on_movable: T,
    /// Lateral load on the ring along z, N/m.
    pub lateral: T,
}

impl<T: Real> FlankSum<T> {
    /// The sum of two equal flanks.
    #[inline(always)]
    pub fn symmetric(one: &FlankLoads<T>) -> Self {
        Self {
            loads: one.plus(one),
            on_movable: one.axial,
            lateral: T::zero(),
        }
    }

    /// The sum of the flank on the movable sheave, on this `side` along z, and of the other one.
    #[inline(always)]
    pub fn new(movable: &FlankLoads<T>, fixed: &FlankLoads<T>, side: T::Constant) -> Self {
        Self {
            loads: movable.plus(fixed),
            on_movable: movable.axial,
            lateral: (movable.axial - fixed.axial) * side,
        }
    }

    /// Forces on the element there.
    #[inline(always)]
    pub fn forces<const D: usize>(&self, at: &FlankKinematics<T>) -> LineForces<T, D> {
        let FlankLoads {
            radial,
            circumferential,
            ..
        } = self.loads;
        LineForces::new(at, [radial, circumferential, self.lateral])
    }

    /// Load on the pulley, per ring length, with the moment of the axial force about the pulley's
    /// centre, N, and the contact force on the belt, N/m.
    #[inline(always)]
    pub fn on_pulley(&self, moment: Vector2<T>, force: Vector2<T>) -> PulleyLoad<T> {
        PulleyLoad {
            axial: self.on_movable,
            tilting: [moment.x, -moment.y],
            torque: self.loads.torque,
            resultant: force.into(),
        }
    }
}

/// Forces on an element, N/m, at the points on which they act.
#[derive(Clone, Copy, Debug)]
pub struct LineForces<T: Real, const D: usize> {
    /// At the pitch line.
    pub pitch: Vector2<T>,
    /// At the ring centre line.
    pub ring: SVector<T, D>,
}

impl<T: Real, const D: usize> LineForces<T, D> {
    /// Of `[radial, circumferential, lateral]` loads per dξ.
    #[inline(always)]
    pub fn new(at: &FlankKinematics<T>, [radial, circumferential, lateral]: [T; 3]) -> Self {
        let mut ring: SVector<T, D> = embed(at.e_r * -radial);
        if D > 2 {
            ring[D - 1] += lateral;
        }
        Self {
            pitch: at.e_t * -circumferential,
            ring,
        }
    }

    /// Variation where e_r turns by `angle` towards e_t.
    #[inline(always)]
    pub fn turned(&self, angle: T) -> Self {
        let turn = |v: Vector2<T>| Vector2::new(v.y, -v.x) * angle;
        Self {
            pitch: turn(self.pitch),
            ring: embed(turn(in_plane(&self.ring))),
        }
    }

    /// Force along `direction`.
    #[inline(always)]
    pub fn along(&self, direction: &SVector<T, D>) -> T {
        self.pitch.dot(&in_plane(direction)) + self.ring.dot(direction)
    }
}

impl<T: Real, const D: usize> Add for LineForces<T, D> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            pitch: self.pitch + other.pitch,
            ring: self.ring + other.ring,
        }
    }
}

impl<T: Real, const D: usize> Sub for LineForces<T, D> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            pitch: self.pitch - other.pitch,
            ring: self.ring - other.ring,
        }
    }
}

/// Both flanks of an element, first that on the movable sheave.
#[derive(Clone, Copy, Debug)]
pub struct BothFlanks<T> {
    /// Their motion.
    pub motions: [FlankMotion<T>; 2],
    /// Their forces.
    pub forces: [FlankForce<T>; 2],
    /// Sum of their loads.
    pub sum: FlankSum<T>,
    /// Elastic energy of both per pitch-line length, J/m.
    pub energy: T,
    /// Distance of the element from the middle, towards the movable sheave, m.
    pub offset: T,
}

/// Place of a point of the belt, and the velocities of an element there.
#[derive(Clone, Copy, Debug)]
pub struct BeltPoint<T: Real, const D: usize> {
    /// Position r of the ring, m.
    pub r: SVector<T, D>,
    /// Velocity v_e at the ring centre line, m/s.
    pub v_e: SVector<T, D>,
    /// Velocity v_p at the pitch line, m/s.
    pub v_p: SVector<T, D>,
}

/// Place of a point of the belt on its pulley, and the motion of its flanks on the sheaves.
#[derive(Clone, Copy, Debug)]
pub struct FlankKinematics<T: Real> {
    /// Unit vector from the axis.
    pub e_r: Vector2<T>,
    /// Unit vector around it, clockwise.
    pub e_t: Vector2<T>,
    /// Reciprocal of the distance of the ring from the axis, 1/m.
    pub inverse_distance: T,
    /// Pitch radius ϱ, m.
    pub rho: T,
    /// ∂w/∂ϱ, elastic opening of the sheave per radius.
    pub opening: T,
    /// (∂w/∂θ)/ϱ, elastic opening per length around the axis.
    pub opening_slope: T,
    /// Radial velocity v_e·e_r at the ring centre line, m/s.
    pub v_r: T,
    /// Velocity v_p·e_t around the axis at the pitch line, m/s.
    pub v_circumferential: T,
    /// Motion of a flank in the middle of the pulley.
    pub flank: FlankMotion<T>,
}

impl<T: Real> FlankKinematics<T> {
    /// The kinematics of a point.
    #[inline(always)]
    pub fn new<const D: usize>(
        law: &CellLaw,
        axis: T::Constant,
        pulley: &PulleyMotion<T>,
        point: &BeltPoint<T, D>,
    ) -> Self {
        let Wedge { sin, cos, tan } = law.wedge;
        let arm = in_plane(&point.r) - Vector2::new(T::constant(axis), T::zero());
        let (distance, inverse_distance) = arm.dot(&arm).root_and_inverse();
        let e_r = arm * inverse_distance;
        let e_t = Vector2::new(e_r.y, -e_r.x);
        let rho = distance - law.stack.pitch_offset;
        let opening = pulley.psi[0] * e_r.x - pulley.psi[1] * e_r.y;
        let opening_rate = (pulley.psi_dot[0] * e_r.x - pulley.psi_dot[1] * e_r.y) * rho;
        let opening_slope = pulley.psi[0] * e_r.y + pulley.psi[1] * e_r.x;
        let v_r = in_plane(&point.v_e).dot(&e_r);
        let v_circumferential = in_plane(&point.v_p).dot(&e_t);
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
            v_circumferential,
            flank: FlankMotion {
                penetration: pulley.z * 0.5 - (rho - law.r0) * tan - opening * rho,
                penetration_rate: surface - (opening + tan) * v_r - opening_slope * v_circumferential,
                tangential: v_circumferential - pulley.omega * rho,
                along_flank: v_r * cos + closing_surface * sin,
            },
        }
    }

    /// Both flanks of an element: equal in the plane; in space the element may be out of the middle.
    #[inline(always)]
    pub fn both_flanks<const D: usize>(
        &self,
        given: &CellInput<'_, T>,
        point: &BeltPoint<T, D>,
        lambda: T,
    ) -> BothFlanks<T> {
        let CellInput { law, friction, .. } = *given;
        let cos = law.wedge.cos;
        let one = |flank: &FlankMotion<T>| {
            let force = flank_force(&law.contact, friction, cos, flank);
            let energy = energy_density(&law.contact, cos, flank.penetration, force.depth);
            (self.loads(law, lambda, flank, &force), force, energy)
        };
        if D == 2 {
            let (loads, force, energy) = one(&self.flank);
            return BothFlanks {
                motions: [self.flank; 2],
                forces: [force; 2],
                sum: FlankSum::symmetric(&loads),
                energy: energy * 2.0,
                offset: T::zero(),
            };
        }
        let SheavePlane { side, middle } = given.geometry.plane;
        let pulley = &given.motion.pulley;
        let offset = (point.r[D - 1] - T::constant(middle)) * side + pulley.z * 0.5;
        let speed = point.v_e[D - 1] * side + pulley.z_dot * 0.5;
        let sin = law.wedge.sin;
        let motions = [
            self.flank.shifted(offset, speed, sin),
            self.flank.shifted(-offset, -speed, sin),
        ];
        let [(movable, force, energy), (fixed, other_force, other_energy)] = motions.each_ref().map(one);
        BothFlanks {
            motions,
            forces: [force, other_force],
            sum: FlankSum::new(&movable, &fixed, side),
            energy: energy + other_energy,
            offset,
        }
    }

    /// Forces on the element of `axial` normal forces per dξ, on the movable sheave and the other.
    #[inline(always)]
    pub fn normal_forces<const D: usize>(
        &self,
        law: &CellLaw,
        [movable, fixed]: [T; 2],
        side: T::Constant,
    ) -> LineForces<T, D> {
        let both = movable + fixed;
        let [radial, circumferential] =
            [self.opening + law.wedge.tan, self.opening_slope].map(|by| both * by);
        LineForces::new(self, [radial, circumferential, (movable - fixed) * side])
    }

    /// Loads of a flank with this motion and this `force`.
    #[inline(always)]
    pub fn loads(
        &self,
        law: &CellLaw,
        lambda: T,
        flank: &FlankMotion<T>,
        force: &FlankForce<T>,
    ) -> FlankLoads<T> {
        let Wedge { sin, cos, tan } = law.wedge;
        let axial_normal = force.normal * cos * lambda;
        let axial_friction = force.along_flank * lambda * sin;
        FlankLoads {
            radial: axial_normal * (self.opening + tan) + force.along_flank * lambda * cos,
            circumferential: axial_normal * self.opening_slope + force.tangential * lambda,
            torque: -(force.tangential * lambda + axial_friction * self.opening_slope) * self.rho,
            axial: axial_normal - axial_friction,
            normal: force.normal * lambda,
            loss: lambda
                * (force.tangential * flank.tangential + force.along_flank * flank.along_flank)
                * -1.0,
            viscous: force.viscous * cos * lambda * flank.penetration_rate,
        }
    }
}
