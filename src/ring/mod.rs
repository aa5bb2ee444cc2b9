//! The ring (paper 3, 4): mesh, kinematics with its virtual power, the beam law, and the ring alone as a system.

pub mod ale;
pub mod kinematics;
pub mod mesh;
pub mod system;

/// The ring sets, as one planar beam.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Mass m_r per length, kg/m.
    pub mass_per_length: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Bending stiffness EI_n in the plane of the drive, N·m².
    pub bending_stiffness: f64,
    /// Kelvin–Voigt damping time η of the axial strain, s.
    pub damping: f64,
}
