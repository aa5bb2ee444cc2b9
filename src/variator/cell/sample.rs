//! Values at a station for outputs, losses and energies.

use crate::contact::traction_slope;
use crate::ring::ale::RingDensity;
use crate::ring::kinematics::{RingPoint, in_plane};
use crate::scalar::{Lanes, Real, Tangent};
use crate::stack::Push;
use crate::variator::cell::state::{CellState, StationForces, StationState};
use crate::variator::law::arguments::CellInput;
use nalgebra::Vector2;

/// Values at a station of a cell, or of one in each lane of `L`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample<L = f64> {
    /// Coordinate ξ of the station, m.
    pub xi: L,
    /// Reference curvature κ there, 1/m: 0 on a strand.
    pub curvature: L,
    /// Reference curvature at the left face of the cell, 1/m.
    pub face_curvature: L,
    /// Curvature κ̂ of the deflected ring in the plane, per dξ, 1/m.
    pub ring_curvature: L,
    /// Quadrature weight dξ, m.
    pub weight: L,
    /// Position of the ring centre line, m.
    pub r: [L; 2],
    /// Pitch radius ϱ about the pulley axis, m.
    pub pitch_radius: L,
    /// Pitch radius at the left face of the cell, m.
    pub face_radius: L,
    /// Pitch-line length λ per dξ.
    pub lambda: L,
    /// Density ν of the cell.
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
    /// Resultant of the contact forces on the belt per ring length, N/m.
    pub resultant: [L; 2],
    /// Tangential sliding speed, m/s.
    pub sliding: L,
    /// Slope of the traction of both flanks over it at constant normal forces, N·s/m².
    pub traction_slope: L,
    /// Distance of the ring from the middle of the pulley, towards its movable sheave, m.
    pub offset: L,
    /// Deflection w along z, m.
    pub lateral: L,
    /// Its slope w'.
    pub lateral_slope: L,
    /// Flow J through the mesh, m/s.
    pub flow: L,
    /// Speed V of the elements, m/s.
    pub speed: L,
    /// Loss by friction on the sheaves, W/m.
    pub sheave_loss: L,
    /// Loss by friction of the ring on the elements, W/m.
    pub ring_loss: L,
    /// Loss by friction between the layers of the ring, W/m.
    pub layer_loss: L,
    /// Loss by elements that start and stop turning, W/m.
    pub rotation_loss: L,
    /// Loss by damping of ring, stack and contact, W/m.
    pub damping_loss: L,
    /// Kinetic energy, J/m.
    pub kinetic: L,
    /// Elastic energy of the ring, J/m.
    pub ring_elastic: L,
    /// Elastic energy of both flanks, J/m.
    pub flank_elastic: L,
    /// Outward deflection from the reference curve, m.
    pub outward: L,
}

/// Calls a macro with all fields of a [`Sample`].
macro_rules! for_each_figure {
    ($with:ident) => {
        $with! {
            xi, curvature, face_curvature, ring_curvature, weight, r[0], r[1], pitch_radius, face_radius, lambda, density, push, tension, normal, axial, torque, resultant[0], resultant[1],
            sliding, traction_slope, offset, lateral, lateral_slope, flow, speed, sheave_loss, ring_loss, layer_loss, rotation_loss, damping_loss,
            kinetic, ring_elastic, flank_elastic, outward
        }
    };
}

impl Sample<Lanes> {
    /// The sample of the cell in a lane.
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
        self.curvature > 0.0
    }
}

/// An evaluated station of a cell.
pub struct AtStation<'a, T: Real, const D: usize = 2> {
    pub given: &'a CellInput<'a, T>,
    pub cell: &'a CellState<T>,
    pub push: &'a Push<T>,
    /// The ring at the left face of the cell.
    pub face: &'a RingPoint<T, D>,
    /// Number of the station in the cell.
    pub index: usize,
    pub station: &'a StationState<T, D>,
    pub forces: &'a StationForces<T, D>,
    /// Energies and damping of the ring.
    pub ring: RingDensity<T>,
}

impl<L, const D: usize> AtStation<'_, L, D>
where
    L: Real<Constant = L>,
    Tangent<1, L>: Real<Constant = L>,
{
    /// The values at the station.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self) -> Sample<L> {
        let Self {
            cell,
            push,
            face,
            forces,
            ring,
            ..
        } = self;
        let StationState {
            ring: point,
            stack,
            weight,
        } = self.station;
        let (flanks, kinematics) = (&forces.flanks, &forces.kinematics);
        let CellInput { law, friction, .. } = *self.given;
        let slope = |k: usize| traction_slope(&law.contact, friction, law.wedge.cos, &flanks.motions[k]);
        let (lateral, lateral_slope) = if D == 2 {
            (L::zero(), L::zero())
        } else {
            (point.r[D - 1], point.slope[D - 1])
        };
        let stack_loss = -(push.viscous * cell.lengthening * cell.inverse_length);
        let from_axis = in_plane(&face.r) - Vector2::new(self.given.geometry.axis, L::zero());
        Sample {
            xi: point.reference.xi.v,
            curvature: point.reference.kappa,
            face_curvature: face.reference.kappa,
            ring_curvature: stack.curvature[0],
            weight: *weight,
            r: [point.r[0], point.r[1]],
            pitch_radius: kinematics.rho,
            face_radius: from_axis.dot(&from_axis).sqrt() - self.given.law.stack.pitch_offset,
            lambda: stack.lambda,
            density: cell.density,
            push: push.force,
            tension: forces.tension,
            normal: flanks.sum.loads.normal * 0.5,
            axial: flanks.sum.on_movable,
            torque: flanks.sum.loads.torque,
            resultant: (kinematics.e_r * flanks.sum.loads.radial
                + kinematics.e_t * flanks.sum.loads.circumferential)
                .into(),
            sliding: kinematics.flank.tangential,
            traction_slope: (slope(0) + slope(1)) * stack.lambda,
            offset: flanks.offset,
            lateral,
            lateral_slope,
            flow: stack.flow,
            speed: stack.speed,
            sheave_loss: flanks.sum.loads.loss,
            ring_loss: forces.ring_friction * forces.sliding,
            layer_loss: forces.layer_drag * forces.ring_speed,
            rotation_loss: forces.rotation_drag * stack.speed,
            damping_loss: ring.viscous + stack_loss + flanks.sum.loads.viscous,
            kinetic: ring.kinetic + forces.mass * forces.belt.v_p.dot(&forces.belt.v_p) * 0.5,
            ring_elastic: ring.membrane + ring.bending,
            flank_elastic: flanks.energy * stack.lambda,
            outward: -((in_plane(&point.r) - point.reference.r).dot(&point.reference.n)),
        }
    }
}
