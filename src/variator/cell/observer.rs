//! Observers of the evaluation of a cell: they sample it, or record quantities for its derivatives.

use crate::chain::Push;
use crate::contact::energy_density_at;
use crate::ring::kinematics::{RingPoint, in_plane};
use crate::scalar::Real;
use crate::variator::cell::sample::Sample;
use crate::variator::cell::state::{CellInput, CellState, StationForces, StationState};
use crate::variator::law::flanks::BothFlanks;
use crate::variator::rings::ring::CellRing;
use nalgebra::Vector2;

/// Called at every station of a cell during its evaluation.
pub trait StationObserver<T: Real, const D: usize = 2> {
    /// Whether it samples for outputs. A travelling ring then computes its tension at the current state.
    const SAMPLES: bool = false;
    /// Called at a station.
    fn observe<R: CellRing<T, D>>(&mut self, at: &AtStation<'_, T, D, R>);
}

/// An evaluated station of a cell.
pub struct AtStation<'a, T: Real, const D: usize, R> {
    pub given: &'a CellInput<'a, T>,
    pub cell: &'a CellState<T>,
    pub push: &'a Push<T>,
    /// The ring at the left face of the cell.
    pub face: &'a RingPoint<T, D>,
    /// Number of the station in the cell.
    pub index: usize,
    pub station: &'a StationState<T, D>,
    pub forces: &'a StationForces<T, D>,
    pub ring: &'a R,
}

/// An observer that does nothing.
#[derive(Debug)]
pub struct NoObserver;

impl<T: Real, const D: usize> StationObserver<T, D> for NoObserver {
    #[inline(always)]
    fn observe<R: CellRing<T, D>>(&mut self, _at: &AtStation<'_, T, D, R>) {}
}

/// An observer that passes samples to a closure.
pub struct Sampler<'a, T>(pub &'a mut dyn FnMut(Sample<T>));

impl<T: Real, const D: usize> StationObserver<T, D> for Sampler<'_, T> {
    const SAMPLES: bool = true;

    #[inline(always)]
    fn observe<R: CellRing<T, D>>(&mut self, at: &AtStation<'_, T, D, R>) {
        (self.0)(at.sample());
    }
}

impl<T: Real, const D: usize, R: CellRing<T, D>> AtStation<'_, T, D, R> {
    /// The values for outputs, losses and energies.
    #[inline(always)]
    fn sample(&self) -> Sample<T> {
        let Self {
            cell,
            push,
            face,
            forces,
            ring,
            ..
        } = *self;
        let StationState {
            ring: point,
            chain,
            weight,
        } = self.station;
        let (flanks, approach) = (&forces.flanks, &forces.approach);
        let of_ring = ring.density(point);
        let stack_loss = -(push.viscous * cell.lengthening * cell.inverse_length);
        let from_axis = in_plane(&face.r) - Vector2::new(T::constant(self.given.place.axis), T::zero());
        Sample {
            xi: point.reference.xi.v,
            curvature: [point.reference.kappa, face.reference.kappa],
            ring_curvature: chain.curvature[0],
            weight: *weight,
            r: [point.r[0], point.r[1]],
            pitch_radius: approach.rho,
            face_radius: from_axis.dot(&from_axis).sqrt() - self.given.law.chain.pitch_offset,
            lambda: chain.lambda,
            density: cell.density,
            density_rate: cell.stack_arguments()[1],
            push: push.force,
            tension: forces.tension,
            normal: flanks.sum.loads.normal * 0.5,
            axial: flanks.sum.on_movable,
            torque: flanks.sum.loads.torque,
            resultant: (approach.e_r * flanks.sum.loads.radial + approach.e_t * flanks.sum.loads.around).into(),
            sliding: approach.flank.tangential,
            flank_sliding: approach.flank.along_flank,
            ring_sliding: forces.sliding,
            penetration: approach.flank.penetration,
            offset: flanks.offset,
            lateral: if D == 2 {
                [T::zero(); 2]
            } else {
                [point.r[D - 1], point.slope[D - 1]]
            },
            flow: chain.flow,
            speed: chain.speed,
            sheave_loss: flanks.sum.loads.loss,
            ring_loss: forces.ring_friction * forces.sliding,
            layer_loss: forces.layer_drag * forces.ring_speed,
            spin_loss: forces.spin_drag * chain.speed,
            damping_loss: of_ring.viscous + stack_loss + flanks.sum.loads.viscous,
            kinetic: of_ring.kinetic + forces.mass * forces.v_p.dot(&forces.v_p) * 0.5,
            ring_elastic: of_ring.elastic,
            flank_elastic: flank_energy(self.given, flanks) * chain.lambda,
            outward: -((in_plane(&point.r) - point.reference.r).dot(&point.reference.n)),
        }
    }
}

/// Elastic energy of both flanks of an element per pitch-line length, J/m.
#[inline(always)]
fn flank_energy<T: Real>(given: &CellInput<'_, T>, flanks: &BothFlanks<T>) -> T {
    let (contact, cos_beta) = (&given.law.contact, given.law.wedge[1]);
    let of = |k: usize| energy_density_at(contact, cos_beta, flanks.motions[k].penetration, flanks.forces[k].depth);
    of(0) + of(1)
}
