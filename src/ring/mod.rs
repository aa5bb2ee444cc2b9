//! The ring (paper 3, 4): kinematics with its virtual power, and the beam law.

pub mod ale;
pub mod kinematics;
