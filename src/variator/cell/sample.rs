//! Values at a station for outputs, losses and energies.

use crate::scalar::{Lanes, Real};

/// Values at a station for outputs, losses and energies: of one cell, or of one in each lane of `L`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample<L = f64> {
    /// Place ξ of the station, m.
    pub xi: L,
    /// Reference curvature κ there and at the left face of the cell, 1/m: 0 on a strand.
    pub curvature: [L; 2],
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
    /// Material rate of the density Dν/Dt, 1/s.
    pub density_rate: L,
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
    /// Sliding speed along the flank, m/s.
    pub flank_sliding: L,
    /// Sliding speed of the ring on the elements, m/s.
    pub ring_sliding: L,
    /// Penetration g of a flank in the middle of the pulley, m.
    pub penetration: L,
    /// Distance of the ring from the middle of the pulley, towards its movable sheave, m; 0 in the plane.
    pub offset: L,
    /// Deflection w along z, m, and its slope w'.
    pub lateral: [L; 2],
    /// Flow J through the mesh, m/s.
    pub flow: L,
    /// Speed V of the elements, m/s.
    pub speed: L,
    /// Loss to sheave friction, W/m.
    pub sheave_loss: L,
    /// Loss to ring friction, W/m.
    pub ring_loss: L,
    /// Loss to friction between the layers of the ring, W/m.
    pub layer_loss: L,
    /// Loss to elements that start and stop turning, W/m.
    pub spin_loss: L,
    /// Loss to structural, chain and contact damping, W/m.
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
            xi, curvature[0], curvature[1], ring_curvature, weight, r[0], r[1], pitch_radius, face_radius, lambda, density, density_rate, push, tension, normal, axial, torque, resultant[0], resultant[1],
            sliding, flank_sliding, ring_sliding, penetration, offset, lateral[0], lateral[1], flow, speed, sheave_loss, ring_loss, layer_loss, spin_loss, damping_loss,
            kinetic, ring_elastic, flank_elastic, outward
        }
    };
}

impl Sample<Lanes> {
    /// The sample of the cell in a lane. Inlining removes reads of unused values.
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
