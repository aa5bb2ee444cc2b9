//! The ring (paper 3, 4): mesh, kinematics with its virtual power, the beam law.

pub mod ale;
pub mod kinematics;
pub mod layers;
pub mod mesh;
pub mod stress;

pub use layers::{Joints, Layers};

/// The ring sets, modelled as one beam.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ring {
    /// Mass m_r per length, kg/m.
    pub mass_per_length: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Bending stiffness EI_n in the plane of the drive, N·m².
    pub bending_stiffness: f64,
    /// Bending stiffness EI_b out of the plane of the drive, N·m²; used by rings that deflect in
    /// space.
    pub lateral_bending_stiffness: f64,
    /// Kelvin–Voigt damping time η of strain and bending, s.
    pub damping: f64,
}

impl Ring {
    /// EA η, N·s.
    #[must_use]
    pub fn viscosity(&self) -> f64 {
        self.axial_stiffness * self.damping
    }
}
